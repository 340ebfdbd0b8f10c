"""The product in one screen: draft, raycast, generate, label."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from lidardraft import view
from lidardraft.diffusion.codec import decode_scan, encode_condition
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.sampler import sample
from lidardraft.drafting.text import layout_from_text
from lidardraft.errors import CheckpointError
from lidardraft.formats import kitti, semantickitti
from lidardraft.formats.boxes import write_boxes
from lidardraft.networks import weight_file
from lidardraft.scene.labelling import label_from_condition_image
from lidardraft.scene.layout import Box, Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor

WEIGHTS = Path(__file__).parent / "weights"


@dataclass(frozen=True, kw_only=True, eq=False)
class Scan:
    """A generated, labelled scan with the drawing and the layout it was generated from."""

    image: RangeImage
    condition_image: RangeImage
    layout: Layout
    pose: np.ndarray
    seed: int

    def points(self) -> np.ndarray:
        """x, y, z of the returns in the sensor frame [m], float32 [N, 3]."""
        return self.image.points()

    def intensities(self) -> np.ndarray:
        """Intensities in [0, 1] of `points()`, float32 [N]."""
        assert self.image.intensity is not None
        return self.image.intensity[self.image.valid]

    def labels(self) -> np.ndarray:
        """Class ids of `points()`, uint8 [N]; 0 where nothing of the layout is near."""
        return self.image.label[self.image.valid]

    def instances(self) -> np.ndarray:
        """Instance numbers of `points()`, uint32 [N]; 0 for stuff."""
        return self.image.instance[self.image.valid]

    def boxes(self) -> list[Box]:
        """Boxes of the layout's things in the sensor frame."""
        return [box.seen_from(self.pose) for box in self.layout.boxes()]

    def returns_per_box(self) -> list[int]:
        """How many points are of each of `boxes()`."""
        return [int(np.count_nonzero(self.image.instance == box.instance)) for box in self.layout.boxes()]

    def picture(self) -> np.ndarray:
        """Layout, drawing and scan side by side over the drawn and the generated range image, uint8 [H, W, 3]."""
        views = [
            view.caption(view.render_layout(self.layout), "layout"),
            view.caption(view.render_scan(self.condition_image, self.pose, by_label=True), "drawing"),
            view.caption(view.render_scan(self.image, self.pose, by_label=True), "scan"),
        ]
        images = [
            view.caption(view.render_image(self.condition_image), "drawing"),
            view.caption(view.render_image(self.image), "scan"),
        ]
        return view.stack([view.stack(views, across=True), view.stack(images, across=True)])

    def save(self, name: str | os.PathLike[str]) -> None:
        """Write `NAME.bin`, `NAME.label`, `NAME.boxes.json`, `NAME.layout.json` and `NAME.png` beside each other, or,
        where one of them cannot be written, none."""
        target = Path(name)
        with tempfile.TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent) as folder:
            stem = Path(folder) / target.name
            kitti.write_bin(f"{stem}.bin", self.points(), self.intensities())
            semantickitti.write_label(f"{stem}.label", self.labels(), self.instances())
            write_boxes(f"{stem}.boxes.json", self.boxes(), self.returns_per_box())
            self.layout.save(f"{stem}.layout.json")
            view.save_png(self.picture(), f"{stem}.png")
            for file in Path(folder).iterdir():
                file.replace(target.parent / file.name)


class Pipeline:
    """A denoiser, ready to turn sentences and layouts into scans, of an hdl64e where no sensor is given."""

    def __init__(self, denoiser: Denoiser, *, steps: int = 20) -> None:
        self.denoiser = denoiser.eval()
        self.sensor = Sensor.preset("hdl64e")
        self.steps = steps

    @classmethod
    def from_pretrained(
        cls, name: str | os.PathLike[str] = "street", *, device: str = "cpu", steps: int = 20
    ) -> Pipeline:
        """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`."""
        packaged = WEIGHTS / f"{os.fspath(name)}.safetensors"
        path = packaged if packaged.exists() else Path(name)
        if not path.exists():
            names = ", ".join(sorted(file.stem for file in WEIGHTS.glob("*.safetensors")))
            raise CheckpointError(f"weights are {os.fspath(name)!r}; they must be a file or one of: {names}")
        denoiser = weight_file.load(path, Denoiser)
        try:
            return cls(denoiser.to(device), steps=steps)
        except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
            raise CheckpointError(f"device is {device!r}: {str(error).splitlines()[0]}") from None

    def __call__(self, source: str | Layout, *, sensor: Sensor | None = None, seed: int = 0) -> Scan:
        """The scan of a sentence or a layout. Same arguments, same scan; another seed gives another one (of a
        sentence, with another layout too)."""
        sensor = sensor or self.sensor
        layout = layout_from_text(source, seed=seed) if isinstance(source, str) else source
        pose = sensor.pose()
        condition_image = raycast(layout, sensor, pose)
        *_, generated = self.denoising(condition_image, seed=seed)
        image = label_from_condition_image(generated, condition_image, layout, pose)
        return Scan(image=image, condition_image=condition_image, layout=layout, pose=pose, seed=seed)

    @torch.inference_mode()
    def denoising(self, condition_image: RangeImage, *, seed: int = 0) -> Iterator[RangeImage]:
        """The scan while it takes shape, one image without labels a sampling step; the last is the result."""
        condition = torch.from_numpy(encode_condition(condition_image))[None]
        for state in sample(self.denoiser, condition_image.sensor, seeds=[seed], condition=condition, steps=self.steps):
            yield decode_scan(state[0].cpu().numpy(), condition_image.sensor)
