"""What a run learns with: its rates, its optimiser, its identity, the memory that is free."""

from pathlib import Path

import pytest
import torch
from torch import nn

from lidardraft.errors import TrainingError
from lidardraft.training.learner import LearningConfig, Muon, RunIdentity, orthogonalised


def test_the_rate_rises_stays_and_falls() -> None:
    config = LearningConfig(steps=100, batch=1, warmup=10, decay=0.2, learning_rate=1.0)
    assert [config.rate(step) for step in (0, 9, 50, 80, 90, 99)] == pytest.approx([0.1, 1, 1, 1, 0.5, 0.05])


@pytest.mark.parametrize(
    ("begun", "message"),
    [
        (RunIdentity({"seed": 0}, 1, 3, "old"), "begun with the pairs of old, which are not those of new"),
        (RunIdentity({"seed": 0}, 3, 2, "old"), r"begun with other weights \(--init, or the base of a ControlNet\)"),
        (RunIdentity({"seed": 5}, 1, 2, "old"), "with another config: its seed is 5, not 0"),
        (RunIdentity({"seed": 0, "crop": 8}, 1, 2, "old"), "with another config: its crop is 8, not None"),
    ],
)
def test_what_differs_from_how_a_run_was_begun_is_named(begun: RunIdentity, message: str) -> None:
    now = RunIdentity({"seed": 0}, 1, 2, "new")
    now.check(Path("state"), RunIdentity({"seed": 0}, 1, 2, "old"))  # the pairs were moved
    with pytest.raises(TrainingError, match=f"state is the state of a run {message}; use another folder"):
        now.check(Path("state"), begun)


@pytest.mark.parametrize("name", ["steps", "batch", "save_every", "report_every"])
def test_counts_that_cannot_be(name: str) -> None:
    fields = {"steps": 1, "batch": 1, "learning_rate": 0.1, name: 0}
    with pytest.raises(TrainingError, match=f"{name} is 0; it must be at least 1"):
        LearningConfig(**fields).check_counts()


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
