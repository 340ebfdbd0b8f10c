import numpy as np
import pytest

from lidardraft.drafting.solver.scene_spec import SURFACES
from lidardraft.drafting.solver.sentence_kinds import COUNTS, SENTENCE_KINDS, SentenceKind
from lidardraft.semantics import BY_NAME, GROUND

SLACK = 0.08  # m; half of a lamp is over its mast
MADE = [kind for kind in SENTENCE_KINDS.values() if kind.sizes is not None]


def extents(kind: SentenceKind, seed: int) -> np.ndarray:
    """The size of the smallest upright box around all parts of one object."""
    parts = kind.sample_parts(np.random.default_rng(seed), parked=True)
    low = np.min([np.subtract(part.center, np.divide(part.size, 2)) for part in parts], axis=0)
    high = np.max([np.add(part.center, np.divide(part.size, 2)) for part in parts], axis=0)
    assert low[2] == pytest.approx(0)
    return high - low


@pytest.mark.parametrize("kind", MADE, ids=lambda kind: kind.name)
def test_objects_have_the_sizes_that_their_kind_states(kind: SentenceKind) -> None:
    assert kind.sizes is not None
    low, high = np.array(kind.sizes.smallest), np.array(kind.sizes.largest)
    sizes = np.array([extents(kind, seed) for seed in range(300)])
    assert (sizes > low - 1e-3).all()
    assert (sizes < high + SLACK).all()
    assert (sizes.min(axis=0) <= low + 0.25 * (high - low) + SLACK).all()
    assert (sizes.max(axis=0) >= high - 0.25 * (high - low) - 1e-3).all()


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


@pytest.mark.parametrize("kind", MADE, ids=lambda kind: kind.name)
def test_a_part_has_the_label_of_its_kind(kind: SentenceKind) -> None:
    assert kind.label in {part.label for part in kind.sample_parts(np.random.default_rng(0))}


def test_traffic_is_a_mix_of_vehicles() -> None:
    mix = [kind for kind in SENTENCE_KINDS.values() if kind.traffic_share]
    assert all(kind.is_vehicle for kind in mix)
    assert sum(kind.traffic_share for kind in mix) == pytest.approx(1)
    assert [kind.name for kind in SENTENCE_KINDS.values() if kind.sizes is None] == ["vehicle"]
