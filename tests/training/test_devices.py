"""What a device learns that works in other numbers than float32 on a CPU: as much, from the same batches."""

import copy
import dataclasses
import warnings

import pytest
import torch
from torch import Tensor

from lidardraft.training import denoising, recipes
from lidardraft.training.learner import Learner
from lidardraft.training.processes import ALONE
from lidardraft.training.sources import PairFolder, placed

CPU = torch.device("cpu")
GPU = pytest.param("cuda", marks=pytest.mark.skipif(not torch.cuda.is_available(), reason="this machine has no GPU"))
STEPS = 20
*_, CONTROL = recipes.tiny()
CONDITIONED = dataclasses.replace(CONTROL, denoiser=dataclasses.replace(CONTROL.denoiser, controlnet=False))
LOSS, MEAN_LOSS = 0.1, 0.02  # how far a step's loss, and the mean of all, may be off: the width of bfloat16


def losses(pairs: PairFolder, device: torch.device, *, in_bfloat16: bool) -> Tensor:
    """The loss of each of 20 steps on a device, from batches of a CPU, as each device draws its own noise."""
    config = dataclasses.replace(CONDITIONED, steps=STEPS, batch=8, learning_rate=0.02, thinnings=(1,))
    denoiser = denoising.beginning(config, None).to(device).train()
    learner, found = Learner(denoiser, config), []
    for step in range(STEPS):
        made = denoising._batch(config, step, source=pairs, processes=ALONE, device=CPU)
        *tensors, wraps = (part.to(device) if isinstance(part, Tensor) else part for part in made)
        with torch.autocast(device.type, dtype=torch.bfloat16, enabled=in_bfloat16):
            each = denoiser.loss(*tensors, wraps=bool(wraps))
        learner.step(step, each)
        found.append(each.detach().mean().cpu())
    return torch.stack(found)


@pytest.mark.parametrize("name", ["cpu", GPU])
def test_twenty_steps_in_bfloat16_learn_what_those_in_float32_learn(name: str, pairs: PairFolder) -> None:
    expected = losses(pairs, CPU, in_bfloat16=False)
    found = losses(pairs, torch.device(name), in_bfloat16=True)
    assert not torch.equal(found, expected)
    torch.testing.assert_close(found, expected, rtol=LOSS, atol=0)
    assert found.mean().item() == pytest.approx(expected.mean().item(), rel=MEAN_LOSS)
    assert expected[-5:].mean() < 0.9 * expected[:5].mean()  # and it is something


@pytest.mark.parametrize("name", [GPU])
def test_a_gpu_makes_the_batch_of_a_cpu_but_for_its_noise(name: str, pairs: PairFolder) -> None:
    config = dataclasses.replace(CONDITIONED, batch=8)
    for step in range(4):
        one, other = (
            denoising._batch(config, step, source=copy.copy(pairs), processes=ALONE, device=torch.device(device))
            for device in ("cpu", name)
        )
        for part in ("clean", "sigma", "rays", "condition"):
            torch.testing.assert_close(getattr(other, part).cpu(), getattr(one, part), atol=1e-5, rtol=0)
        assert one.noise.shape == other.noise.shape


def test_pairs_that_fill_a_gpu_stay_in_the_memory_of_the_host(monkeypatch: pytest.MonkeyPatch) -> None:
    # All of the GPU that is asked: how much is free, and to read from the memory of the host.
    pinned = []
    monkeypatch.setattr(torch.cuda, "mem_get_info", lambda _: (150, 1000))
    monkeypatch.setattr(Tensor, "pin_memory", lambda tensor: pinned.append(tensor) or tensor)
    images = {name: torch.zeros(40, dtype=torch.uint8) for name in ("one", "two")}
    with pytest.warns(UserWarning, match=r"^the pairs take 0\.0 GB, and cuda has 0\.0 GB free: they stay") as told:
        kept = placed(images, torch.device("cuda"))
    assert len(told) == 1
    assert [tensor.data_ptr() for tensor in pinned] == [tensor.data_ptr() for tensor in images.values()]
    assert kept.keys() == images.keys()
    with warnings.catch_warnings(action="error"):
        assert placed(images, CPU) is images
