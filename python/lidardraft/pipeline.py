"""The product in one screen: draft, raycast, simulate, generate, label."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Callable

import numpy as np
import torch

from lidardraft.diffusion.codec import decode_scan, encode_condition
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import GUIDANCE, STEPS
from lidardraft.diffusion.sampler import sample
from lidardraft.diffusion.sensor_limits import SensorLimits
from lidardraft.drafting.text.layout import layout_from_text
from lidardraft.errors import CheckpointError, check_type
from lidardraft.networks import weight_file
from lidardraft.scan import Scan
from lidardraft.scene.labelling import label_by_agreement
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.visibility import open_pixels
from lidardraft.simulation.simulate import simulate


class Pipeline:
    """A denoiser, ready to turn sentences and layouts into scans, of an hdl64e where no sensor is given.

    Weights that complete (`DenoiserConfig.completes`) leave the simulated scan of a layout as it is, and make what the
    layout leaves open; all others make the whole scan from noise. A scan is sampled in `steps` calls of the network,
    two each where `guidance` strengthens a ControlNet. `langevin` is the number of updates a step of the paper's
    sampler, None the fast one (`sampler.sample`). `trained`
    says which sensors it was trained on, where that is known: a scan of another one is a `UserWarning`.
    """

    def __init__(
        self,
        denoiser: Denoiser,
        *,
        steps: int = STEPS,
        guidance: float = GUIDANCE,
        langevin: int | None = None,
        trained: SensorLimits | None = None,
    ) -> None:
        check_type("denoiser", denoiser, Denoiser)
        self.denoiser = denoiser.eval()
        self.steps = steps
        self.guidance = guidance
        self.langevin = langevin
        self.trained = trained

    @classmethod
    def from_pretrained(
        cls,
        name: str | os.PathLike[str] = "street",
        *,
        device: str = "cpu",
        steps: int = STEPS,
        guidance: float = GUIDANCE,
        langevin: int | None = None,
        threads: int | None = None,
    ) -> Pipeline:
        """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`.

        `threads` is how many torch may use in this process from now on; scans differ a little with their number.
        """
        check_type("name", name, str, os.PathLike)
        path = weight_file.find(name)
        denoiser, trained = weight_file.load(path, Denoiser), weight_file.read_card(path).get("sensors")
        try:
            denoiser = denoiser.to(device)
        except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
            raise CheckpointError(f"device is {device!r}: {str(error).splitlines()[0]}") from None
        if threads is not None:
            torch.set_num_threads(threads)
        limits = trained and SensorLimits.from_dict(trained)
        return cls(denoiser, steps=steps, guidance=guidance, langevin=langevin, trained=limits)

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
        called after each sampling step. A layout that leaves nothing open to weights that complete is a `UserWarning`.
        """
        check_type("source", source, str, Layout)
        sensor = sensor or Sensor.preset("hdl64e")
        layout = layout_from_text(source, seed=seed) if isinstance(source, str) else source
        simulated = simulate(layout, sensor, seed=seed, speed=speed)
        poses = simulated.poses()
        condition_image = raycast(layout, sensor, poses=poses, primitive=True)
        is_open = open_pixels(layout, condition_image, simulated.pose)
        if self.denoiser.config.completes and not is_open.any():
            warnings.warn("the layout leaves nothing open: the scan is the simulated one", stacklevel=2)
            return simulated
        image = self.generate(condition_image, simulated.image, is_open, seed=seed, on_step=on_step)
        if not self.denoiser.config.completes:
            image = label_by_agreement(image, (simulated.image, condition_image), layout, poses)
        return dataclasses.replace(simulated, image=image)

    @torch.inference_mode()
    def generate(
        self,
        condition_image: RangeImage,
        simulated: RangeImage,
        is_open: np.ndarray | None = None,
        *,
        seed: int = 0,
        on_step: Callable[[], object] | None = None,
    ) -> RangeImage:
        """The scan of the cast of a layout and its simulated scan, with the classes that the network gives it.

        Of weights that complete it is the simulated scan but where `is_open`, bool [H, W]: None is everywhere.
        """
        sensor, config = condition_image.sensor, self.denoiser.config
        difference = self.trained and self.trained.difference(sensor)
        if difference:
            warnings.warn(f"these weights were trained on {difference}; its scans may be poor", stacklevel=2)
        condition = None
        if config.condition:
            if not config.completes:
                is_open = None
            elif is_open is None:
                is_open = np.ones(sensor.shape, dtype=bool)
            condition = torch.from_numpy(encode_condition(condition_image, simulated, is_open))[None]
        states = sample(
            self.denoiser,
            sensor,
            seeds=[seed],
            condition=condition,
            steps=self.steps,
            guidance=self.guidance,
            langevin=self.langevin,
        )
        for state in states:  # noqa: B007 (the last one is the result)
            if on_step is not None:
                on_step()
        made = decode_scan(state[0].cpu().numpy(), sensor)
        return merged(simulated, made, is_open) if config.completes and is_open is not None else made


def merged(given: RangeImage, made: RangeImage, is_open: np.ndarray) -> RangeImage:
    """`made` where `is_open`, bool [H, W], and `given` elsewhere."""
    names = ("depth", "label", "instance", "intensity")
    images = {name: np.where(is_open, getattr(made, name), getattr(given, name)) for name in names}
    return RangeImage(sensor=given.sensor, **images)
