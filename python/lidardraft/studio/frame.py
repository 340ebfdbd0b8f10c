"""One moment in a page: coloured points, boxes, and the point under the mouse."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.drawing import corners_of
from lidardraft.scan import Scan
from lidardraft.scene.box import Box
from lidardraft.scene.layout import Layout, object_of, primitive_mesh
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME, CLASSES
from lidardraft.studio.document import Look
from lidardraft.view import PALETTE, colour_by_depth, colour_by_height, colour_by_label, colour_by_share, colour_returns

_SEEN = 5  # the least returns of an object with its box shown
_BESIDE = 70.0  # m to the right: the place of the second sensor's points
_PICKED_WITHIN = 0.012  # rad between a click and a point
_FRONT = 1.0  # m behind the nearest candidate: further points are in the background
_EDGES = np.array([(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)])
_RANGES = (2.0, 80.0)  # m, of the ramp of ranges
_STRIP = 1024  # columns of a shown range image
_HIGHEST = 12.0  # m, of the ramp of heights


@dataclass(frozen=True, eq=False)
class Frame:
    """`points` float32 [N, 3] in the world [m] and `colours` uint8 [N, 3] of the scans of one moment; `pixels` [N, 3]
    are the number of the scan, row and column of each. It is `whole` unless it is of quick scans."""

    scans: tuple[Scan, ...]
    look: Look
    points: np.ndarray
    colours: np.ndarray
    pixels: np.ndarray
    whole: bool

    @property
    def layout(self) -> Layout:
        """The layout as it stands."""
        return self.scans[0].layout

    def boxes(self) -> list[Box]:
        """Boxes of objects with returns, in shown classes."""
        image = self.scans[0].image
        counts = np.bincount(image.instance[image.valid], minlength=2**16)
        hidden = {CLASSES[number].name for number in self.look.hidden}
        return [box for box in self.layout.boxes() if counts[box.instance] >= _SEEN and box.label not in hidden]

    def picked(self, origin: Sequence[float], direction: Sequence[float]) -> Pick | None:
        """The return on a ray, or None: of the foremost returns near the ray, the one closest to it."""
        ways = self.points - np.array(origin, np.float32)
        along = ways @ np.array(direction, np.float32)
        off = np.linalg.norm(ways - along[:, None] * np.array(direction, np.float32), axis=1)
        near = np.flatnonzero((along > 0.5) & (off < np.maximum(along * _PICKED_WITHIN, 0.05)))
        if not len(near):
            return None
        near = near[along[near] < along[near].min() + _FRONT]
        number = near[np.argmin(off[near] / along[near])]
        which, row, column = self.pixels[number].tolist()
        return self._at(which, row, column, self.points[number] + (0.0, _BESIDE * which, 0.0))

    def _at(self, which: int, row: int, column: int, place: np.ndarray) -> Pick:
        image = self.scans[which].image
        instance = int(image.instance[row, column])
        name = next((object_of(part) for part in self.layout if instance and part.instance == instance), "")
        return Pick(
            row,
            column,
            float(image.depth[row, column]),
            CLASSES[int(image.label[row, column])].name,
            name or _nearest_object(self.layout, place, CLASSES[int(image.label[row, column])].name),
            None if image.intensity is None else float(image.intensity[row, column]),
            which,
        )

    def strips(self, pick: Pick | None = None) -> np.ndarray:
        """The range images one above the other in the colours of the points, uint8 [H, W, 3]; a cross is at `pick`."""
        return np.concatenate(
            [_strip(scan, self.look, pick if pick and pick.scan == k else None) for k, scan in enumerate(self.scans)]
        )


@dataclass(frozen=True, slots=True)
class Pick:
    """The return of a pixel: its range [m], class and object, or "", its intensity if it has one, and the number of its
    scan."""

    row: int
    column: int
    range: float
    label: str
    object: str
    intensity: float | None
    scan: int = 0


def frame_of(scans: Sequence[Scan], look: Look, *, whole: bool = True) -> Frame:
    """The frame of scans of one moment."""
    points, colours, pixels = [], [], []
    for number, scan in enumerate(scans):
        shown = scan.image.valid & ~np.isin(scan.image.label, list(look.hidden))
        if not look.points:
            shown[:] = False
        image = scan.image.keep(shown)
        places = _placed(scan, image)
        colours.append(colours_of(image, places[:, 2], look.colour))
        points.append(places - np.array([0.0, _BESIDE * number, 0.0], np.float32))
        rows, columns = np.nonzero(image.valid)
        pixels.append(np.stack([np.full(len(rows), number), rows, columns], axis=1))
    return Frame(tuple(scans), look, np.concatenate(points), np.concatenate(colours), np.concatenate(pixels), whole)


def _placed(scan: Scan, image: RangeImage) -> np.ndarray:
    """The points of an image of a scan in the world, float32 [N, 3]."""
    poses = (scan.poses() if scan.speed or scan.turn else scan.pose[None])[:, :3].astype(np.float32)
    columns = np.nonzero(image.valid)[1] if len(poses) > 1 else np.zeros(np.count_nonzero(image.valid), np.int64)
    x, y, z = image.points().T
    rows = [poses[columns, k, 0] * x + poses[columns, k, 1] * y + poses[columns, k, 2] * z for k in range(3)]
    return np.stack(rows, axis=1) + poses[columns, :, 3]


def colours_of(image: RangeImage, z: np.ndarray, colour: str) -> np.ndarray:
    """The colours uint8 [N, 3] of the returns of an image at heights `z` [N], by one of `COLOURS`."""
    valid = image.valid
    if colour == "height":
        return colour_by_height(z)
    if colour == "class":
        return colour_by_label(image.label[valid])
    if colour == "range":
        return colour_by_depth(image.depth[valid])
    if colour == "ring":
        return colour_by_share(image.beams() / max(image.sensor.shape[0] - 1, 1))
    if colour == "intensity" and image.intensity is not None:
        return colour_by_share(image.intensity[valid])
    if colour == "object":
        # adjacent numbers get hues far apart, by the golden ratio
        instance = image.instance[valid]
        own = colour_by_share((instance * 0.618034) % 1.0)
        return np.where((instance > 0)[:, None], own, np.uint8(70))
    return colour_returns(image, z)


@dataclass(frozen=True, slots=True)
class ColourBar:
    """The colours of evenly spaced values, as #rrggbb, and the texts under them; no colours if none are needed."""

    colours: tuple[str, ...]
    texts: tuple[str, ...]


def colour_bar(colour: str, beams: int) -> ColourBar:
    """The meaning of the colours of a scan with `beams` beams."""
    share = np.linspace(0.0, 1.0, 24)
    low, high = _RANGES
    rows: Mapping[str, tuple[np.ndarray, tuple[str, ...]]] = {
        "range": (colour_by_depth(low * (high / low) ** share), ("2 m", "13 m", "80 m")),
        "intensity": (colour_by_share(share), ("0", "0.5", "1")),
        "ring": (colour_by_share(share), ("ring 0, the highest", f"ring {beams - 1}")),
        "height": (colour_by_height(_HIGHEST * share), ("0 m", "6 m", "12 m over the road")),
    }
    known = {**rows, "objects and height": rows["height"]}.get(colour)
    if known is None:
        return ColourBar((), ("as beside the classes below",) if colour == "class" else ("a colour for each object",))
    return ColourBar(tuple("#{:02x}{:02x}{:02x}".format(*row) for row in known[0].tolist()), known[1])


def box_lines(boxes: Sequence[Box]) -> tuple[np.ndarray, np.ndarray]:
    """The edges of boxes as segments [M, 2, 3], a mark of the heading of each, and their colours uint8 [M, 2, 3]."""
    corners = corners_of(boxes)
    floor, front = corners[:, :4].mean(axis=1), corners[:, 1:3].mean(axis=1)
    ahead = np.stack([floor, 1.3 * front - 0.3 * floor], axis=1)[:, None]
    lines = np.concatenate([corners[:, _EDGES], ahead], axis=1)
    colours = np.array([PALETTE[BY_NAME[box.label].id] for box in boxes]).reshape(-1, 1, 1, 3)
    return (
        lines.reshape(-1, 2, 3).astype(np.float32),
        np.broadcast_to(colours, (*lines.shape[:3], 3)).reshape(-1, 2, 3).astype(np.uint8),
    )


def meshes_of(layout: Layout, hidden: frozenset[int]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The shapes of a layout as one mesh a class: vertices float32 [V, 3] and faces [F, 3]."""
    found: dict[str, tuple[list[np.ndarray], list[np.ndarray], int]] = {}
    for part in layout:
        if BY_NAME[part.label].id not in hidden:
            mesh = primitive_mesh(part)
            vertices, faces, count = found.get(part.label, ([], [], 0))
            vertices.append(mesh.vertices)
            faces.append(mesh.faces + count)
            found[part.label] = vertices, faces, count + len(mesh.vertices)
    return {
        label: (np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.uint32))
        for label, (vertices, faces, _) in found.items()
    }


def _nearest_object(layout: Layout, place: np.ndarray, label: str) -> str:
    """The object of a class without instances, such as a tree, that a point in the world most probably is on, or ""."""
    x, y, z = place.tolist()
    away = {
        object_of(part): max(
            math.hypot(part.center[0] - x, part.center[1] - y) - math.hypot(*part.size[:2]) / 2,
            abs(part.center[2] - z) - part.size[2] / 2,
        )
        for part in layout
        if part.label == label and not part.instance
    }
    nearest = min(away, key=lambda name: away[name], default="")
    return nearest if nearest and away[nearest] < 1.0 else ""


def _strip(scan: Scan, look: Look, pick: Pick | None) -> np.ndarray:
    image = scan.image
    picture = np.full((*image.sensor.shape, 3), 24, np.uint8)
    picture[image.valid] = colours_of(image, _placed(scan, image)[:, 2], look.colour)
    picture[np.isin(image.label, list(look.hidden))] = 24
    if pick is not None:
        picture[pick.row] |= 96
        picture[:, max(pick.column - 1, 0) : pick.column + 2] |= 96
    rows, columns = picture.shape[:2]
    some = np.linspace(0, columns - 1, _STRIP).astype(np.int64)
    return np.repeat(picture[:, some], max(1, round(_STRIP / 10 / rows)), axis=0)
