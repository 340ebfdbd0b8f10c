"""The drawing of a street: the coarse layout that a sentence or a clustering would have made of it."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road import Road
from lidardraft.streets.plants import trunk_diameter
from lidardraft.streets.thing import Parts, Thing

# The class of things that are drawn as one box.
_BOXES = {
    "truck": "truck",
    "bus": "bus",
    "tram": "train",
    "person": "person",
    "bicycle": "bicycle",
    "motorcycle": "motorcycle",
    "house": "building",
    "block": "building",
    "shed": "building",
    "hedge": "vegetation",
    "fence": "fence",
    "garden_wall": "wall",
    "bin": "other",
    "bench": "other",
}
_RIDDEN = {"cyclist": ("bicycle", 1.06), "motorcyclist": ("motorcycle", 1.1)}
_POSTS = ("lamp", "pole", "sign", "traffic_light")
_SMALL = (*_POSTS, "bin", "bench", "bush", "bicycle")


@dataclass(frozen=True, kw_only=True, slots=True)
class Style:
    """How a street is drawn.

    `source` is "text" (clean shapes on flat ground) or "cloud" (only what the scan saw, with standard deviations of
    `error` times its size, or 4 m, and `turn` [rad]). `omit` is the share of small things left out.
    """

    source: str = "text"
    error: float = 0.0
    turn: float = 0.0
    omit: float = 0.0
    sidewalks: bool = True
    posts: bool = True


def draw_style(rng: np.random.Generator) -> Style:
    """A style as the inputs of the product would have: half sentences, half clusterings."""
    sidewalks, posts = bool(rng.random() < 0.85), bool(rng.random() < 0.85)
    if rng.random() < 0.5:
        return Style(omit=float(rng.choice((0.0, 0.0, 0.3))), sidewalks=sidewalks, posts=posts)
    return Style(
        source="cloud",
        error=float(rng.uniform(0.005, 0.03)),
        turn=float(rng.uniform(0.0, 0.03)),
        omit=float(rng.uniform(0.0, 0.3)),
        sidewalks=sidewalks,
        posts=posts,
    )


def draw(
    road: Road, things: Iterable[Thing], style: Style, rng: np.random.Generator, seen: Collection[str] | None = None
) -> Layout:
    """The layout of a street in that style; with `seen`, a clustering draws only the things with these ids."""
    primitives = [p for p in road.surfaces() if style.sidewalks or p.label != "sidewalk"]
    for thing in things:
        if thing.kind in _POSTS and not style.posts:
            continue
        if thing.kind in _SMALL and rng.random() < style.omit:
            continue
        if style.source == "cloud":
            if seen is not None and thing.id not in seen:
                continue
            thing = _misjudged(thing, style, rng)
        else:
            thing = replace(thing, z=thing.level)
        primitives += outline(thing)
    return Layout(primitives=tuple(primitives), provenance={"source": style.source})


def _misjudged(thing: Thing, style: Style, rng: np.random.Generator) -> Thing:
    """The thing as a box fitted to points has it: a little off in size, place and yaw."""
    # what is seen of something large is as exact as of something small
    wrong = rng.normal(0.0, style.error, 3) * np.minimum(thing.size, 4.0)
    length, width, height = (np.array(thing.size) + wrong).tolist()
    off = rng.normal(0.0, style.error * min(thing.size[0], thing.size[1], 4.0), 2)
    # a long thing's yaw is seen better
    yaw = thing.yaw + float(rng.normal(0.0, style.turn)) * min(1.0, 2.0 / thing.size[0])
    return replace(thing, x=thing.x + float(off[0]), y=thing.y + float(off[1]), yaw=yaw, size=(length, width, height))


def outline(thing: Thing) -> list[Primitive]:
    """The one to three shapes that a drawing has for a thing, with the class and instance of its parts."""
    parts = Parts(thing)
    length, width, height = thing.size
    middle = (0.0, 0.0, height / 2)
    if thing.kind == "tree":
        girth, crown = trunk_diameter(thing), height - thing.stem
        bare = thing.stem + 0.1 * crown
        parts.add("cylinder", (0.0, 0.0, bare / 2), (girth, girth, bare), "trunk")
        parts.add("ellipsoid", (0.0, 0.0, thing.stem + crown / 2), (length, width, crown), "vegetation")
    elif thing.kind == "bush":
        parts.add("ellipsoid", middle, thing.size, "vegetation")
    elif thing.kind in _POSTS:
        _post(parts)
    elif thing.kind in _RIDDEN:
        label, top = _RIDDEN[thing.kind]
        lap = 0.75  # m, the knees and feet of a rider are drawn with what is ridden
        parts.add("box", (-0.02, 0.0, (lap + height) / 2), (0.75, width * 0.9, height - lap), "rider")
        parts.add("box", (0.0, 0.0, top / 2), (length, 0.5 * width, top), label, rank=1)
    elif thing.kind == "house":
        # a box to the middle of the roof
        top = (thing.stem + height) / 2
        parts.add("box", (0.0, 0.0, top / 2), (length, width, top), "building")
    else:
        parts.add("box", middle, thing.size, _BOXES.get(thing.kind, "car"))
    return parts.primitives


def _post(parts: Parts) -> None:
    thing = parts.thing
    length, width, height = thing.size
    girth = {"sign": 0.08, "traffic_light": 0.11}.get(thing.kind, length)
    top = thing.stem if thing.kind in ("sign", "traffic_light") else height
    parts.add("cylinder", (0.0, 0.0, top / 2), (girth, girth, top), "pole")
    if top < height:
        label = "traffic-sign" if thing.kind == "sign" else "traffic-light"
        parts.add("box", (0.0, 0.0, (top + height) / 2), (length, width, height - top), label)
