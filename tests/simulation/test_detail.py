"""Whole layouts in detail: what obeys, what stays, what an edit changes."""

import math

import numpy as np
import pytest
from random_layouts import random_layout

from lidardraft import Layout, Primitive, detail, layout_from_text
from lidardraft.errors import LayoutError
from lidardraft.scene.check import check
from lidardraft.scene.edit import move, remove
from lidardraft.scene.layout import object_of
from lidardraft.scene.mesh import primitive_mesh
from lidardraft.semantics import CLASSES, GROUND
from lidardraft.simulation.detail import RULES

MOST_PROUD = 0.36  # m: eaves; nothing stands out further
SENTENCES = (
    "a busy crossroads with pedestrians crossing, buildings along both sides and traffic lights",
    "a quiet residential street with houses, gardens, trees and parked cars on both sides, and a cyclist",
    "a motorway with three lanes, a truck, a bus, a tram behind and a motorcycle",
    "a road curving to the left with fences on the left, a wall on the right, street lights and traffic signs",
)


def parts_of(layout: Layout) -> dict[str, list[Primitive]]:
    parts: dict[str, list[Primitive]] = {}
    for primitive in layout:
        parts.setdefault(object_of(primitive), []).append(primitive)
    return parts


def owners(layout: Layout) -> dict[str, set[tuple[str, int]]]:
    return {name: {(p.label, p.instance) for p in parts} for name, parts in parts_of(layout).items()}


def proud(parts: list[Primitive], given: list[Primitive]) -> np.ndarray:
    """How far parts stand out of the box around what was given [m]: along, across, up and down."""
    yaw = max(given, key=lambda part: math.prod(part.size)).yaw
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    low, high = bounds(given, turn)
    inner_low, inner_high = bounds(parts, turn)
    over = np.maximum(low - inner_low, inner_high - high)
    return np.array([over[0], over[1], inner_high[2] - high[2], low[2] - inner_low[2]])


def bounds(parts: list[Primitive], turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    vertices = np.concatenate([primitive_mesh(part).vertices for part in parts]) @ turn
    return vertices.min(axis=0), vertices.max(axis=0)


@pytest.mark.parametrize("seed", range(12))
def test_any_layout_keeps_its_objects_in_their_boxes(seed: int) -> None:
    given = random_layout(seed, source="spec" if seed % 2 else "point cloud")
    made = detail(given, seed=seed)
    assert Layout.from_json(made.to_json()) == made
    assert owners(made) == owners(given)
    made_parts = parts_of(made)
    for name, parts in parts_of(given).items():
        if parts[0].label not in GROUND:
            along, across, up, down = proud(made_parts[name], parts)
            assert max(along, across) <= MOST_PROUD, name
            assert max(up, down) <= 1e-6, name


@pytest.mark.parametrize("sentence", SENTENCES)
def test_sentences_keep_their_objects_in_their_boxes(sentence: str) -> None:
    given = layout_from_text(sentence, seed=3)
    made = detail(given, seed=1)
    assert owners(made) == owners(given)
    made_parts = parts_of(made)
    for name, parts in parts_of(given).items():
        if parts[0].label not in GROUND:
            assert proud(made_parts[name], parts).max() <= MOST_PROUD, name
    assert len(made) > len(given) + 20
    assert not [finding for finding in check(made) if finding.check in ("overlap", "ego_clear")]


def test_the_same_seed_gives_the_same_layout_and_another_one_another() -> None:
    given = layout_from_text(SENTENCES[1], seed=1)
    assert detail(given, seed=5).to_json() == detail(given, seed=5).to_json()
    assert detail(given, seed=5) != detail(given, seed=6)


@pytest.mark.parametrize("source", ["spec", "point cloud"])
def test_an_edit_of_one_object_changes_no_other(source: str) -> None:
    given = random_layout(40, 40, source=source)
    before = parts_of(detail(given, seed=2))
    name = next(object_of(p) for p in given if p.label == "car")
    for edited in (move(given, name, (0.5, 0.2, 0.0)), remove(given, name)):
        after = parts_of(detail(edited, seed=2))
        assert before.keys() - {name} <= after.keys()
        assert all(after[other] == before[other] for other in before if other != name)


def test_the_ground_and_what_has_a_surface_of_its_own_stay() -> None:
    triangle = np.array([(5.0, 5.0, 0.0), (7.0, 5.0, 0.0), (6.0, 5.0, 2.0)])
    given = Layout(
        primitives=(
            Primitive(shape="plane", center=(0, 0, 0), size=(50, 50, 0), label="terrain", id="lawn"),
            Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="a", material="chrome"),
            Primitive(shape="box", center=(9, 9, 1), size=(4, 2, 1.5), label="vegetation", id="b", extinction=0.3),
            Primitive.from_mesh(triangle, np.array([[0, 1, 2]]), label="building", id="c"),
            Primitive(shape="cylinder", center=(3, 3, 1), size=(0.1, 0.1, 2), label="pole", id="d.post"),
            Primitive(shape="box", center=(3, 3, 2), size=(0.1, 1, 1), label="other", id="d.flag", material="cloth"),
        )
    )
    assert detail(given) == given


def test_detail_of_a_detailed_layout_is_the_layout() -> None:
    made = detail(layout_from_text(SENTENCES[0], seed=2), seed=2)
    assert detail(made, seed=7) == made


def test_every_class_of_an_object_has_a_rule() -> None:
    assert set(RULES) == {row.name for row in CLASSES} - {"none", *GROUND}


def test_ids_that_look_like_new_ones_are_no_trouble() -> None:
    given = Layout(
        primitives=(
            Primitive(shape="box", center=(9, 0, 1.5), size=(0.3, 9, 3), label="building", id="b.1"),
            Primitive(shape="box", center=(9, 9, 0.2), size=(0.3, 1, 0.4), label="building", id="b"),
            Primitive(shape="plane", center=(0, 0, 0), size=(9, 9, 0), label="terrain", id="b.2"),
        )
    )
    assert {"b", "b.1", "b.2"} <= {p.id for p in detail(given)}


@pytest.mark.parametrize("seed", [-1, 1.5, True, "1"])
def test_a_seed_is_an_integer(seed: object) -> None:
    with pytest.raises(LayoutError, match=r"seed is .*; it must be an integer >= 0"):
        detail(Layout(), seed=seed)  # type: ignore[arg-type]


@pytest.mark.parametrize("clutter", [-0.1, 1.1, float("nan"), True, "much"])
def test_clutter_is_a_share(clutter: object) -> None:
    with pytest.raises(LayoutError, match=r"clutter is .*; it must be a number from 0 to 1"):
        detail(Layout(), clutter=clutter)  # type: ignore[arg-type]
