"""Numbers of SVG: lengths with units, transforms, and the outlines of its shapes as polylines.

All of it as in the W3C's recommendation "Scalable Vector Graphics 1.1"; points are (right, down).
"""

from __future__ import annotations

import math
import re

import numpy as np

from lidardraft.errors import FormatError

# Pixels of CSS, of which an inch has 96.
PIXELS = {"": 1.0, "px": 1.0, "in": 96.0, "cm": 96 / 2.54, "mm": 96 / 25.4, "pt": 96 / 72, "pc": 16.0, "q": 96 / 101.6}
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([a-zA-Z%]*)\s*")
_NUMBERS = re.compile(_NUMBER)
_TRANSFORM = re.compile(r"\s*,?\s*(\w+)\s*\(([^()]*)\)")
LARGEST = 1e7  # units; further away is no sketch
_ARC_STEP = math.radians(10)
_T = np.linspace(0.0, 1.0, 13)[1:]
# How much each control point counts, for curves of three and of four.
_BERNSTEIN = {
    count: np.stack([math.comb(count - 1, k) * _T**k * (1 - _T) ** (count - 1 - k) for k in range(count)], axis=1)
    for count in (3, 4)
}
_MOST_NUMBERS = 400_000  # of one list


def length(text: str, name: str, whole: float | None = None) -> float:
    """A length in pixels, such as "12.5", "3mm", or "40%" of a `whole`; raises `FormatError` naming the attribute."""
    match = _LENGTH.fullmatch(text[:100])
    if match:
        unit = whole / 100 if match[2] == "%" and whole is not None else PIXELS.get(match[2].lower())
        if unit is not None and abs(value := float(match[1]) * unit) < LARGEST:
            return value
    units = ", ".join(filter(None, PIXELS))
    raise FormatError(f"{name} is {text!r:.60}; it must be a length of up to {LARGEST:g} pixels in {units} or none")


def numbers(text: str, name: str) -> np.ndarray:
    """The numbers of a list, f64 [N]; raises `FormatError` naming the attribute."""
    found = _NUMBERS.findall(text)
    rest = _NUMBERS.sub("", text).strip(" ,\t\r\n")
    values = np.array(found[:_MOST_NUMBERS], dtype=np.float64)
    if rest.strip(", \t\r\n") or len(found) > _MOST_NUMBERS or not (np.abs(values) < LARGEST).all():
        raise FormatError(f"{name} is {text!r:.60}; it must be a list of numbers of up to {LARGEST:g}")
    return values


def transform(text: str) -> np.ndarray:
    """The matrix [3, 3] of a list of transforms, for columns (right, down, 1)."""
    matrix, at = np.eye(3), 0
    text = text.strip()
    while at < len(text):
        match = _TRANSFORM.match(text, at)
        made = _single_transform(match[1], numbers(match[2], "transform").tolist()) if match else None
        if match is None or made is None:
            raise FormatError(f"transform is {text!r:.60}; a part of it is not known")
        matrix, at = matrix @ made, match.end()
        if not (np.abs(matrix) < LARGEST).all():
            raise FormatError(f"transform is {text!r:.60}; it moves too far")
    return matrix


def _single_transform(name: str, values: list[float]) -> np.ndarray | None:
    match name, values:
        case "matrix", [a, b, c, d, e, f]:
            return np.array([[a, c, e], [b, d, f], [0, 0, 1]])
        case "translate", [x, *rest] if len(rest) < 2:
            return np.array([[1, 0, x], [0, 1, *(rest or [0.0])], [0, 0, 1]])
        case "scale", [x, *rest] if len(rest) < 2:
            return np.diag([x, *(rest or [x]), 1.0])
        case "rotate", [angle, *rest] if len(rest) in (0, 2):
            cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            x, y = rest or (0.0, 0.0)
            return np.array([[cos, -sin, x - cos * x + sin * y], [sin, cos, y - sin * x - cos * y], [0, 0, 1]])
        case "skewX", [angle]:
            return np.array([[1, math.tan(math.radians(angle)), 0], [0, 1, 0], [0, 0, 1]])
        case "skewY", [angle]:
            return np.array([[1, 0, 0], [math.tan(math.radians(angle)), 1, 0], [0, 0, 1]])
    return None


def ellipse(x: float, y: float, across: float, down: float) -> np.ndarray:
    """The outline [N, 2] of an ellipse about a place with two radii."""
    turns = np.linspace(0.0, math.tau, 33)
    return np.stack([x + across * np.cos(turns), y + down * np.sin(turns)], axis=1)


def bezier(points: np.ndarray) -> np.ndarray:
    """Places [N, 2] on a curve with control points [3 or 4, 2], without its begin."""
    curve: np.ndarray = _BERNSTEIN[len(points)] @ points
    return curve


def arc(
    begin: np.ndarray, radii: tuple[float, float], turn: float, large: bool, sweep: bool, end: np.ndarray
) -> np.ndarray:
    """Places [N, 2] on an elliptical arc, without its begin; appendix F.6 of the recommendation."""
    rx, ry = abs(radii[0]), abs(radii[1])
    if rx == 0 or ry == 0 or np.array_equal(begin, end):
        return end[None]
    cos, sin = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    rotation = np.array([[cos, sin], [-sin, cos]])
    x, y = (rotation @ (begin - end) / 2).tolist()
    if (grow := math.sqrt((x / rx) ** 2 + (y / ry) ** 2)) > 1:
        rx, ry = rx * grow, ry * grow
    share = max(0.0, (rx * ry) ** 2 - (rx * y) ** 2 - (ry * x) ** 2) / ((rx * y) ** 2 + (ry * x) ** 2)
    factor = math.sqrt(share) * (1 if large != sweep else -1)
    cx, cy = factor * rx * y / ry, -factor * ry * x / rx
    center = rotation.T @ (cx, cy) + (begin + end) / 2
    first = math.atan2((y - cy) / ry, (x - cx) / rx)
    turned = math.atan2((-y - cy) / ry, (-x - cx) / rx) - first
    if sweep and turned < 0:
        turned += math.tau
    if not sweep and turned > 0:
        turned -= math.tau
    angles = first + turned * np.linspace(0.0, 1.0, max(2, math.ceil(abs(turned) / _ARC_STEP) + 1))[1:]
    points: np.ndarray = np.stack([rx * np.cos(angles), ry * np.sin(angles)], axis=1) @ rotation + center
    points[-1] = end
    return points
