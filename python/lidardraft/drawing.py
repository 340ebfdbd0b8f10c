"""A virtual camera in a layout or a scan, and drawings of the points and boxes in its view."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from lidardraft.scene.box import Box

Colour = tuple[int, int, int]
_TEXT = (214, 221, 235)
_RING, _RING_NAME, _EGO = (62, 76, 104), (128, 142, 172), (235, 239, 248)
_TOP, _BOTTOM = (27, 34, 52), (11, 13, 21)  # the background, darker towards the eye
_EGO_BOX = Box("ego", "car", 0, (0.0, 0.0, 0.8), (4.5, 1.9, 1.5), 0.0)
_NEAR = 1.0  # m, the least distance that is drawn
_POINT, _LEAST, _MOST = 0.06, 2, 4  # m, the width of a point; its least and most pixels in a picture of _USUAL rows
_USUAL = 560
_SKY = 1000.0  # m, the height of an eye for views from above
_PITCHES = (32.0, 42.0)  # degrees down
# Bearings of the eye [degrees] from its target, in order of preference: behind the ego vehicle and a little to the
# side.
_BEARINGS = (190.0, 170.0, 215.0, 145.0, 250.0, 110.0, 15.0, -15.0)
_NEAREST, _FURTHEST = 17.0, 46.0  # m from the target
_FOCAL = 1.15  # times the height of the picture
_MARGIN = 0.85  # of half the picture: the share that its content may fill
_LIKED = 1.4  # a later bearing must be nearer by this factor to be taken
_AHEAD = np.array([(25.0, 10.0, 0.0), (25.0, -10.0, 0.0)])
_PATHS = ([0, 1, 2, 3, 0, 4, 5, 6, 7, 4], [1, 5], [2, 6], [3, 7], [8, 9])  # along the edges; 8 to 9 is the heading


def _axes(bearing: float, pitch: float) -> np.ndarray:
    """The axes [3, 3] of an eye at that bearing from its target, `pitch` over the horizon [rad]."""
    cos, sin = math.cos(bearing), math.sin(bearing)
    ahead = np.array([-cos * math.cos(pitch), -sin * math.cos(pitch), -math.sin(pitch)])
    left = np.array([sin, -cos, 0.0])
    return np.stack([ahead, left, np.cross(ahead, left)], axis=1)


_VIEWS = np.stack([_axes(bearing, pitch) for pitch in np.radians(_PITCHES) for bearing in np.radians(_BEARINGS)])


@dataclass(frozen=True, eq=False)
class Eye:
    """A pinhole camera of `width` x `height` pixels that faces along the x axis of `pose`, world_from_camera [4, 4];
    `focal` is in pixels."""

    pose: np.ndarray
    focal: float
    width: int
    height: int

    @classmethod
    def above(cls, *, width: int, height: int, reach: float) -> Eye:
        """Far above the origin, facing straight down; up in the picture is ahead, and its upper edge is `reach` [m]
        away."""
        pose = np.array([[0, 0, 1.0, 0], [0, 1.0, 0, 0], [-1.0, 0, 0, _SKY], [0, 0, 0, 1.0]])
        return cls(pose, _SKY * height / 2 / reach, width, height)

    @classmethod
    def showing(cls, places: np.ndarray, *, width: int, height: int) -> Eye:
        """As near as possible with `places` [N, 3] and the ego vehicle in the picture, from behind or from the nearest
        side. Without places it faces ahead."""
        places = np.concatenate([corners_of([_EGO_BOX])[0], places if len(places) else _AHEAD])
        target, focal = (places.min(axis=0) + places.max(axis=0)) / 2, _FOCAL * height
        ahead, left, up = np.moveaxis((places - target) @ _VIEWS, 2, 0)  # [V, N] each
        needed = 2 * focal / _MARGIN * np.maximum(np.abs(left) / width, np.abs(up) / height) - ahead
        distances = needed.max(axis=1).clip(_NEAREST, _FURTHEST)
        best = int(np.argmax(distances <= _LIKED * distances.min()))
        distance, axes = distances[best], _VIEWS[best]
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = axes, target - distance * axes[:, 0]
        return cls(pose, focal, width, height)

    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Origins and unit directions [H W, 3] of the pixels' rays."""
        rows, columns = np.mgrid[: self.height, : self.width] + 0.5
        ahead = np.full(rows.shape, self.focal)
        across = np.stack([ahead, self.width / 2 - columns, self.height / 2 - rows], axis=-1).reshape(-1, 3)
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        return np.broadcast_to(self.pose[:3, 3], across.shape), across @ self.pose[:3, :3].T

    def seen(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Column, row and distance ahead [m] of points [N, 3]; column and row are valid if the distance is positive."""
        pose = self.pose.astype(points.dtype)
        ahead, left, up = pose[:3, :3].T @ (points - pose[:3, 3]).T
        scale = self.focal / np.maximum(ahead, _NEAR)
        return self.width / 2 - left * scale, self.height / 2 - up * scale, ahead


class Drawing:
    """The view of an eye, drawn in the order of the calls over a dark background with rings of the distance; lines are
    `line` pixels wide."""

    def __init__(self, eye: Eye, rings: Iterable[int] = (10, 20, 30, 40, 50, 60)) -> None:
        self.eye, self.line = eye, max(1, round(eye.height / _USUAL))
        share = np.linspace(0.0, 1.0, eye.height)[:, None] ** 0.7
        rows = np.full((eye.height, 4), 255, dtype=np.uint8)
        rows[:, :3] = np.rint(np.array(_TOP) * (1 - share) + np.array(_BOTTOM) * share)
        # a pixel is one number of four bytes: three bytes each take three times as long
        self._pixels = np.repeat(rows.view(np.uint32), eye.width, axis=1)
        # Points are written into the memory that the pen draws on: copies would take as long as the points.
        self._canvas = Image.frombuffer("RGBA", (eye.width, eye.height), self._pixels, "raw", "RGBA", 0, 1)
        self._canvas.readonly = 0
        self._pen = ImageDraw.Draw(self._canvas)
        for radius in rings:
            self._ring(radius)

    def picture(self) -> np.ndarray:
        """uint8 [H, W, 3]."""
        return np.asarray(self._canvas.convert("RGB"))

    def _ring(self, radius: int) -> None:
        eye, angle = self.eye, np.linspace(0.0, math.tau, 121)
        places = np.stack(eye.seen(radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)), axis=1)
        behind = np.flatnonzero(places[:, 2] <= _NEAR)
        if len(behind):  # the ring begins at the edge of the view
            places = np.roll(places[:-1], -int(behind[-1]) - 1, axis=0)
            places = places[places[:, 2] > _NEAR]
        self._pen.line(places[:, :2].ravel().tolist(), fill=_RING, width=self.line)
        column, row, _ = places.T
        inside = (column > 0) & (column < eye.width - 44 * self.line) & (row > 0) & (row < eye.height - 20)
        if inside.any():  # its name is on the right, at a height that keeps names apart
            best = np.argmax(np.where(inside, column - row / 2, -math.inf))
            self.text((float(column[best]) + 4, float(row[best])), f"{radius} m", 12 * self.line, _RING_NAME)

    def points(self, points: np.ndarray, colours: np.ndarray) -> None:
        """Draw points [N, 3] in their colours uint8 [N, 3], the nearest over the others and larger."""
        eye, most = self.eye, _MOST * self.line
        column, row, ahead = eye.seen(points)
        inside = (column >= 0) & (column <= eye.width - most) & (row >= 0) & (row <= eye.height - most)
        kept = np.flatnonzero(inside & (ahead > _NEAR))
        if not len(kept):
            return
        depth = ahead[kept]
        # the furthest are written first; sixteen bits are sorted ten times as fast as floats
        step = max(float(np.ptp(depth)), 1e-3) / 65535
        kept = kept[np.argsort(((depth.max() - depth) / step).astype(np.uint16), kind="stable")]
        wide = np.clip(eye.focal * _POINT / ahead[kept], _LEAST * self.line, most).astype(np.int64)
        pixel = row[kept].astype(np.int64) * eye.width + column[kept].astype(np.int64)
        opaque = np.full((len(kept), 4), 255, dtype=np.uint8)
        opaque[:, :3] = colours[kept]
        colour, flat = opaque.view(np.uint32)[:, 0], self._pixels.reshape(-1)
        for size in range(int(wide.min()), int(wide.max()) + 1):  # the large ones are near
            some = wide == size
            corner, paint = pixel[some], colour[some]
            for down, right in itertools.product(range(size), repeat=2):
                flat[corner + (down * eye.width + right)] = paint

    def boxes(self, boxes: Sequence[Box], colours: Sequence[Colour]) -> None:
        """Draw the edges of boxes, and on the ground a line from the middle of each in its heading."""
        corners = corners_of(boxes)
        floor, front = corners[:, :4].mean(axis=1, keepdims=True), corners[:, 1:3].mean(axis=1, keepdims=True)
        points = np.concatenate([corners, floor, 1.25 * front - 0.25 * floor], axis=1)
        column, row, ahead = self.eye.seen(points.reshape(-1, 3))
        places = np.stack([column, row], axis=1).reshape(-1, 10, 2)
        in_sight = np.flatnonzero((ahead > _NEAR).reshape(-1, 10).all(axis=1))
        paths = [places[:, path].reshape(len(boxes), 2 * len(path)).tolist() for path in _PATHS]
        for number in in_sight.tolist():
            for path in paths:
                self._pen.line(path[number], fill=colours[number], width=self.line)

    def ego(self) -> None:
        """Draw the vehicle at the origin, which carries the sensor."""
        self.boxes([_EGO_BOX], [_EGO])

    def text(self, place: tuple[float, float], text: str, size: int, colour: Colour = _TEXT) -> None:
        """Write a line of text with its upper left corner at `place`, column and row."""
        self._pen.text(place, text, fill=colour, font=font(size))

    def title(self, place: tuple[float, float], text: str, size: int) -> None:
        """As `text`, on a dark ground, which hides the points behind it."""
        left, top, right, bottom = self._pen.textbbox(place, text, font=font(size))
        self._pen.rectangle((left - size / 2, top - size / 2, right + size / 2, bottom + size / 2), fill=_TOP)
        self.text(place, text, size)

    def legend(self, place: tuple[float, float], entries: Sequence[tuple[str, Colour]], size: int) -> None:
        """Write names beside their colours, in one row on a dark ground from `place` on, as many as fit."""
        (column, row), letters = place, font(size)
        for name, colour in entries:
            width = 1.6 * size + letters.getlength(name)
            if column + width > self.eye.width:
                break
            self._pen.rectangle((column - size, row - size / 3, column + width, row + 1.4 * size), fill=_BOTTOM)
            self._pen.rectangle((column, row + size / 6, column + size, row + size), fill=colour)
            self.text((column + 1.4 * size, row), name, size)
            column += width + size


def corners_of(boxes: Sequence[Box]) -> np.ndarray:
    """The corners [M, 8, 3] of boxes, each as in `Box.corners`."""
    return np.array([box.corners() for box in boxes]).reshape(-1, 8, 3)


@lru_cache(maxsize=8)
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The font of all pictures, `size` pixels high."""
    return ImageFont.load_default(size)
