"""The optimiser, against matrices and problems that are known."""

import pytest
import torch
from torch import nn

from lidardraft.training.muon import Muon, orthogonalised


@pytest.fixture(autouse=True)
def seeded() -> None:
    torch.manual_seed(0)


@pytest.mark.parametrize("shape", [(64, 16), (16, 64), (32, 32), (48, 9 * 32)])
def test_an_orthogonalised_matrix_has_singular_values_about_one(shape: tuple[int, int]) -> None:
    matrix = 1e-3 * torch.randn(shape) @ torch.diag(torch.linspace(0.3, 1.0, shape[1]))
    found = orthogonalised(matrix)
    assert found.shape == shape
    values = torch.linalg.svdvals(found)
    assert 0.6 < values.min() < values.max() < 1.3
    # in the directions of the matrix itself
    u, _, v = torch.linalg.svd(matrix, full_matrices=False)
    turned = u.T @ found @ v.T
    assert (turned - torch.diag(turned.diagonal())).abs().max() < 1e-3


def test_a_matrix_of_zeros_moves_nowhere() -> None:
    assert not orthogonalised(torch.zeros(16, 32)).any()


def test_a_least_squares_problem_is_solved() -> None:
    network = nn.Sequential(nn.Linear(32, 64), nn.Linear(64, 16))
    x = torch.randn(256, 32)
    y = x @ torch.randn(32, 16) + 3
    optimiser = Muon(network.parameters(), lr=0.1, weight_decay=0.0)
    losses = []
    for step in range(200):
        for group in optimiser.param_groups:
            group["lr"] = 0.1 * (1 - step / 200)
        loss = (network(x) - y).square().mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        losses.append(loss.item())
    assert losses[-1] < 0.01 * losses[0]


def test_a_matrix_moves_as_far_whatever_the_scale_of_its_gradient() -> None:
    moved = []
    for scale in (1e-4, 1e4):
        torch.manual_seed(1)
        weight = nn.Parameter(torch.zeros(32, 16, 1, 1))
        weight.grad = scale * torch.randn(32, 16, 1, 1)
        Muon([weight], lr=0.5, weight_decay=0.0).step()
        moved.append(weight.detach().clone())
    torch.testing.assert_close(moved[0], moved[1], rtol=1e-2, atol=1e-3)
    # of a tall matrix, by its learning rate times the root of how tall it is
    values = torch.linalg.svdvals(moved[0].flatten(1)) / (0.5 * 2**0.5)
    assert 0.6 < values.min() < values.max() < 1.3


def test_small_and_flat_weights_are_adams_with_a_tenth_of_the_rate_and_do_not_decay() -> None:
    bias, narrow, alone = (nn.Parameter(torch.ones(shape)) for shape in ((40,), (15, 99), (7,)))
    reference = nn.Parameter(torch.ones(40))
    ours = Muon([bias, narrow, alone], lr=0.2, weight_decay=0.5)
    adam = torch.optim.Adam([reference], lr=0.02, betas=(0.9, 0.99))
    for _ in range(5):
        bias.grad, narrow.grad = torch.randn(40), torch.randn(15, 99)
        reference.grad = bias.grad.clone()
        ours.step()
        adam.step()
    torch.testing.assert_close(bias, reference)
    assert ((narrow - 1).abs() < 5.1 * 0.02).all()
    assert (alone == 1).all()  # without a gradient


def test_matrices_decay() -> None:
    weight = nn.Parameter(torch.ones(16, 16))
    weight.grad = torch.zeros(16, 16)
    Muon([weight], lr=0.1, weight_decay=0.5).step()
    torch.testing.assert_close(weight.detach(), torch.full((16, 16), 0.95))
