"""Styles: the ways in which the inputs of the product draw the same street."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LayoutError

SOURCES = ("text", "cloud", "picture", "boxes")
GROUNDS = ("flat", "patches")
# How often each is drawn: an estimate of ours of what people bring.
_SHARES = (0.3, 0.35, 0.2, 0.15)
# What a sentence speaks of, by its words, and how often it does: an estimate of ours. Vehicles are always there.
FAMILIES: dict[str, tuple[float, tuple[str, ...]]] = {
    "people": (0.85, ("person", "bicycle", "motorcycle")),
    "buildings": (0.9, ("house", "building")),
    "trees": (0.9, ("tree",)),
    "greenery": (0.6, ("bush", "hedge")),
    "enclosures": (0.6, ("fence", "wall")),
    "posts": (0.5, ("street-light", "pole", "traffic-sign", "traffic-light")),
    "furniture": (0.4, ("bin", "bench")),
}
ALWAYS_NAMED = ("car", "van", "truck", "bus", "tram")


@dataclass(frozen=True, kw_only=True, slots=True)
class Style:
    """How a street is drawn.

    `source` is what draws it:
    "text" as the solver of sentences would: its sizes, things in the middle of their lanes and along the road, flat
    ground, and of `FAMILIES` only those that are `named`, vehicles always;
    "cloud" as clustering the scan would: only what was seen, with unseen sides completed; `numbered` says whether the
    points came with the numbers of their things;
    "picture" as a camera or a hand would: what is visible within `reach` [m] and `view` [rad] around straight ahead;
    "boxes" as annotators would: tight boxes around everything, crowns and posts as simple shapes.

    `error` is the standard deviation of sizes in shares of them and of places in shares of the distance, `turn` that of
    yaw [rad], for pictures. `omit` is the share of small things left out, `lobes` the number of ellipsoids in a crown.
    Raises `LayoutError` on a value that is none of these.
    """

    source: str = "text"
    ground: str = "flat"
    sidewalks: bool = True
    posts: bool = True
    omit: float = 0.0
    lobes: int = 1
    named: tuple[str, ...] = tuple(FAMILIES)
    numbered: bool = True
    error: float = 0.0
    turn: float = 0.0
    reach: float = 200.0
    view: float = math.tau

    def __post_init__(self) -> None:
        for name, choices in (("source", SOURCES), ("ground", GROUNDS)):
            if getattr(self, name) not in choices:
                raise LayoutError(f"style: {name} is {getattr(self, name)!r}; it must be one of {', '.join(choices)}")
        for family in self.named:
            if family not in FAMILIES:
                raise LayoutError(f"style: named holds {family!r}; it must be of {', '.join(FAMILIES)}")
        for name, low, high in (
            ("omit", 0.0, 1.0),
            ("lobes", 1, 3),
            ("error", 0.0, 0.3),
            ("turn", 0.0, 1.0),
            ("reach", 1.0, 1000.0),
            ("view", 0.1, math.tau),
        ):
            if not low <= getattr(self, name) <= high:
                raise LayoutError(f"style: {name} is {getattr(self, name)}; it must be {low:g} to {high:g}")


def sample_style(rng: np.random.Generator) -> Style:
    """A style as the inputs of the product would have, drawn at random."""
    source = str(rng.choice(SOURCES, p=_SHARES))
    sidewalks, posts = bool(rng.random() < 0.85), bool(rng.random() < 0.85)
    omit, lobes = float(rng.choice((0.0, 0.0, rng.uniform(0.0, 0.3)))), int(rng.integers(1, 4))
    if source == "text":
        named = tuple(family for family, (share, _) in FAMILIES.items() if rng.random() < share)
        return Style(named=named, sidewalks=sidewalks, posts=posts, reach=float(rng.uniform(45.0, 80.0)))
    if source == "cloud":
        return Style(source=source, ground="patches", numbered=bool(rng.random() < 0.5))
    ground = "flat" if rng.random() < 0.5 else "patches"
    if source == "boxes":
        return Style(source=source, ground=ground, lobes=1)
    # Cameras see 60 to 120 degrees; monocular depth is wrong by some percent. Estimates of ours: what is drawn must
    # still be worth obeying.
    return Style(
        source=source,
        ground=ground,
        sidewalks=sidewalks,
        posts=posts,
        omit=omit,
        lobes=lobes,
        error=float(rng.uniform(0.0, 0.03)),
        turn=float(rng.uniform(0.0, 0.05)),
        reach=float(rng.uniform(30.0, 70.0)),
        view=float(np.deg2rad(rng.uniform(60.0, 120.0))),
    )
