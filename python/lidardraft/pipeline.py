"""The product in one screen: draft, raycast, simulate, generate, label."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Callable, Iterator

import numpy as np
import torch

from lidardraft.diffusion.codec import decode_scan, encode_condition
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import GUIDANCE, LAST_NOISE, STEPS
from lidardraft.diffusion.sampler import sample
from lidardraft.diffusion.sensor_limits import SensorLimits
from lidardraft.drafting.text.layout import layout_from_text
from lidardraft.errors import CheckpointError, LidarDraftError, check_number, check_seed, check_type
from lidardraft.files import named
from lidardraft.json_fields import check_fields, check_object, is_number
from lidardraft.networks import weight_file, weight_header
from lidardraft.scan import Scan
from lidardraft.scene.labelling import label_by_agreement
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.reprojection import reprojected
from lidardraft.scene.semantic_map import standing_on_ground
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.visibility import open_pixels
from lidardraft.simulation.sequence import SequenceSimulator
from lidardraft.simulation.simulate import simulate

_NOTHING_OPEN = "the layout leaves nothing open: the scan is the simulated one"
_ONE_WORLD = "only weights that complete, such as street, go on from an earlier scan, and only of the same sensor"


class Pipeline:
    """A denoiser, ready to turn sentences and layouts into scans, of an hdl64e where no sensor is given.

    Weights that complete (`DenoiserConfig.completes`) leave the simulated scan of a layout as it is, and make what the
    layout leaves open; all others make the whole scan from noise. A scan is sampled in `steps` calls of the network,
    two each where `guidance` strengthens a ControlNet, the last one at `last_noise`. `langevin` is the number of
    updates a step of the paper's sampler, None the fast one (`sampler.sample`). `trained` says which sensors it was
    trained on, where that is known: a scan of another one is a `UserWarning`.
    """

    def __init__(
        self,
        denoiser: Denoiser,
        *,
        steps: int = STEPS,
        guidance: float = GUIDANCE,
        last_noise: float = LAST_NOISE,
        langevin: int | None = None,
        trained: SensorLimits | None = None,
    ) -> None:
        check_type("denoiser", denoiser, Denoiser)
        if not (is_number(guidance) and guidance >= 0):
            raise LidarDraftError(f"guidance is {guidance!r}; it must be a finite number of 0 or more")
        self.denoiser = denoiser.eval()
        self.steps = check_number("steps", steps, least=1)
        self.guidance = float(guidance)
        if not (is_number(last_noise) and last_noise > 0):
            raise LidarDraftError(f"last_noise is {last_noise!r}; it must be a finite number over 0")
        self.last_noise = float(last_noise)
        self.langevin = None if langevin is None else check_number("langevin", langevin, least=1)
        self.trained = trained

    @classmethod
    def from_pretrained(
        cls,
        name: str | os.PathLike[str] = "street",
        *,
        device: str = "cpu",
        steps: int | None = None,
        guidance: float | None = None,
        langevin: int | None = None,
        threads: int | None = None,
    ) -> Pipeline:
        """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`.

        What of `steps` and `guidance` is not given, and the last noise, are those stored in the card of the weights.
        `threads` is how many torch may use in this process from now on; scans differ a little with their number.
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
            return cls(denoiser, **sampling, langevin=langevin, trained=trained)

    def __call__(
        self,
        source: str | Layout,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        speed: float = 0.0,
        after: Scan | None = None,
        on_step: Callable[[], object] | None = None,
    ) -> Scan:
        """The scan of a sentence or a layout, by a sensor that moves ahead with `speed` [m/s] while it sweeps.

        Same arguments, same scan; another seed gives another one (of a sentence, with another layout too). What weights
        that complete made up in the scan `after`, of this layout before an edit, stays where it is open and seen.
        `on_step` is called after each sampling step. A layout that leaves nothing open to weights that complete is a
        `UserWarning`; `after` with others, or of another sensor, is a `CheckpointError`.
        """
        check_type("source", source, str, Layout)
        sensor = sensor or Sensor.preset("hdl64e")
        layout = layout_from_text(source, seed=seed) if isinstance(source, str) else source
        return self._made(simulate(layout, sensor, seed=seed, speed=speed), seed, after, on_step)

    def frames(self, simulator: SequenceSimulator, *, on_step: Callable[[], object] | None = None) -> Iterator[Scan]:
        """The frames of a sequence; what one makes up, the next ones show from where the sensor is then.

        Raises `CheckpointError` with weights that do not complete.
        """
        if not self.denoiser.config.completes:
            raise CheckpointError(_ONE_WORLD)
        before: Scan | None = None
        for simulated in simulator:
            before = self._made(simulated, simulator.seed, before, on_step)
            yield before

    def _made(self, simulated: Scan, seed: int, after: Scan | None, on_step: Callable[[], object] | None) -> Scan:
        """What becomes of a simulated scan."""
        completes, poses = self.denoiser.config.completes, simulated.poses()
        cast, is_open = _cast_and_open(simulated)
        if completes and not is_open.any():
            warnings.warn(_NOTHING_OPEN, stacklevel=3)
            return dataclasses.replace(simulated, assumed=(*simulated.assumed, _NOTHING_OPEN))
        given = simulated.image
        if after is not None:
            if not completes or after.image.sensor != given.sensor:
                raise CheckpointError(_ONE_WORLD)
            old, known = reprojected(after.image, _cast_and_open(after)[1], after.poses(), poses)
            known &= is_open
            given, cast, is_open = merged(given, old, known), merged(cast, old, known), is_open & ~known
        image = given
        if is_open.any() or not completes:
            image = self.generate(cast, given, is_open, seed=seed, on_step=on_step)
        if not completes:
            image = label_by_agreement(image, (given, cast), simulated.layout, poses)
        return dataclasses.replace(simulated, image=image)

    def from_map(
        self,
        label: np.ndarray,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        on_step: Callable[[], object] | None = None,
    ) -> RangeImage:
        """The scan of a semantic map, class ids [H, W] of the sensor's rays, with the classes that the network gives.

        Weights that see ranges too are given guessed ones (`standing_on_ground`). Raises `FormatError` on a map that is
        not of the sensor, `CheckpointError` with weights that complete the simulated scan of a layout.
        """
        if self.denoiser.config.completes:
            raise CheckpointError(
                "these weights complete the scan of a layout; a semantic map needs others, such as paper"
            )
        image = standing_on_ground(label, sensor or Sensor.preset("hdl64e"))
        return self.generate(image, image, seed=seed, on_step=on_step)

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
        sensor, config, seed = condition_image.sensor, self.denoiser.config, check_seed(seed)
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
            last_noise=self.last_noise,
            langevin=self.langevin,
        )
        for state in states:  # noqa: B007 (the last one is the result)
            if on_step is not None:
                on_step()
        made = decode_scan(state[0].cpu().numpy(), sensor)
        return merged(simulated, made, is_open) if config.completes and is_open is not None else made


def _cast_and_open(scan: Scan) -> tuple[RangeImage, np.ndarray]:
    """The cast of the layout of a scan, and what it leaves open, bool [H, W]."""
    poses = scan.poses()
    cast = raycast(scan.layout, scan.image.sensor, poses=poses, primitive=True)
    return cast, open_pixels(scan.layout, cast, poses)


def merged(given: RangeImage, made: RangeImage, is_open: np.ndarray) -> RangeImage:
    """`made` where `is_open`, bool [H, W], and `given` elsewhere."""
    names = ("depth", "label", "instance", "intensity")
    pairs = {name: (getattr(made, name), getattr(given, name)) for name in names}
    images = {
        name: np.where(is_open, *pair) for name, pair in pairs.items() if pair[0] is not None and pair[1] is not None
    }
    return RangeImage(sensor=given.sensor, **images)
