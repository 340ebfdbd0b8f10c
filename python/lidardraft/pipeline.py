"""The product in one screen: draft, raycast, simulate, generate, label."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple

import numpy as np
import torch

from lidardraft.diffusion.codec import decode_scan, encode_condition
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
from lidardraft.scene.visibility import open_pixels
from lidardraft.simulation.simulate import simulate

_NOTHING_OPEN = "the layout leaves nothing open: the scan is the simulated one"
_PIXELS_AT_ONCE = 2**19  # of a call on a GPU: 8 scans of 64 x 1024


class _Given(NamedTuple):
    """The input of a scan: the cast of a layout, its simulated scan, and a seed. Weights that complete make the pixels
    of `is_open`, bool [H, W]. All others make the whole scan; for them it is None."""

    cast: RangeImage
    simulated: RangeImage
    is_open: np.ndarray | None
    seed: int


@dataclass(frozen=True, eq=False)
class Pipeline:
    """A denoiser that turns sentences and layouts into scans, by default of an hdl64e.

    Weights that complete (`DenoiserConfig.completes`) keep the simulated scan of a layout, and make only the pixels
    that the layout leaves open; all others make the whole scan from noise. A scan is sampled in `steps` calls of the
    network, two each if `guidance` strengthens a ControlNet, the last one at `last_noise`. `trained` are the limits of
    the sensors in training, if known: a scan of another sensor is a `UserWarning`.
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
        `on_step` is called after each sampling step. With weights that complete, a layout that leaves nothing open is a
        `UserWarning`.
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
        given = [_given(scan, completes=self.denoiser.config.completes) for scan in simulated]
        images = iter(self._sampled([one for one in given if one.is_open is None or one.is_open.any()], on_step))
        for scan, one in zip(simulated, given, strict=True):
            if one.is_open is None:
                known = (one.simulated, one.cast)
                image = label_by_agreement(next(images), known, scan.layout, scan.poses())
                yield dataclasses.replace(scan, image=image)
            elif one.is_open.any():
                yield dataclasses.replace(scan, image=next(images))
            else:
                warnings.warn(_NOTHING_OPEN, stacklevel=4)
                yield dataclasses.replace(scan, assumed=(*scan.assumed, _NOTHING_OPEN))

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
        fit the sensor, `CheckpointError` with weights that complete the simulated scan of a layout.
        """
        if self.denoiser.config.completes:
            raise CheckpointError(
                "these weights complete the scan of a layout; a semantic map needs others, such as paper"
            )
        image = standing_on_ground(label, sensor or Sensor.preset("hdl64e"))
        return self.generate(image, image, seed=seed, on_step=on_step)

    def generate(
        self,
        condition_image: RangeImage,
        simulated: RangeImage,
        is_open: np.ndarray | None = None,
        *,
        seed: int = 0,
        on_step: Callable[[], object] | None = None,
    ) -> RangeImage:
        """The scan for the cast of a layout and its simulated scan, with the classes that the network predicts.

        Weights that complete return the simulated scan except where `is_open`, bool [H, W]; None is everywhere.
        """
        if not self.denoiser.config.completes:
            is_open = None
        elif is_open is None:
            is_open = np.ones(simulated.sensor.shape, dtype=bool)
        (image,) = self._sampled([_Given(condition_image, simulated, is_open, check_seed(seed))], on_step)
        return image

    @torch.inference_mode()
    def _sampled(self, given: Sequence[_Given], on_step: Callable[[], object] | None) -> list[RangeImage]:
        """The scans of several inputs, all of one sensor, in the same calls of the network."""
        if not given:
            return []
        sensor, condition = given[0].simulated.sensor, None
        difference = self.trained and self.trained.difference(sensor)
        if difference:
            warnings.warn(f"these weights were trained on {difference}; its scans may be poor", stacklevel=2)
        if self.denoiser.config.condition:
            encoded = [encode_condition(one.cast, one.simulated, one.is_open) for one in given]
            condition = torch.from_numpy(np.stack(encoded))
        states = sample(
            self.denoiser,
            sensor,
            seeds=[one.seed for one in given],
            condition=condition,
            steps=self.steps,
            guidance=self.guidance,
            last_noise=self.last_noise,
        )
        for state in states:  # noqa: B007 (the last one is the result)
            for _ in given:
                if on_step is not None:
                    on_step()
        images = [decode_scan(each, sensor) for each in state.cpu().numpy()]
        for number, one in enumerate(given):
            if one.is_open is not None:
                images[number] = merged(one.simulated, images[number], one.is_open)
        return images


def _given(scan: Scan, *, completes: bool) -> _Given:
    """The input from a simulated scan and its layout."""
    poses = scan.poses()
    cast = raycast(scan.layout, scan.image.sensor, poses=poses, primitive=True)
    return _Given(cast, scan.image, open_pixels(scan.layout, cast, poses) if completes else None, scan.seed)


def merged(given: RangeImage, made: RangeImage, is_open: np.ndarray) -> RangeImage:
    """`made` where `is_open`, bool [H, W], and `given` elsewhere."""
    names = ("depth", "label", "instance", "intensity")
    pairs = {name: (getattr(made, name), getattr(given, name)) for name in names}
    images = {
        name: np.where(is_open, *pair) for name, pair in pairs.items() if pair[0] is not None and pair[1] is not None
    }
    return RangeImage(sensor=given.sensor, **images)
