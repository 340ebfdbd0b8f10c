"""Poles and what is on them: lamps, traffic signs and traffic lights."""

from __future__ import annotations

import math
from functools import partial

from lidardraft.objects import signs
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.fitting import fitted, part_of, solid
from lidardraft.simulation.surroundings import LANE_SIDE, Surroundings

_PROUD = (0.3, 0.05, 0.0)  # m: shades of signals, plates before their posts
# Lamps [m], as of `objects/poles.py`: a luminaire at the end of an arm, and how thick the arm is.
_LUMINAIRE, _ARM = (0.6, 0.25, 0.14), 0.08
_LONG = 1.5  # times as long as wide: what is not has no thin side


def pole(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """Masts, lamps on arms, signs and signals, each part where it was given."""
    plates, lights = coarse.labelled("traffic-sign"), coarse.labelled("traffic-light")
    posts = [part for part in coarse.labelled("pole") if part.shape == "cylinder"]
    if len(posts) == 1 and len(plates) + len(lights) == 1 and len(coarse.parts) == 2:
        return _on_post(coarse, posts[0], (plates + lights)[0], surroundings)
    made: list[Primitive] = []
    for part in coarse.parts:
        if part.label == "traffic-sign":
            made += _plate(coarse, part, surroundings)
        elif part.label == "traffic-light" or part.shape not in ("cylinder", "box"):
            made.append(solid(part))
        elif part.shape == "cylinder":
            made += fitted(coarse, "pole", UprightBox.around([part]))
        elif posts:
            made += _lamp(coarse, posts[0], part)
        else:
            made.append(solid(part))
    return made


def _on_post(coarse: CoarseObject, post: Primitive, head: Primitive, surroundings: Surroundings) -> list[Primitive]:
    """A sign or a signal on its post, from the foot of one to the top of the other."""
    foot = min(post.center[2] - post.size[2] / 2, head.center[2] - head.size[2] / 2)
    top = max(post.center[2] + post.size[2] / 2, head.center[2] + head.size[2] / 2)
    box = _facing(UprightBox.around([head]), surroundings)
    x, y, _ = post.center
    whole = box._replace(x=x, y=y, bottom=foot, size=(*box.size[:2], top - foot))
    kind = "sign" if head.label == "traffic-sign" else "traffic_light"
    return fitted(coarse, kind, whole, clearance=max(box.bottom - foot, 0.0), proud=_PROUD)


def _plate(coarse: CoarseObject, part: Primitive, surroundings: Surroundings) -> list[Primitive]:
    """A plate without a post; of a clustering, whose box holds what was seen, one that fills it."""
    box = _facing(UprightBox.around([part]), surroundings)
    if part.shape != "box" or box.size[1] < _LONG * box.size[0]:
        return [solid(part)]
    build = partial(signs.sign, square=surroundings.clustered)
    return fitted(coarse, "sign", box, labels=("traffic-sign",), build=build)


def _facing(box: UprightBox, surroundings: Surroundings) -> UprightBox:
    """The box with its thin side ahead; where it knows no front from back, towards who drives on that side."""
    if box.size[0] > _LONG * box.size[1]:
        box = box.turned(1)
    if not surroundings.clustered:
        return box
    # right-hand traffic: signs on the right face the ego vehicle, those on the left who comes towards it
    ahead = math.cos(box.yaw)
    if abs(ahead) > math.sqrt(0.5):
        towards_ego = ahead < 0.0
        return box if towards_ego == (box.y < LANE_SIDE) else box.turned(2)
    return box if math.sin(box.yaw) * box.y < 0.0 else box.turned(2)


def _lamp(coarse: CoarseObject, post: Primitive, part: Primitive) -> list[Primitive]:
    """An arm from the mast to the far end of the lamp's box, and the luminaire there."""
    box = UprightBox.around([part])
    if box.size[1] > box.size[0]:
        box = box.turned(1)
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    along = (box.x - post.center[0]) * cos + (box.y - post.center[1]) * sin
    if along < 0.0:
        box, along = box.turned(2), -along
    length, width, height = box.size
    long, wide, tall = min(_LUMINAIRE[0], length), min(_LUMINAIRE[1], width), min(_LUMINAIRE[2], height)
    start = min(-along, length / 2 - long)
    arm = (length / 2 - start, min(_ARM, width), min(_ARM, height))
    return [
        part_of(coarse, "box", box, ((length / 2 + start) / 2, 0.0, height / 2), arm, "pole", "metal"),
        part_of(coarse, "box", box, (length / 2 - long / 2, 0.0, height / 2), (long, wide, tall), "pole", "plastic"),
    ]
