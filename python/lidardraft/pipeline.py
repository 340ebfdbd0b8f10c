"""The product in one screen: draft, raycast, simulate, generate, label."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from lidardraft.diffusion.codec import decode_scan, encode_condition
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.postprocess import postprocess
from lidardraft.diffusion.sampler import sample
from lidardraft.diffusion.sampling_defaults import START, STEPS
from lidardraft.drafting.text import layout_from_text
from lidardraft.errors import CheckpointError, check_type, one_of
from lidardraft.networks import weight_file
from lidardraft.scan import Scan
from lidardraft.scene.labelling import label_by_agreement
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_limits import SensorLimits
from lidardraft.simulation.simulate import simulate

WEIGHTS = Path(__file__).parent / "weights"
_POSTPROCESS_STREAM = 7  # random numbers of the postprocessing, apart from the sampler's


class Pipeline:
    """A denoiser, ready to turn sentences and layouts into scans, of an hdl64e where no sensor is given.

    A scan is sampled in `steps` calls of the network, from the simulated scan of the layout under noise of the level
    `start`; None is from pure noise, which takes more, and so do weights that do not see the simulated scan. `langevin`
    is the number of updates a step of the paper's sampler, None the fast one (`sampler.sample`). `trained` says which
    sensors it was trained on, where that is known: a scan of another one is a `UserWarning`.
    """

    def __init__(
        self,
        denoiser: Denoiser,
        *,
        steps: int = STEPS,
        start: float | None = START,
        langevin: int | None = None,
        trained: SensorLimits | None = None,
    ) -> None:
        check_type("denoiser", denoiser, Denoiser)
        self.denoiser = denoiser.eval()
        self.steps = steps
        self.start = start if "simulated" in denoiser.config.condition else None
        self.langevin = langevin
        self.trained = trained

    @classmethod
    def from_pretrained(
        cls,
        name: str | os.PathLike[str] = "street",
        *,
        device: str = "cpu",
        steps: int = STEPS,
        start: float | None = START,
        langevin: int | None = None,
    ) -> Pipeline:
        """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`."""
        check_type("name", name, str, os.PathLike)
        packaged = WEIGHTS / f"{os.fspath(name)}.safetensors"
        path = packaged if packaged.exists() else Path(name)
        if not path.exists():
            known = one_of(sorted(file.stem for file in WEIGHTS.glob("*.safetensors")), os.fspath(name))
            raise CheckpointError(f"weights are {os.fspath(name)!r}; they must be a file or {known}")
        denoiser, trained = weight_file.load(path, Denoiser), weight_file.read_card(path).get("sensors")
        try:
            denoiser = denoiser.to(device)
        except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
            raise CheckpointError(f"device is {device!r}: {str(error).splitlines()[0]}") from None
        limits = trained and SensorLimits.from_dict(trained)
        return cls(denoiser, steps=steps, start=start, langevin=langevin, trained=limits)

    def __call__(
        self,
        source: str | Layout,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        speed: float = 0.0,
        on_step: Callable[[], object] | None = None,
    ) -> Scan:
        """The scan of a sentence or a layout, by a sensor that moves ahead with `speed` [m/s] while it sweeps.

        Same arguments, same scan; another seed gives another one (of a sentence, with another layout too). `on_step` is
        called after each sampling step.
        """
        check_type("source", source, str, Layout)
        sensor = sensor or Sensor.preset("hdl64e")
        layout = layout_from_text(source, seed=seed) if isinstance(source, str) else source
        simulated = simulate(layout, sensor, seed=seed, speed=speed)
        condition_image = simulated.condition_image
        generated = self.generate(condition_image, simulated.image, seed=seed, on_step=on_step)
        image = label_by_agreement(generated, (simulated.image, condition_image), layout, simulated.poses())
        return dataclasses.replace(simulated, image=image)

    def generate(
        self,
        condition_image: RangeImage,
        simulated: RangeImage,
        *,
        seed: int = 0,
        on_step: Callable[[], object] | None = None,
    ) -> RangeImage:
        """The scan of the cast of a layout and its simulated scan, without labels. Weights that do not see the
        simulated scan give what they sample, as it is; others what `postprocess` makes of that."""
        sensor = condition_image.sensor
        difference = self.trained and self.trained.difference(sensor)
        if difference:
            warnings.warn(f"these weights were trained on {difference}; its scans may be poor", stacklevel=2)
        image = decode_scan(self._sample(condition_image, simulated, seed, on_step), sensor)
        if "simulated" not in self.denoiser.config.condition:
            return image
        return postprocess(image, condition_image, simulated, np.random.default_rng([seed, _POSTPROCESS_STREAM]))

    @torch.inference_mode()
    def _sample(
        self, condition_image: RangeImage, simulated: RangeImage, seed: int, on_step: Callable[[], object] | None
    ) -> np.ndarray:
        """A state f32 [3, H, W]."""
        seen = self.denoiser.config.condition
        states = sample(
            self.denoiser,
            condition_image.sensor,
            seeds=[seed],
            condition=torch.from_numpy(encode_condition(condition_image, simulated))[None] if seen else None,
            steps=self.steps,
            start=self.start,
            langevin=self.langevin,
        )
        for state in states:  # noqa: B007 (the last one is the result)
            if on_step is not None:
                on_step()
        return state[0].cpu().numpy()
