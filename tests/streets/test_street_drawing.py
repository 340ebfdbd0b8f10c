"""Drawings of a street in the styles of its inputs."""

import numpy as np
import pytest

from lidardraft.streets.drawing import Style, draw, draw_style, outline
from lidardraft.streets.street import make_street

STREET = make_street(2)
ROAD, THINGS = STREET.site.road, STREET.site.things


def ids(style: Style, seen: set[str] | None = None) -> set[str]:
    layout = draw(ROAD, THINGS, style, np.random.default_rng(0), seen)
    return {primitive.id.partition(".")[0] for primitive in layout.primitives}


def test_a_clean_drawing_has_every_thing_at_its_place():
    layout = draw(ROAD, THINGS, Style(), np.random.default_rng(0))
    by_id = {primitive.id: primitive for primitive in layout.primitives}
    for thing in THINGS:
        assert by_id[thing.id].center[:2] == pytest.approx((thing.x, thing.y), abs=0.1)
        if thing.instance and thing.kind not in ("cyclist", "motorcyclist"):
            assert by_id[thing.id].size == thing.size


def test_what_a_style_leaves_out():
    everything = ids(Style())
    assert not any(name.startswith("sidewalk") for name in ids(Style(sidewalks=False)))
    assert everything - ids(Style(posts=False)) >= {t.id for t in THINGS if t.kind in ("lamp", "sign", "pole")}
    small = {t.id for t in THINGS if t.kind in ("lamp", "sign", "pole", "bin", "bush", "bench", "bicycle")}
    assert small
    assert everything - ids(Style(omit=1.0)) >= small


def test_a_clustering_draws_what_was_seen():
    seen = {THINGS[0].id, THINGS[5].id}
    drawn = ids(Style(source="cloud"), seen)
    assert drawn & {thing.id for thing in THINGS} == seen
    # a sentence does not look
    assert ids(Style(), seen) >= {thing.id for thing in THINGS}


def test_a_clustering_misjudges_a_little():
    style = Style(source="cloud", error=0.03, turn=0.03)
    layout = draw(ROAD, THINGS, style, np.random.default_rng(1))
    by_id = {primitive.id: primitive for primitive in layout.primitives}
    cars = [thing for thing in THINGS if by_id[thing.id].label == "car"]
    off = np.array([np.hypot(by_id[t.id].center[0] - t.x, by_id[t.id].center[1] - t.y) for t in cars])
    wrong = np.array([by_id[t.id].size for t in cars]) - [t.size for t in cars]
    assert 0.01 < off.mean() < 0.2
    assert 0.01 < np.abs(wrong).mean() < 0.2


def test_styles_are_of_both_kinds():
    styles = [draw_style(np.random.default_rng(seed)) for seed in range(40)]
    assert {style.source for style in styles} == {"text", "cloud"}
    assert all(style.error == 0.0 for style in styles if style.source == "text")
    assert {style.sidewalks for style in styles} == {style.posts for style in styles} == {True, False}


def test_a_rider_sits_on_what_is_ridden():
    things = [t for seed in range(12) for t in make_street(seed).site.things if t.kind == "cyclist"]
    rider, bicycle = outline(things[0])
    assert (rider.label, bicycle.label) == ("rider", "bicycle")
    assert bicycle.instance == rider.instance + 1
    assert rider.center[2] > bicycle.center[2]
