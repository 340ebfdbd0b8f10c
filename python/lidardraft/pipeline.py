"""The product in one screen: draft, raycast, simulate, generate, label."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np
import torch

from lidardraft.diffusion.codec import decode_scan, encode_scan
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import GUIDANCE, LAST_NOISE, STEPS
from lidardraft.diffusion.sampler import sample
from lidardraft.diffusion.sensor_limits import SensorLimits
from lidardraft.errors import CheckpointError, LidarDraftError, check_number, check_seed, check_type
from lidardraft.files import named
from lidardraft.json_fields import check_fields, check_object, is_number
from lidardraft.networks import weight_file, weight_header
from lidardraft.scan import Scan
from lidardraft.scene.labelling import label_by_agreement
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.semantic_map import standing_on_ground
from lidardraft.scene.sensor import Sensor
from lidardraft.simulation.simulate import simulate

_PIXELS_AT_ONCE = 2**19  # of a call on a GPU: 8 scans of 64 x 1024


@dataclass(frozen=True, eq=False)
class Pipeline:
    """A denoiser that turns sentences and layouts into scans, by default of an hdl64e.

    The whole scan is made from noise, in `steps` calls of the network, two each if `guidance` strengthens a ControlNet,
    the last one at `last_noise`. `trained` are the limits of the sensors in training, if known: a scan of another
    sensor is a `UserWarning`.
    """

    denoiser: Denoiser
    _: KW_ONLY
    steps: int = STEPS
    guidance: float = GUIDANCE
    last_noise: float = LAST_NOISE
    trained: SensorLimits | None = None

    def __post_init__(self) -> None:
        check_type("denoiser", self.denoiser, Denoiser)
        check_number("steps", self.steps, least=1)
        if not (is_number(self.guidance) and self.guidance >= 0):
            raise LidarDraftError(f"guidance is {self.guidance!r}; it must be a finite number of 0 or more")
        if not (is_number(self.last_noise) and self.last_noise > 0):
            raise LidarDraftError(f"last_noise is {self.last_noise!r}; it must be a finite number over 0")
        self.denoiser.eval()

    @classmethod
    def from_pretrained(
        cls,
        name: str | os.PathLike[str] = "paper",
        *,
        device: str = "cpu",
        steps: int | None = None,
        guidance: float | None = None,
        threads: int | None = None,
    ) -> Pipeline:
        """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`.

        `steps` and `guidance` are by default those in the card of the weights, as is the last noise. `threads` is the
        number of torch's threads in this process from now on; scans differ a little with it.
        """
        check_type("name", name, str, os.PathLike)
        path = weight_header.find(name)
        denoiser, card = weight_file.load(path, Denoiser), weight_file.read_card(path)
        try:
            denoiser = denoiser.to(device)
        except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
            raise CheckpointError(f"device is {device!r}: {str(error).splitlines()[0]}") from None
        if threads is not None:
            torch.set_num_threads(threads)
        trained = card.get("sensors") and SensorLimits.from_dict(card["sensors"])
        given = {"steps": steps, "guidance": guidance}
        sampling = check_object(card.get("sampling", {})) | {k: v for k, v in given.items() if v is not None}
        with named(path):
            check_fields(sampling, (), ("steps", "guidance", "last_noise"))
            return cls(denoiser, **sampling, trained=trained)

    def __call__(
        self,
        source: str | Layout,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        speed: float = 0.0,
        relief: bool = True,
        on_step: Callable[[], object] | None = None,
    ) -> Scan:
        """The scan of a layout, or of a sentence in its street, by a sensor that moves ahead at `speed` [m/s], with
        `relief` or on level ground as in `Simulator`.

        The same arguments give the same scan; another seed gives another one, for a sentence with another layout too.
        `on_step` is called after each sampling step.
        """
        check_type("source", source, str, Layout)
        return next(self.scans([(source, seed)], sensor=sensor, speed=speed, relief=relief, on_step=on_step))

    def scans(
        self,
        sources: Iterable[tuple[str | Layout, int]],
        *,
        sensor: Sensor | None = None,
        speed: float = 0.0,
        relief: bool = True,
        on_step: Callable[[], object] | None = None,
    ) -> Iterator[Scan]:
        """The scans of many sentences or layouts, each with its seed. A GPU makes several in one call.

        `on_step` is called after each sampling step of each scan.
        """
        sensor, rest = sensor or Sensor.preset("hdl64e"), iter(sources)
        while some := list(itertools.islice(rest, self._at_once(sensor))):
            made = [simulate(each, sensor, seed=seed, speed=speed, relief=relief, carrier=False) for each, seed in some]
            yield from self._made(made, on_step)

    def from_simulated(self, scan: Scan, *, on_step: Callable[[], object] | None = None) -> Scan:
        """The generated scan of a simulated one, as `scans` makes it from a layout."""
        return next(self._made([scan], on_step))

    def _at_once(self, sensor: Sensor) -> int:
        """The number of scans made in one call of the network."""
        is_cpu = next(self.denoiser.parameters()).device.type == "cpu"
        return 1 if is_cpu else max(1, _PIXELS_AT_ONCE // math.prod(sensor.shape))

    def _made(self, simulated: Sequence[Scan], on_step: Callable[[], object] | None) -> Iterator[Scan]:
        """The generated scans of simulated scans of one sensor."""
        casts = [raycast(scan.layout, scan.image.sensor, poses=scan.poses()) for scan in simulated]
        images = self._sampled(casts, [scan.seed for scan in simulated], on_step)
        for scan, cast, image in zip(simulated, casts, images, strict=True):
            labelled = label_by_agreement(image, (scan.image, cast), scan.layout, scan.poses())
            yield dataclasses.replace(scan, image=labelled)

    def from_map(
        self,
        label: np.ndarray,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        on_step: Callable[[], object] | None = None,
    ) -> RangeImage:
        """The scan of a semantic map, class ids [H, W] of the sensor's rays, with the classes that the network
        predicts.

        Weights that use ranges too get guessed ones (`standing_on_ground`). Raises `FormatError` on a map that does not
        fit the sensor.
        """
        image = standing_on_ground(label, sensor or Sensor.preset("hdl64e"))
        return self.generate(image, seed=seed, on_step=on_step)

    def generate(
        self, condition_image: RangeImage, *, seed: int = 0, on_step: Callable[[], object] | None = None
    ) -> RangeImage:
        """The scan for the cast of a layout, with the classes that the network predicts."""
        (image,) = self._sampled([condition_image], [check_seed(seed)], on_step)
        return image

    @torch.inference_mode()
    def _sampled(
        self, casts: Sequence[RangeImage], seeds: Sequence[int], on_step: Callable[[], object] | None
    ) -> list[RangeImage]:
        """The scans for casts of one sensor, in the same calls of the network."""
        sensor, condition = casts[0].sensor, None
        difference = self.trained and self.trained.difference(sensor)
        if difference:
            warnings.warn(f"these weights were trained on {difference}; its scans may be poor", stacklevel=2)
        if self.denoiser.config.condition:
            condition = torch.from_numpy(np.stack([encode_scan(cast) for cast in casts]))
        states = sample(
            self.denoiser,
            sensor,
            seeds=seeds,
            condition=condition,
            steps=self.steps,
            guidance=self.guidance,
            last_noise=self.last_noise,
        )
        for state in states:  # noqa: B007 (the last one is the result)
            for _ in casts:
                if on_step is not None:
                    on_step()
        return [decode_scan(each, sensor) for each in state.cpu().numpy()]
