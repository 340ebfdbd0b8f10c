"""A street as a sentence would describe it."""

import math

import numpy as np
import pytest
from scanned import OBJECTS, ids, in_street, labels, made

from lidardraft.errors import LayoutError
from lidardraft.streets.coarse.as_text import TextStyle


def test_objects_are_the_nearest_that_the_solver_could_have_placed():
    table = in_street(made(TextStyle()))
    row = {id: number for number, id in enumerate(table.ids)}
    coarse = [placed for placed in OBJECTS if placed.id in row]
    assert len(coarse) > 0.9 * len(OBJECTS)
    for placed in coarse:
        off = np.hypot(*(table.centers[row[placed.id], :2] - (placed.x, placed.y)))
        assert off < 0.6, placed
        assert abs(math.sin(table.yaws[row[placed.id]] - placed.yaw)) < 0.1 or placed.kind in ("bin", "sign", "bench")
        assert (table.sizes[row[placed.id]] <= 1.25 * np.maximum(placed.size, 0.3)).all() or placed.kind == "person"
    assert (table.centers[:, 2] >= -0.05).all()


def test_what_a_sentence_does_not_name_is_left_out():
    everything = ids(made(TextStyle()))
    assert "sidewalk" in labels(made(TextStyle()))
    assert "sidewalk" not in labels(made(TextStyle(sidewalks=False)))
    assert everything - ids(made(TextStyle(poles=False))) >= {
        t.id for t in OBJECTS if t.kind in ("lamp", "sign", "pole")
    }
    assert "vegetation" not in labels(made(TextStyle(named=("buildings",))))
    assert "building" in labels(made(TextStyle(named=("buildings",))))
    assert "building" not in labels(made(TextStyle(named=())))
    assert "car" in labels(made(TextStyle(named=())))


def test_unknown_families_are_refused():
    with pytest.raises(LayoutError, match=r"named holds 'ghosts'; it must be of people, buildings"):
        TextStyle(named=("ghosts",))
    with pytest.raises(LayoutError, match=r"reach is 0\.5; it must be 1 to 1000"):
        TextStyle(reach=0.5)
