"""The shapes that stand in for those of the solver of sentences."""

import numpy as np
import pytest

from lidardraft.objects.kinds import KINDS, SENTENCE_KINDS, kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.road import Road
from lidardraft.streets.coarse.coarse_street import ShapeColumns
from lidardraft.streets.coarse.solver_shapes import solver_shapes

ROAD = Road()


def shapes_of(kind: str, size: tuple[float, float, float], *, across: float = 8.0, yaw: float = 0.0) -> ShapeColumns:
    placed = PlacedObject(kind=kind, id=kind, x=5.0, y=across, z=0.0, level=0.0, yaw=yaw, size=size, instance=0)
    return ShapeColumns.from_rows([placed], solver_shapes([placed], ROAD, [ROAD.lane(0)]))


def test_sizes_are_the_nearest_of_the_solver_but_no_further_than_a_quarter():
    smallest, largest = (
        np.array(size) for size in (SENTENCE_KINDS["bench"].sizes.smallest, SENTENCE_KINDS["bench"].sizes.largest)
    )
    middle = tuple(((smallest + largest) / 2).tolist())
    np.testing.assert_allclose(shapes_of("bench", middle).sizes[0], middle)
    a_little_larger = tuple((1.1 * largest).tolist())
    np.testing.assert_allclose(
        shapes_of("bench", a_little_larger).sizes[0], np.maximum(largest, np.array(a_little_larger) * 0.75)
    )
    far_too_large = (10.0, 5.0, 4.0)
    np.testing.assert_allclose(shapes_of("bench", far_too_large).sizes[0], 0.75 * np.array(far_too_large))


def test_a_long_block_is_several_buildings():
    longest = SENTENCE_KINDS["building"].sizes.largest[0]
    found = shapes_of("block", (3.5 * longest, 12.0, 12.0), across=20.0)
    assert len(found.sizes) == 3  # of three quarters of its length
    assert (found.sizes[:, 0] < longest).all()


def test_what_sentences_have_no_word_for_is_left_out():
    for kind in ("grass", "hydrant", "gantry"):
        assert kind_of(kind).word is None
        assert len(shapes_of(kind, (1.0, 1.0, 1.0)).sizes) == 0


def test_cars_are_near_the_middle_of_their_lane_and_along_it():
    found = shapes_of("saloon", (4.2, 1.8, 1.5), across=0.4, yaw=0.15)
    x, y, yaw = found.places[0]
    assert abs(y) < 0.4 - 1e-6  # the ego vehicle's lane is at y = 0
    assert x == 5.0
    assert 0.0 < yaw < 0.15


@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind.word])
def test_every_kind_has_the_parts_of_its_word(name: str):
    """A kind whose word has parts of its own, and that is forgotten here, would keep its other coarse shapes."""
    kind, (length, width, height) = KINDS[name], SENTENCE_KINDS[KINDS[name].word].sizes.largest
    size, low = (min(length, 20.0), width, height), 0.6 * height
    placed = PlacedObject(
        kind=name, id=name, x=5.0, y=20.0, z=0.0, level=0.0, yaw=0.0, size=size, clearance=low, instance=1
    )
    shapes = [shape for _, shape, _ in solver_shapes([placed], ROAD, [ROAD.lane(0)])]
    parts = SENTENCE_KINDS[kind.word].sample_parts(np.random.default_rng(0), parked=kind.instances < 2)
    assert {(shape.shape, shape.label) for shape in shapes} == {(part.shape, part.label) for part in parts}
