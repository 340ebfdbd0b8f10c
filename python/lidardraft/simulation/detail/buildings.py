"""Buildings: houses, blocks and sheds from thick boxes, fronts with windows from thin ones."""

from __future__ import annotations

import math

from lidardraft.objects.buildings import EAVES
from lidardraft.objects.facades import RECESS, STOREY, WINDOW_BAY, front
from lidardraft.objects.kinds import KINDS
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.detail.fitting import fitted, solid, stretched
from lidardraft.simulation.detail.surroundings import Surroundings

# By their names here and in sentences.
_KINDS = {
    word: name for name, kind in KINDS.items() if kind.labels == ("building",) for word in (name, kind.word) if word
}
_PROUD = {"house": (EAVES, EAVES, 0.0), "block": (0.05, 0.05, 0.0), "shed": (0.1, 0.1, 0.0)}  # m
# Estimates [m].
_FRONT = 1.3  # thickness up to which a box is a front without a body
_LEAST_FRONT = (1.8, 2.0)  # length and height of a front with windows
_MOST_WINDOWS = 100  # bays of a front, and storeys: more would take memory without a limit
_LEAST_BODY = (3.0, 2.2)  # length or width, and height, of a box that becomes a building
_HOUSE = (16.0, 9.0)  # longest and highest
_SHED = (4.5, 3.6)  # narrower or lower than this
_RISE, _LEAST_RISE, _MOST_RISE = 0.42, 0.25, 0.45  # of a roof: share of the width; least and most share of the height
_OPENINGS = (0.36, 0.45, 0.6)  # shares of a bay that are window, as in streets
# The same for clusterings, which have the walls that sent rays back. PandaSet's fronts lose 1.8 % of their firings; a
# share of 0.2 loses 2.3 %, the shares above 2.8 %.
_CLUSTERED_OPENING = 0.2
_LEDGE = 0.045  # m that sills and ledges stand out of a wall


def building(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """Each box as a building or a front; boxes too small for either stay as they are."""
    made = []
    for part in coarse.parts:
        box = UprightBox.around([part])
        length, width, height = box.size
        if part.shape != "box" or height < _LEAST_FRONT[1] or max(length, width) < _LEAST_FRONT[0]:
            made.append(solid(part))
        elif min(length, width) <= _FRONT:
            made += _front(coarse, box, surroundings)
        elif min(length, width) < _LEAST_BODY[0] or height < _LEAST_BODY[1]:
            made.append(solid(part))
        else:
            made += _body(coarse, _facing(box, surroundings.road_side(box)))
    return made


def _body(coarse: CoarseObject, box: UprightBox) -> list[Primitive]:
    length, width, height = box.size
    kind = _KINDS.get(coarse.word)
    if kind is None:
        longest, highest = _HOUSE
        small = min(length, width) < _SHED[0] or height < _SHED[1]
        kind = "shed" if small else "house" if max(length, width) <= longest and height <= highest else "block"
    rise = min(max(_RISE * min(length, width), _LEAST_RISE * height), _MOST_RISE * height)
    return fitted(coarse, kind, box, clearance=height - rise if kind == "house" else 0.0, proud=_PROUD[kind])


def _facing(box: UprightBox, towards: tuple[float, float]) -> UprightBox:
    """The box turned by quarters so that its front, -y, faces the direction `towards`."""
    way = math.atan2(towards[1], towards[0]) + math.pi / 2 - box.yaw
    return box.turned(round(way / (math.pi / 2)) % 4)


def _front(coarse: CoarseObject, box: UprightBox, surroundings: Surroundings) -> list[Primitive]:
    """A wall with recessed windows towards the ego vehicle, all of it within the box."""
    box = box.lengthwise()
    if math.sin(box.yaw) * box.x - math.cos(box.yaw) * box.y > 0.0:
        box = box.turned(2)
    length, depth, height = box.size
    builder = ObjectBuilder(PlacedObject(kind="block", id="", x=0.0, y=0.0, z=0.0, level=0.0, yaw=0.0, size=box.size))
    opening = _CLUSTERED_OPENING if surroundings.clustered else _OPENINGS[int(coarse.rng.integers(len(_OPENINGS)))]
    bays, storeys = (min(max(1, round(a / b)), _MOST_WINDOWS) for a, b in ((length, WINDOW_BAY), (height, STOREY)))
    wall, panes = front(bays, storeys, opening)
    deep = min(1.0, depth / (RECESS + _LEDGE))
    at = (0.0, _LEDGE * deep - depth / 2, 0.0)
    builder.add_mesh(wall, (length, deep, height), "building", "plaster", at=at)
    builder.add_mesh(panes, (length, deep, height), "building", "window", at=at)
    return stretched(coarse, builder.primitives, box, box.size)
