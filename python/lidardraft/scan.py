"""A labelled scan of a layout, simulated or generated, and its files."""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft import array_files, view
from lidardraft.errors import FormatError, LayoutError, SensorError, check_type
from lidardraft.files import written_together
from lidardraft.formats import kitti, semantickitti
from lidardraft.formats.boxes import write_boxes
from lidardraft.formats.frame import Annotation, Frame, with_riders_merged
from lidardraft.json_fields import is_number, parse_object
from lidardraft.scene.box import Box, checked_vector
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import finite_array, inverse, upright
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.visibility import occluded_shares

_MOST_IN_NOTEBOOKS = 40_000  # points of an output, half a megabyte in the file of the notebook
SCAN_ENDINGS = (".npz", ".bin", ".label", ".boxes.json", ".layout.json", ".sensor.json", ".png")  # of a saved scan
TRACK_FILES = ("poses.txt", "times.txt", "tracks.json")  # beside the saved scans of a sequence
CASTS_FILE = "casts.json"  # beside those of `observe`: the source file of each, by number


@dataclass(frozen=True, kw_only=True, eq=False)
class Scan:
    """A labelled scan and its layout.

    `pose` is the world_from_sensor [4, 4] of the scan. A sensor may move at `speed` [m/s] along `heading`, by default
    its x axis, and turn about its z axis at `turn` [rad/s]; then `pose` is that in the middle of the sweep. `heading`
    [3], of length 1 in the world, is for a vehicle that leans: its sensor leans too, but its direction of travel does
    not.

    In a frame of a sequence, `time` is that of the middle of the sweep since the start [s], the layout is that of this
    time, and `velocities` are those [m/s] of the moving objects, by name, in the world.

    `mount` is the place of the sensor on its vehicle: x, y, z [m] and yaw [rad] from the road under the vehicle's
    middle. None is (0, 0, `mount_height`, 0).

    `assumed` are notes on this scan alone, which files do not keep; `notes` are these and those of its layout.
    """

    image: RangeImage
    layout: Layout
    pose: np.ndarray
    seed: int
    speed: float = 0.0
    turn: float = 0.0
    time: float | None = None
    velocities: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    heading: tuple[float, float, float] | None = None
    mount: tuple[float, float, float, float] | None = None
    assumed: tuple[str, ...] = ()

    @classmethod
    def from_points(
        cls,
        points: np.ndarray,
        sensor: Sensor,
        *,
        label: np.ndarray | None = None,
        instance: np.ndarray | None = None,
        intensity: np.ndarray | None = None,
        layout: Layout | None = None,
        pose: np.ndarray | None = None,
    ) -> Scan:
        """The scan of given points, [N, 3] [m] in the frame of `sensor`, with optional values [N] for each: class ids,
        instances as in `layout`, which is by default empty, and intensities in [0, 1].

        Each point becomes the return of its pixel: it keeps its range, and moves to the middle of its beam and column.
        Of several points in a pixel the nearest stays; a `UserWarning` and one of `notes` report the number left out.
        `pose` is world_from_sensor [4, 4], by default that of the sensor on its mount. Raises `LayoutError` naming the
        first invalid value.
        """
        check_type("sensor", sensor, Sensor)
        check_type("layout", layout := Layout() if layout is None else layout, Layout)
        image = RangeImage.project(points, sensor, label=label, instance=instance, intensity=intensity)
        low, high = (0, 0) if intensity is None else (np.min(intensity, initial=0), np.max(intensity, initial=0))
        if low < 0 or high > 1:
            raise LayoutError(f"intensity holds {low:g} to {high:g}; it must be 0 to 1, as by a division by 255")
        pose = sensor.pose() if pose is None else finite_array("pose", pose, 4, 4)
        count, returns = len(points), int(np.count_nonzero(image.depth))
        in_view = np.count_nonzero(sensor.pattern.project(np.ascontiguousarray(points, np.float64))[0] >= 0)
        lost = f"{in_view - returns} share a pixel of {sensor.name} with a nearer one, {count - in_view} out of sight"
        lines = () if returns == count else (f"{count - returns} of {count} points are left out: {lost}",)
        for line in lines:
            warnings.warn(line, stacklevel=2)
        return cls(image=image, layout=layout, pose=pose, seed=0, assumed=lines)

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of the layout, and the assumptions and omissions of this scan (`assumed`), a line each."""
        return (*self.layout.notes, *self.assumed)

    @cached_property
    def condition_image(self) -> RangeImage:
        """The cast of the layout from the same place: the condition of a generated scan."""
        if not (self.speed or self.turn):
            return raycast(self.layout, self.image.sensor, self.pose)
        return raycast(self.layout, self.image.sensor, poses=self.poses())

    def poses(self) -> np.ndarray:
        """The pose of each column, f64 [W, 4, 4]."""
        along = self.pose[:3, 0] if self.heading is None else np.array(self.heading)
        return self.image.sensor.poses_in_motion(self.pose, self.speed * along, (0.0, 0.0, self.turn))

    def points(self) -> np.ndarray:
        """x, y, z of the returns in the sensor's frame in the middle of the sweep [m], float32 [N, 3].

        They are in their boxes, as in KITTI: the sensor's own motion is taken out. `image.points()` still has it.
        """
        if not (self.speed or self.turn):
            return self.image.points()
        points = self.image.points(self.poses()) - self.pose[:3, 3]
        return (points @ self.pose[:3, :3]).astype(np.float32)

    def intensities(self) -> np.ndarray:
        """Intensities in [0, 1] of `points()`, float32 [N]; raises `SensorError` if the image has none."""
        if self.image.intensity is None:
            said = "`simulate` and `observe_cast` give one, `Scan.from_points` takes one"
            raise SensorError(f"no intensity in the image; {said}")
        return self.image.intensity[self.image.valid]

    def labels(self) -> np.ndarray:
        """Class ids of `points()`, uint8 [N]; 0 for points of nothing in the layout."""
        return self.image.label[self.image.valid]

    def instances(self) -> np.ndarray:
        """Instance numbers of `points()`, uint32 [N]; 0 for stuff."""
        return self.image.instance[self.image.valid]

    def boxes(self) -> list[Box]:
        """Boxes of the layout's objects in the sensor frame, with velocities in a frame of a sequence."""
        return [box.seen_from(self.pose) for box in self._boxes()]

    def _boxes(self) -> list[Box]:
        still = None if self.time is None else (0.0, 0.0, 0.0)
        velocities = (self.velocities.get(box.id.split(".", 1)[0], still) for box in self.layout.boxes())
        return [box.moving(each) for box, each in zip(self.layout.boxes(), velocities, strict=True)]

    def returns_per_box(self) -> list[int]:
        """The number of points of each of `boxes()`."""
        counts = np.bincount(self.instances(), minlength=2**16)
        return [int(counts[box.instance]) for box in self.layout.boxes()]

    def frame(self, *, as_seen: bool = False, box_margin: float = 0.0) -> Frame:
        """The frame from which data sets in foreign formats are written: `points()` and boxes grown by `box_margin` [m]
        on each side; with `as_seen` `image.points()`, with the sensor's motion, and their times.

        Raises `FormatError` if the margin is negative or not a number.
        """
        if not is_number(box_margin) or box_margin < 0:
            raise FormatError(f"box_margin is {box_margin!r}; it must be a number of metres, 0 or more")
        boxes, head = self.boxes(), self.layout.head()
        shares = occluded_shares(self.image, boxes, inverse(self.pose) @ self.poses())
        annotations = with_riders_merged(list(map(Annotation, boxes, self.returns_per_box(), shares)))
        return Frame(
            sensor=self.image.sensor,
            pose=self.pose,
            mount=self.mount,
            points=self.image.points() if as_seen else self.points(),
            intensity=self.intensities(),
            ring=self.image.beams(),
            time=self.image.times() if as_seen else None,
            label=self.labels(),
            instance=self.instances(),
            annotations=tuple(each.grown(box_margin) if box_margin else each for each in annotations),
            world=json.dumps({name: head[name] for name in ("provenance", "intent", "notes") if name in head}),
            start=None if self.time is None else self.time - self.image.sensor.sweep_time / 2,
        )

    def picture(self, *, by_label: bool = False) -> np.ndarray:
        """The points, with boxes, in a view of the objects and from above, over the range images: uint8 [H, W, 3]. The
        origin is the road under the sensor. Objects have the colours of their classes; the rest is coloured by height,
        or also by class."""
        (x, y, z), yaw = self.pose[:3, 3].tolist(), math.atan2(self.pose[1, 0], self.pose[0, 0])
        below = upright((x, y, z - self.image.sensor.mount_height), yaw)
        level = inverse(below) @ self.pose
        points = self.points() @ level[:3, :3].T + level[:3, 3]
        boxes, title = [box.seen_from(below) for box in self.layout.boxes()], view.title_of(self.layout)
        return view.render_returns(self.image, points, boxes=boxes, title=title, by_label=by_label)

    def html(self, most: int | None = None) -> str:
        """One self-contained page of HTML that shows points, boxes and classes in any browser; at most `most` points,
        evenly spread."""
        step = 1 if most is None else -(-len(self.labels()) // most)
        up = np.array([0.0, 0.0, self.image.sensor.mount_height])
        boxes = [box.raised(up[2]) for box in self.boxes()]
        fields = {name: values[::step] for name, values in view.fields_of(self.image).items()}
        title = view.title_of(self.layout) or self.image.sensor.name
        return view.html_page(self.points()[::step] + up, fields, boxes=boxes, title=title)

    def _repr_html_(self) -> str:
        page = escape(self.html(_MOST_IN_NOTEBOOKS))
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 480px; border: 0"></iframe>'

    def save(self, name: str | os.PathLike[str], *, picture: bool = True) -> None:
        """Write `NAME.bin`, `.label`, `.npz`, `.boxes.json`, `.layout.json`, `.sensor.json` and `.png`.

        The `.npz` is the range image, with pose, motion and seed: `load` reads it and the layout. A scan of an empty
        layout, whose objects are unknown, has no `.boxes.json`. An earlier scan of that name is replaced whole. Raises
        `FormatError` if a file cannot be written and `SensorError` on an image without intensity; then all files stay
        unchanged.
        """
        with written_together(name, SCAN_ENDINGS) as stem:
            kitti.write_bin(f"{stem}.bin", self.points(), self.intensities())
            semantickitti.write_label(f"{stem}.label", self.labels(), self.instances())
            self.image.save(f"{stem}.npz", pose=self.pose, seed=np.int64(self.seed), **self._motion())
            Path(f"{stem}.sensor.json").write_text(self.image.sensor.to_json())
            if self.layout.primitives:
                write_boxes(f"{stem}.boxes.json", self.boxes(), self.returns_per_box())
            self.layout.save(f"{stem}.layout.json")
            if picture:
                view.save_png(f"{stem}.png", self.picture())

    def _motion(self) -> dict[str, Any]:
        """The motion of the scan, as stored in the .npz."""
        in_sequence = self.time is not None
        said = {
            "speed": (self.speed, True),
            "turn": (self.turn, self.turn or in_sequence),
            "time": (self.time, in_sequence),
            "velocities": (json.dumps(dict(self.velocities)), self.velocities or in_sequence),
            "heading": (self.heading, self.heading is not None),
            "mount": (self.mount, self.mount is not None),
        }
        return {name: value for name, (value, is_known) in said.items() if is_known}

    @classmethod
    def load(cls, name: str | os.PathLike[str]) -> Scan:
        """The scan saved as `NAME`, which may end in .bin or .npz here. Without a stored pose, the layout is empty.
        Raises `FormatError` if `NAME.npz` or `NAME.layout.json` is missing or broken.
        """
        name = os.fspath(name).removesuffix(".bin").removesuffix(".npz")
        file = f"{name}.npz"
        image = RangeImage.load(file)
        motion = read_motion(file)
        if "pose" not in motion:
            return cls(image=image, layout=Layout(), pose=image.sensor.pose(), seed=0)
        return cls(image=image, layout=Layout.load(f"{name}.layout.json"), **{"seed": 0, **motion})

    def __repr__(self) -> str:
        return f"Scan({self.image!r}, {self.layout!r}, seed {self.seed}, {self.speed:g} m/s)"


def read_motion(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The `pose`, `speed`, `heading`, `turn`, `time`, `velocities`, `mount` and `seed` in a .npz of a scan or a cast:
    arguments of `Scan`. Raises `FormatError` naming the broken part."""
    said: dict[str, Any] = {}
    with array_files.opened(path) as archive:
        names = [name for name in ("speed", "turn", "time", "seed") if array_files.holds(archive, name)]
        said |= {name: array_files.read_numbers(archive, name, ()).item() for name in names}
        if array_files.holds(archive, "pose"):
            said["pose"] = finite_array("pose", array_files.read_numbers(archive, "pose", (4, 4)), 4, 4)
        for name, length in (("heading", 3), ("mount", 4)):
            if array_files.holds(archive, name):
                said[name] = tuple(array_files.read_numbers(archive, name, (length,)).tolist())
        if array_files.holds(archive, "velocities"):
            velocities = parse_object(array_files.read_text(archive, "velocities"))
            said["velocities"] = {key: checked_vector(key, "velocity", row) for key, row in velocities.items()}
    return said
