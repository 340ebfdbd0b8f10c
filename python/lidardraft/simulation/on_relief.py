"""A level layout on its relief: **the** place where the ground rises and falls under the objects on it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator

import numpy as np

from lidardraft.objects.buildings import MOST_PLINTH
from lidardraft.scene.layout import AROUND, Layout, Primitive, object_of, primitive_mesh
from lidardraft.scene.pose import point_at
from lidardraft.scene.relief import Relief
from lidardraft.scene.road_surfaces import drawn
from lidardraft.semantics import GROUND
from lidardraft.simulation.detail.fitting import changed
from lidardraft.simulation.motion.motions import Ground

_FEET = 0.01  # m over the bottom of an object: parts that low stand on the ground
_BARRIERS, _PIECE = ("wall", "fence", "vegetation"), 4.0  # classes whose long boxes follow the ground in pieces, m


def on_relief(layout: Layout) -> Layout:
    """The layout on the relief of its roads: the ground rises and falls, and objects keep their height over it and
    their place in plan. A layout without a relief, or already on it, stays as it is.

    Long walls, fences and hedges that were asked for follow the ground in pieces. The roads get the heights of the
    ground. Give `simulate` the level layout: on its relief, the places of lines and kerbs are unknown.
    """
    return both_on_relief(layout, lambda level: level)[0]


def without_relief(layout: Layout) -> Layout:
    """The layout without its relief: its ground stays level."""
    if layout.roads is None or layout.roads.relief is None:
        return layout
    return dataclasses.replace(layout, roads=layout.roads.but(relief=None))


def both_on_relief(layout: Layout, detailed: Callable[[Layout], Layout]) -> tuple[Layout, Layout]:
    """`on_relief` of a layout and of its details; the layout gets the lines and kerbs of these."""
    relief = None if layout.roads is None else layout.roads.relief
    if layout.roads is None or relief is None:
        return layout, detailed(layout)
    raised = dataclasses.replace(layout, primitives=tuple(_raised(layout, relief)))
    scene = detailed(raised)
    laid = {part.id: _laid(part, relief) for part in (*raised, *scene) if part.label in GROUND}
    shown = {one.id for one in layout.roads.drawn or drawn(raised)}
    whole = {part.id: part for part in raised} | laid

    def height(points: np.ndarray) -> np.ndarray:
        return Ground(Layout(tuple(laid.values()))).at(points)[0]

    seen = drawn(laid[id] for id in laid if id in shown)
    roads = layout.roads.but(relief=None, drawn=seen, ground=height)
    parts = tuple(laid.get(part.id, part) for part in scene)
    layout = dataclasses.replace(raised, primitives=tuple(whole.values()), roads=roads)
    return layout, dataclasses.replace(scene, primitives=parts, roads=roads)


def _raised(layout: Layout, relief: Relief) -> Iterator[Primitive]:
    """The objects, each raised as a whole by the ground under its feet, and the level ground.

    Buildings stand at most a plinth above the lowest ground under their corners.
    """
    parts = list(_pieces(layout))
    names: dict[str, int] = {}
    owner = np.array([names.setdefault(part.id if alone else object_of(part), len(names)) for part, alone in parts])
    center, size = (np.array([getattr(part, name) for part, _ in parts]) for name in ("center", "size"))
    bottom = center[:, 2] - size[:, 2] / 2
    lowest = np.full(len(names), np.inf)
    np.minimum.at(lowest, owner, bottom)
    feet = bottom < lowest[owner] + _FEET
    count = np.bincount(owner, feet)
    middle = np.column_stack([np.bincount(owner, feet * center[:, axis]) / count for axis in (0, 1)])
    rise = relief.at(middle)
    built = np.flatnonzero([part.label == "building" and on for (part, _), on in zip(parts, feet, strict=True)])
    yaw, half = np.array([parts[k][0].yaw for k in built.tolist()]), size[built, :2] / 2
    ahead = np.column_stack([np.cos(yaw), np.sin(yaw)]) * half[:, :1]
    aside = np.column_stack([-np.sin(yaw), np.cos(yaw)]) * half[:, 1:]
    for corner in (ahead + aside, ahead - aside, -ahead - aside, aside - ahead):
        np.minimum.at(rise, owner[built], relief.at(center[built, :2] + corner) + MOST_PLINTH)
    for (part, _), up in zip(parts, rise[owner].tolist(), strict=True):
        x, y, z = part.center
        yield part if part.label in GROUND else changed(part, center=(x, y, z + up))


def _pieces(layout: Layout) -> Iterator[tuple[Primitive, bool]]:
    """The parts of a layout, with long barriers in pieces, and whether each part follows the ground by itself."""
    for part in layout:
        follows = part.label in _BARRIERS and part.shape == "box" and part.extinction is None
        if not follows or part.id.startswith(AROUND) or max(part.size[:2]) <= _PIECE:
            yield part, follows and not part.id.startswith(AROUND)
            continue
        length, width, height = part.size
        count = math.ceil(max(length, width) / _PIECE)
        size = (length / count, width, height) if length >= width else (length, width / count, height)
        for number in range(count):
            off = (number + 0.5 - count / 2) * max(length, width) / count
            ahead, left = (off, 0.0) if length >= width else (0.0, off)
            center = (*point_at((*part.center[:2], part.yaw), ahead, left), part.center[2])
            id = f"{part.id}.piece_{number}" if number else part.id
            yield changed(part, id=id, center=center, size=size), True


def _laid(part: Primitive, relief: Relief) -> Primitive:
    """A surface of level ground, laid on the relief."""
    mesh = relief.laid(primitive_mesh(part))
    fields = {"label": part.label, "id": part.id, "instance": part.instance, **part.more()}
    return Primitive.from_mesh(mesh.vertices, mesh.faces, **fields)
