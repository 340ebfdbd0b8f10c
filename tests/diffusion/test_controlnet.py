import dataclasses

import torch

from lidardraft.diffusion.codec import CONDITION_CHANNELS
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig

CONFIG = DenoiserConfig(
    cell=(2, 4),
    widths=(8, 16),
    strides=(1, 2),
    dilations=(1, 1),
    condition=("class", "depth"),
    controlnet=True,
    copy_gate=False,
)


@torch.no_grad()
def test_a_fresh_controlnet_leaves_the_base_bit_identical() -> None:
    torch.manual_seed(0)
    base = Denoiser.from_config(dataclasses.replace(CONFIG, condition=(), controlnet=False)).eval()
    for weight in base.parameters():
        weight += 0.1 * torch.randn_like(weight)
    x, sigma, rays = torch.randn(2, 3, 16, 64), torch.tensor([0.1, 2.0]), torch.rand(4, 16, 64)
    condition = torch.rand(2, CONDITION_CHANNELS, 16, 64)
    before = base.denoise(x, sigma, rays, wraps=True)
    controlled = base.with_controlnet(CONFIG)
    assert torch.equal(controlled.denoise(x, sigma, rays, condition, wraps=True), before)
    assert torch.equal(controlled.denoise(x, sigma, rays, wraps=True), before)
    assert controlled.controlnet is not None
    for copy, original in zip(
        controlled.controlnet.encoder.parameters(), base.network.encoder.parameters(), strict=True
    ):
        assert torch.equal(copy, original)
        assert copy.data_ptr() != original.data_ptr()
        assert (copy.requires_grad, original.requires_grad) == (True, False)
    assert [name for name, _ in controlled.controlnet.zero_convs()][:2] == ["enter", "leave.0"]


@torch.no_grad()
def test_an_open_controlnet_sees_its_part_of_the_condition() -> None:
    torch.manual_seed(0)
    denoiser = Denoiser.from_config(CONFIG).eval()
    for weight in denoiser.parameters():
        weight += 0.1 * torch.randn_like(weight)
    x, sigma, rays = torch.randn(1, 3, 16, 64), torch.tensor([0.5]), torch.rand(4, 16, 64)
    condition = torch.rand(1, CONDITION_CHANNELS, 16, 64)
    y = denoiser.denoise(x, sigma, rays, condition, wraps=True)
    unseen, seen = condition.clone(), condition.clone()
    unseen[:, -3:] += 1  # the simulated scan
    seen[:, 3] += 1
    assert torch.equal(denoiser.denoise(x, sigma, rays, unseen, wraps=True), y)
    assert not torch.allclose(denoiser.denoise(x, sigma, rays, seen, wraps=True), y)
