import dataclasses

import torch

from lidardraft.diffusion.channels import CONDITION_PARTS, INTENSITY, RAY_CHANNELS, STATE_CHANNELS
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig

CONFIG = DenoiserConfig(
    cell=(2, 4),
    widths=(8, 16),
    strides=(1, 2),
    dilations=(1, 1),
    condition=("depth", "class"),
    controlnet=True,
)
RAYS = torch.rand(RAY_CHANNELS, 16, 64)


def with_all_weights_random(denoiser: Denoiser) -> Denoiser:
    with torch.no_grad():
        for weight in denoiser.parameters():
            weight += 0.1 * torch.randn_like(weight)
    return denoiser.eval()


@torch.no_grad()
def test_a_fresh_controlnet_leaves_the_base_bit_identical() -> None:
    torch.manual_seed(0)
    base = with_all_weights_random(Denoiser.from_config(dataclasses.replace(CONFIG, condition=(), controlnet=False)))
    x, sigma = torch.randn(2, STATE_CHANNELS, 16, 64), torch.tensor([0.1, 2.0])
    condition = torch.rand(2, STATE_CHANNELS, 16, 64)
    before = base.denoise(x, sigma, RAYS, wraps=True)
    controlled = base.with_controlnet(CONFIG)
    assert torch.equal(controlled.denoise(x, sigma, RAYS, condition, wraps=True), before)
    assert torch.equal(controlled.denoise(x, sigma, RAYS, wraps=True), before)
    assert controlled.controlnet is not None
    for copy, original in zip(
        controlled.controlnet.encoder.parameters(), base.network.encoder.parameters(), strict=True
    ):
        assert torch.equal(copy, original)
        assert copy.data_ptr() != original.data_ptr()
        assert (copy.requires_grad, original.requires_grad) == (True, False)
    assert [name for name, _ in controlled.controlnet.zero_convs()] == ["leave.0", "leave.1", "leave.2"]


@torch.no_grad()
def test_a_controlnet_sees_the_parts_of_the_cast_and_no_intensity() -> None:
    torch.manual_seed(0)
    denoiser = with_all_weights_random(Denoiser.from_config(CONFIG))
    x, sigma = torch.randn(1, STATE_CHANNELS, 16, 64), torch.tensor([0.5])
    condition = torch.rand(1, STATE_CHANNELS, 16, 64)
    y = denoiser.denoise(x, sigma, RAYS, condition, wraps=True)
    for part, channels in (CONDITION_PARTS | {"intensity": [INTENSITY]}).items():
        other = condition.clone()
        other[:, channels] += 1
        assert torch.equal(denoiser.denoise(x, sigma, RAYS, other, wraps=True), y) == (part == "intensity"), part


@torch.no_grad()
def test_what_is_read_of_a_condition_serves_every_noise_level() -> None:
    torch.manual_seed(0)
    denoiser = with_all_weights_random(Denoiser.from_config(CONFIG))
    condition = torch.rand(1, STATE_CHANNELS, 16, 64)
    reading = denoiser.read(condition, RAYS, wraps=True)
    for sigma in (torch.tensor([0.05]), torch.tensor([5.0])):
        x = torch.randn(1, STATE_CHANNELS, 16, 64)
        fresh = denoiser.denoise(x, sigma, RAYS, condition, wraps=True)
        assert torch.equal(denoiser.denoise(x, sigma, RAYS, condition, wraps=True, reading=reading), fresh)
    assert denoiser.base().read(condition, RAYS, wraps=True) is None


def test_the_deep_stages_are_reached_by_a_gradient_that_is_not_zero() -> None:
    torch.manual_seed(0)
    denoiser = Denoiser.from_config(CONFIG)
    with torch.no_grad():  # sums that drift far off, as those of long trainings do
        for name, weight in denoiser.network.named_parameters():
            if "fuse" in name and name.endswith("bias"):
                weight -= 100.0
        denoiser.network.head.weight.normal_()
    x, condition = torch.randn(1, STATE_CHANNELS, 16, 64), torch.rand(1, STATE_CHANNELS, 16, 64)
    denoiser.loss(x, torch.ones(1), torch.randn_like(x), RAYS, condition, wraps=True).backward()
    assert denoiser.controlnet is not None
    for name, conv in denoiser.controlnet.zero_convs():
        assert conv.weight.grad is not None
        assert conv.weight.grad.norm() > 1e-6, name
