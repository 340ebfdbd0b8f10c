"""The coarse layouts of a street: what a sentence, a clustering, a picture or annotators would have made of it.

All shapes are solid, also for what is porous in the detailed scene: no input makes a medium.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.as_boxes import BoxStyle, as_boxes
from lidardraft.streets.coarse.as_clusters import ClusterStyle, as_clusters
from lidardraft.streets.coarse.as_picture import PictureStyle, as_picture
from lidardraft.streets.coarse.as_text import TextStyle, as_text
from lidardraft.streets.coarse.coarse_street import CoarseStreet
from lidardraft.streets.coarse.families import FAMILIES
from lidardraft.streets.coarse.visible import VisibleObjects

Style: TypeAlias = TextStyle | ClusterStyle | PictureStyle | BoxStyle

# All numbers below are estimates of ours of what people bring.
_STYLES = (TextStyle, ClusterStyle, PictureStyle, BoxStyle)
_SHARES = (0.3, 0.35, 0.2, 0.15)  # how often each is sampled
_HAS_SIDEWALKS, _HAS_POLES, _IS_NUMBERED, _IS_FLAT = 0.85, 0.85, 0.5, 0.5  # how often
_MOST_OMITTED = 0.3  # of small objects, in one of three pictures
_NAMED_WITHIN = (45.0, 80.0)  # m
# Cameras see 60 to 120 degrees; monocular depth is wrong by some percent. What is shown must still be worth obeying.
_PICTURED_WITHIN, _VIEW_DEGREES = (30.0, 70.0), (60.0, 120.0)  # m, degrees
_MOST_ERROR, _MOST_TURN = 0.03, 0.05  # share, rad


def coarse_layout(
    street: CoarseStreet, style: Style, rng: np.random.Generator, pose: np.ndarray, visible: VisibleObjects
) -> ShapeTable:
    """The street in that style, in the frame of the ego vehicle at street_from_ego `pose` [4, 4].

    That frame is fixed to the road under the ego vehicle. `visible` is what a scan from there saw.
    """
    match style:
        case TextStyle():
            return as_text(street, style, pose)
        case ClusterStyle():
            return as_clusters(street, style, rng, pose, visible)
        case PictureStyle():
            return as_picture(street, style, rng, pose, visible)
        case BoxStyle():
            return as_boxes(street, style, pose)


def sample_style(rng: np.random.Generator) -> Style:
    """A style as people's inputs would have, at random."""
    style = _STYLES[int(rng.choice(len(_STYLES), p=_SHARES))]
    sidewalks, poles = bool(rng.random() < _HAS_SIDEWALKS), bool(rng.random() < _HAS_POLES)
    omit, lobes = float(rng.choice((0.0, 0.0, rng.uniform(0.0, _MOST_OMITTED)))), int(rng.integers(1, MOST_LOBES + 1))
    if style is TextStyle:
        named = tuple(family for family, (share, _) in FAMILIES.items() if rng.random() < share)
        return TextStyle(named=named, sidewalks=sidewalks, poles=poles, reach=float(rng.uniform(*_NAMED_WITHIN)))
    if style is ClusterStyle:
        return ClusterStyle(numbered=bool(rng.random() < _IS_NUMBERED))
    relief = bool(rng.random() >= _IS_FLAT)
    if style is BoxStyle:
        return BoxStyle(relief=relief)
    return PictureStyle(
        relief=relief,
        sidewalks=sidewalks,
        poles=poles,
        omit=omit,
        lobes=lobes,
        error=float(rng.uniform(0.0, _MOST_ERROR)),
        turn=float(rng.uniform(0.0, _MOST_TURN)),
        reach=float(rng.uniform(*_PICTURED_WITHIN)),
        view=float(np.deg2rad(rng.uniform(*_VIEW_DEGREES))),
    )
