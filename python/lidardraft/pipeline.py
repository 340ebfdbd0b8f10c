"""The product in one screen: draft, raycast, generate, label."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

import torch

from lidardraft.diffusion.codec import decode_scan, encode_condition
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.sampler import sample
from lidardraft.drafting.text import layout_from_text
from lidardraft.errors import CheckpointError, one_of
from lidardraft.networks import weight_file
from lidardraft.scan import Scan
from lidardraft.scene.labelling import label_from_condition_image
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor

WEIGHTS = Path(__file__).parent / "weights"


class Pipeline:
    """A denoiser, ready to turn sentences and layouts into scans, of an hdl64e where no sensor is given.

    `sensors` are the names of those it was trained on, where they are known: a scan of another one is a `UserWarning`.
    """

    def __init__(self, denoiser: Denoiser, *, steps: int = 20, sensors: Collection[str] = ()) -> None:
        self.denoiser = denoiser.eval()
        self.sensor = Sensor.preset("hdl64e")
        self.steps = steps
        self.sensors = frozenset(sensors)

    @classmethod
    def from_pretrained(
        cls, name: str | os.PathLike[str] = "street", *, device: str = "cpu", steps: int = 20
    ) -> Pipeline:
        """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`."""
        packaged = WEIGHTS / f"{os.fspath(name)}.safetensors"
        path = packaged if packaged.exists() else Path(name)
        if not path.exists():
            known = one_of(sorted(file.stem for file in WEIGHTS.glob("*.safetensors")), os.fspath(name))
            raise CheckpointError(f"weights are {os.fspath(name)!r}; they must be a file or {known}")
        denoiser, sensors = weight_file.load(path, Denoiser), weight_file.read_card(path).get("sensors", [])
        try:
            return cls(denoiser.to(device), steps=steps, sensors=sensors)
        except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
            raise CheckpointError(f"device is {device!r}: {str(error).splitlines()[0]}") from None

    def __call__(
        self,
        source: str | Layout,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        on_step: Callable[[], object] | None = None,
    ) -> Scan:
        """The scan of a sentence or a layout. Same arguments, same scan; another seed gives another one (of a
        sentence, with another layout too). `on_step` is called after each sampling step."""
        sensor = sensor or self.sensor
        layout = layout_from_text(source, seed=seed) if isinstance(source, str) else source
        pose = sensor.pose()
        condition_image = generated = raycast(layout, sensor, pose)
        for state in self.denoising(condition_image, seed=seed):
            generated = state
            if on_step is not None:
                on_step()
        image = label_from_condition_image(generated, condition_image, layout, pose)
        return Scan(image=image, layout=layout, pose=pose, seed=seed)

    def denoising(self, condition_image: RangeImage, *, seed: int = 0) -> Iterator[RangeImage]:
        """The scan while it is made, one image without labels a sampling step; the last is the result."""
        name = condition_image.sensor.name
        if self.sensors and name not in self.sensors:
            trained = ", ".join(sorted(self.sensors))
            warnings.warn(f"these weights were trained on {trained}; scans of {name} may be poor", stacklevel=2)
        return self._denoising(condition_image, seed)

    @torch.inference_mode()
    def _denoising(self, condition_image: RangeImage, seed: int) -> Iterator[RangeImage]:
        condition = torch.from_numpy(encode_condition(condition_image))[None]
        for state in sample(self.denoiser, condition_image.sensor, seeds=[seed], condition=condition, steps=self.steps):
            yield decode_scan(state[0].cpu().numpy(), condition_image.sensor)
