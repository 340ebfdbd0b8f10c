"""The coarse layouts of a street: what a sentence, a clustering, a picture or annotators would have made of it.

All shapes are solid, also for what is porous in the detailed scene: no input makes a medium.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.as_boxes import BoxStyle, as_boxes
from lidardraft.streets.coarse.as_clusters import ClusterStyle, as_clusters
from lidardraft.streets.coarse.as_picture import PictureStyle, as_picture
from lidardraft.streets.coarse.as_text import TextStyle, as_text
from lidardraft.streets.coarse.coarse_street import CoarseStreet
from lidardraft.streets.coarse.families import FAMILIES
from lidardraft.streets.coarse.visible import VisibleObjects

Style: TypeAlias = TextStyle | ClusterStyle | PictureStyle | BoxStyle

# How often each is sampled: an estimate of ours of what people bring.
_STYLES = (TextStyle, ClusterStyle, PictureStyle, BoxStyle)
_SHARES = (0.3, 0.35, 0.2, 0.15)


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
    sidewalks, poles = bool(rng.random() < 0.85), bool(rng.random() < 0.85)
    omit, lobes = float(rng.choice((0.0, 0.0, rng.uniform(0.0, 0.3)))), int(rng.integers(1, 4))
    if style is TextStyle:
        named = tuple(family for family, (share, _) in FAMILIES.items() if rng.random() < share)
        return TextStyle(named=named, sidewalks=sidewalks, poles=poles, reach=float(rng.uniform(45.0, 80.0)))
    if style is ClusterStyle:
        return ClusterStyle(numbered=bool(rng.random() < 0.5))
    relief = bool(rng.random() >= 0.5)
    if style is BoxStyle:
        return BoxStyle(relief=relief)
    # Cameras see 60 to 120 degrees; monocular depth is wrong by some percent. Estimates of ours: what is shown must
    # still be worth obeying.
    return PictureStyle(
        relief=relief,
        sidewalks=sidewalks,
        poles=poles,
        omit=omit,
        lobes=lobes,
        error=float(rng.uniform(0.0, 0.03)),
        turn=float(rng.uniform(0.0, 0.05)),
        reach=float(rng.uniform(30.0, 70.0)),
        view=float(np.deg2rad(rng.uniform(60.0, 120.0))),
    )
