"""Styles at random, and the layout in each."""

import numpy as np
import pytest
from scanned import EGO, STREET, VISIBLE, made

from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.streets.coarse.as_boxes import BoxStyle
from lidardraft.streets.coarse.as_clusters import ClusterStyle
from lidardraft.streets.coarse.as_picture import PictureStyle
from lidardraft.streets.coarse.as_text import TextStyle
from lidardraft.streets.coarse.coarse_layout import Style, coarse_layout, sample_style
from lidardraft.streets.coarse.families import FAMILIES

STYLES = [sample_style(np.random.default_rng(seed)) for seed in range(200)]


def test_styles_are_of_every_kind():
    assert {type(style) for style in STYLES} == {TextStyle, ClusterStyle, PictureStyle, BoxStyle}
    for kind, fields in (
        (TextStyle, ("sidewalks", "poles", "named")),
        (ClusterStyle, ("numbered",)),
        (PictureStyle, ("relief", "sidewalks", "poles", "omit")),
        (BoxStyle, ("relief",)),
    ):
        for name in fields:
            assert len({getattr(style, name) for style in STYLES if isinstance(style, kind)}) > 1, name
    assert {style.lobes for style in STYLES if isinstance(style, PictureStyle)} == set(range(1, MOST_LOBES + 1))
    assert {family for style in STYLES if isinstance(style, TextStyle) for family in style.named} == set(FAMILIES)


def test_a_style_is_a_function_of_the_seed():
    assert sample_style(np.random.default_rng(3)) == sample_style(np.random.default_rng(3))


@pytest.mark.parametrize("style", [TextStyle(), ClusterStyle(), PictureStyle(error=0.02), BoxStyle()])
def test_a_layout_is_a_function_of_style_and_seed(style: Style):
    one, two = made(style, 1), made(style, 1)
    assert (one.centers == two.centers).all()
    assert one.ids == two.ids
    assert len(one.ids) > len(STREET.coarse.ground(EGO.pose, relief=isinstance(style, ClusterStyle)).ids)


def test_only_clusters_and_pictures_depend_on_the_seed():
    for style, depends in (
        (TextStyle(), False),
        (ClusterStyle(), True),
        (PictureStyle(error=0.02), True),
        (BoxStyle(), False),
    ):
        tables = [
            coarse_layout(STREET.coarse, style, np.random.default_rng(seed), EGO.pose, VISIBLE) for seed in (1, 2)
        ]
        same = tables[0].ids == tables[1].ids and (tables[0].centers == tables[1].centers).all()
        assert same != depends, style
