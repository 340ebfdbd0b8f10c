"""Kinds of object, and what each is made of."""

import numpy as np
import pytest

from lidardraft.drafting.solver.scene_spec import SURFACES
from lidardraft.objects.coarse_shapes import (
    CoarseShape,
    extents,
    in_segments,
    on_post,
    street_light_parts,
    tree_parts,
)
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.sentence_kind import COUNTS, SentenceKind, with_rider
from lidardraft.semantics import BY_NAME, GROUND

SLACK = 0.08  # m; half of a lamp is over its mast
MADE = [kind for kind in SENTENCE_KINDS.values() if kind.sizes is not None]


def upright_box(parts: list[CoarseShape]) -> np.ndarray:
    """The size of the smallest upright box around all parts of one object, which stands on the ground."""
    low = np.min([np.subtract(part.center, np.divide(part.size, 2)) for part in parts], axis=0)
    high = np.max([np.add(part.center, np.divide(part.size, 2)) for part in parts], axis=0)
    assert low[2] == pytest.approx(0)
    return high - low


@pytest.mark.parametrize("kind", MADE, ids=lambda kind: kind.name)
def test_objects_have_the_sizes_and_the_label_that_their_kind_states(kind: SentenceKind) -> None:
    assert kind.sizes is not None
    low, high = np.array(kind.sizes.smallest), np.array(kind.sizes.largest)
    objects = [kind.sample_parts(np.random.default_rng(seed), parked=True) for seed in range(300)]
    sizes = np.array(list(map(upright_box, objects)))
    assert (sizes > low - 1e-3).all()
    assert (sizes < high + SLACK).all()
    assert (sizes.min(axis=0) <= low + 0.25 * (high - low) + SLACK).all()
    assert (sizes.max(axis=0) >= high - 0.25 * (high - low) - 1e-3).all()
    assert kind.label in {part.label for part in objects[0]}


@pytest.mark.parametrize("kind", SENTENCE_KINDS.values(), ids=lambda kind: kind.name)
def test_records_fit_together(kind: SentenceKind) -> None:
    assert SENTENCE_KINDS[kind.name] is kind
    assert kind.label in BY_NAME
    assert kind.label not in GROUND
    assert set(kind.surfaces) <= set(SURFACES)
    assert kind.is_vehicle + kind.cycles + kind.walks <= 1
    assert "road" in kind.surfaces or not kind.on_road
    assert ("road" not in kind.surfaces) == (kind.name in ("house", "building", "garden"))
    for word in COUNTS:
        low, high = getattr(kind.counts, word)
        assert 1 <= low <= high


def test_traffic_is_a_mix_of_vehicles() -> None:
    mix = [kind for kind in SENTENCE_KINDS.values() if kind.traffic_share]
    assert all(kind.is_vehicle for kind in mix)
    assert sum(kind.traffic_share for kind in mix) == pytest.approx(1)
    assert [kind.name for kind in SENTENCE_KINDS.values() if kind.sizes is None] == ["vehicle"]


def test_plurals() -> None:
    plurals = [SENTENCE_KINDS[kind].plural for kind in ("bus", "bush", "bench", "person", "hedge", "traffic-light")]
    assert plurals == ["buses", "bushes", "benches", "people", "hedges", "traffic lights"]


def test_segments_lie_end_to_end() -> None:
    segments = in_segments(CoarseShape("box", (0.0, 0.0, 1.0), (11.0, 0.3, 2.0), "wall"))
    assert [segment.name for segment in segments] == ["1", "2", "3"]
    ends = [(s.center[0] - s.size[0] / 2, s.center[0] + s.size[0] / 2) for s in segments]
    np.testing.assert_allclose(np.ravel(ends), [-5.5, -11 / 6, -11 / 6, 11 / 6, 11 / 6, 5.5])


def test_a_rider_sits_on_what_is_ridden() -> None:
    bicycle = CoarseShape("box", (0.0, 0.0, 0.55), (1.8, 0.6, 1.1), "bicycle")
    machine, rider = with_rider(bicycle, np.random.default_rng(0))
    assert (machine.name, rider.name, rider.label) == ("bicycle", "rider", "rider")
    assert rider.center[2] - rider.size[2] / 2 == pytest.approx(0.66)
    assert 1.6 <= extents([rider])[2] <= 1.85


@pytest.mark.parametrize(
    ("parts", "top"),
    [
        (tree_parts(8.0, 4.0, 0.3, 2.0), 8.0),
        (street_light_parts(7.0), 7.075),
        (on_post("traffic-light", (0.35, 0.35, 3.4), 2.5), 3.4),
        (on_post("traffic-sign", (0.1, 0.7, 2.3), 1.6), 2.3),
    ],
)
def test_objects_on_posts_are_as_high_as_asked_and_hang_together(parts: list[CoarseShape], top: float) -> None:
    post, head = parts
    assert upright_box(parts)[2] == pytest.approx(top)
    assert head.center[2] - head.size[2] / 2 <= post.size[2] + 1e-9
