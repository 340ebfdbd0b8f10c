"""The fields that shapes and boxes have alike."""

import math

import numpy as np
import pytest

from lidardraft.errors import LayoutError
from lidardraft.scene.layout_fields import FURTHEST, check_id, checked_vector, checked_yaw


def test_numbers_become_floats():
    assert checked_vector("a", "center", np.array([1, 2, 3])) == (1.0, 2.0, 3.0)
    assert [type(value) for value in checked_vector("a", "center", [1, 2, 3])] == [float] * 3
    assert checked_vector("layout", "coverage", (-1, 2 * FURTHEST), 2, math.inf) == (-1.0, 2 * FURTHEST)
    assert checked_yaw("a", 1) == 1.0


@pytest.mark.parametrize("values", [None, "abc", (1, 2), (1, 2, math.nan), (1, 2, True)])
def test_three_finite_numbers_or_none(values):
    with pytest.raises(LayoutError, match=r"a: center is .*; it must be 3 finite numbers"):
        checked_vector("a", "center", values)


def test_the_core_has_a_limit_of_coordinates():
    with pytest.raises(LayoutError, match=r"a: center is .*; no number may be larger than 1e\+09 m"):
        checked_vector("a", "center", (0, 0, -1.01 * FURTHEST))


@pytest.mark.parametrize("id", ["", None, 3, "\ud800", "car\x1b[2J", "car\n", "a\x9b31m", "a\u202eb", "a\u2028b"])
def test_a_name_has_printable_characters(id):
    with pytest.raises(LayoutError, match="it must be a non-empty string of printable characters"):
        check_id(id)
