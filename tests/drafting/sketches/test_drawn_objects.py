import math

import numpy as np
import pytest

from lidardraft.drafting.sketches.drawn_objects import NotDrawnError, Placed, objects_of_blob, objects_of_stroke
from lidardraft.drafting.sketches.drawn_shapes import Blob, Stroke
from lidardraft.drafting.solver.object_shapes import extents


def of_blob(label: str, length: float, width: float, yaw: float = 0.0, *names: str) -> list[Placed]:
    shape = Blob(label, names, "", np.array([10.0, 5.0]), length, width, yaw)
    return list(objects_of_blob(shape, yaw, np.random.default_rng(0)))


def of_stroke(label: str, line: object, width: float, *names: str) -> list[Placed]:
    shape = Stroke(label, names, "", np.array(line, dtype=np.float64), width)
    return list(objects_of_stroke(shape, np.random.default_rng(0)))


def test_a_house_and_a_car_are_as_large_as_they_were_drawn() -> None:
    for label, length, width in (("building", 14.0, 9.0), ("car", 4.4, 1.9), ("bus", 12.0, 2.5)):
        ((_, parts, place),) = of_blob(label, length, width, 0.4)
        assert extents([part for part, _ in parts])[:2] == pytest.approx((length, width))
        assert {yaw for _, yaw in parts} == {0.4}
        assert place.tolist() == [10.0, 5.0]


def test_a_dot_is_an_object_of_the_usual_size() -> None:
    ((_, parts, _),) = of_blob("car", 1.0, 1.0)
    assert 3.5 < extents([part for part, _ in parts])[0] < 5.0
    ((_, parts, _),) = of_blob("pole", 0.9, 0.9)
    assert extents([part for part, _ in parts])[0] < 0.3


def test_a_long_stroke_of_cars_is_a_row_of_them() -> None:
    row = of_blob("car", 26.0, 1.8, math.pi / 2, "cars")
    assert len(row) == 5
    places = np.array([place for _, _, place in row])
    np.testing.assert_allclose(places[:, 0], 10.0)
    np.testing.assert_allclose(np.diff(places[:, 1]), 5.2)
    assert max(extents([part for part, _ in parts])[0] for _, parts, _ in row) < 4.3


def test_what_no_vehicle_is_as_large_as_is_told() -> None:
    with pytest.raises(NotDrawnError, match=r"30.0 x 20.0 m is no car"):
        of_blob("car", 30.0, 20.0)


def test_a_tree_is_as_wide_as_its_disc_and_a_wood_is_many_trees() -> None:
    side = 4.0 * math.sqrt(3) / 2  # of the square with the moments of a disc 4 m across
    ((_, parts, _),) = of_blob("vegetation", side, side)
    assert extents([part for part, _ in parts])[:2] == pytest.approx((4.0, 4.0))
    wood = of_blob("vegetation", 36.0, 24.0, 0.3)
    assert len(wood) == 24
    places = np.array([place for _, _, place in wood]) - (10.0, 5.0)
    along = places @ (math.cos(0.3), math.sin(0.3))
    assert np.abs(along).max() == pytest.approx(15.0)


def test_a_hedge_bends_with_its_stroke() -> None:
    ((kind, parts, place),) = of_stroke("vegetation", [(0, 0), (10, 0), (10, 8)], 1.0)
    assert kind == "hedge"
    assert [round(part.size[0]) for part, _ in parts] == [10, 8]
    for (part, yaw), middle in zip(parts, ((5, 0), (10, 4)), strict=True):
        cos, sin = math.cos(yaw), math.sin(yaw)
        x, y, z = part.center
        there = np.array([cos * x - sin * y, sin * x + cos * y])
        np.testing.assert_allclose(place + there, middle, atol=0.5)
        assert z == part.size[2] / 2
        assert part.size[1] == pytest.approx(1.0)


def test_a_straight_wall_is_one_box_as_thick_as_walls_are() -> None:
    ((kind, parts, place),) = of_stroke("wall", [(0, 0), (12, 0.1)], 2.0)
    ((part, _),) = parts
    assert (kind, part.name) == ("wall", "")
    assert part.size[1] == 0.4
    np.testing.assert_allclose(place, (6, 0.05), atol=1e-6)


def test_a_wide_stroke_of_plants_is_a_row_of_trees_unless_it_is_called_a_hedge() -> None:
    row = of_stroke("vegetation", [(0, 0), (40, 0)], 5.0)
    assert {kind for kind, _, _ in row} == {"tree"}
    assert len(row) == 7
    assert [kind for kind, _, _ in of_stroke("vegetation", [(0, 0), (40, 0)], 5.0, "hedge")] == ["hedge"]


def test_a_stroke_of_no_length_is_told() -> None:
    with pytest.raises(NotDrawnError, match="no length"):
        of_stroke("fence", [(3, 3), (3, 3)], 0.2)


def test_what_is_much_too_large_for_a_pole_or_a_person_is_told() -> None:
    with pytest.raises(NotDrawnError, match="is no pole"):
        of_blob("pole", 80.0, 7.0)
    assert len(of_blob("person", 2.0, 2.0)) == 1
