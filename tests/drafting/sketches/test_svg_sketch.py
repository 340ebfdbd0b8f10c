import math

import numpy as np
import pytest

from lidardraft.drafting.sketches.drawn_shapes import Blob, Sketch, Stroke
from lidardraft.drafting.sketches.svg_sketch import read_svg
from lidardraft.errors import LayoutError

SCALE = '<line id="scale-10m" x1="0" y1="195" x2="20" y2="195"/>'  # half a metre a unit


def sketch(inner: str, metres: float | None = None) -> Sketch:
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200">'
    return read_svg(f"{head}{inner}{'' if metres else SCALE}</svg>", metres)


def only_blob(inner: str) -> Blob:
    (blob,) = sketch(inner).blobs
    return blob


def only_stroke(inner: str) -> Stroke:
    (stroke,) = sketch(inner).strokes
    return stroke


def test_a_named_rectangle_is_an_object_in_its_place() -> None:
    car = only_blob('<rect id="car-7" x="96" y="50" width="4" height="9" transform="rotate(-30 98 54.5)"/>')
    assert (car.label, car.names, car.where, car.points) == ("car", ("car-7",), "rect 'car-7'", False)
    np.testing.assert_allclose(car.center, (22.75, 1.0), atol=0.03)
    assert (car.length, car.width) == pytest.approx((4.5, 2.0), abs=0.03)
    assert math.remainder(car.yaw - math.radians(30), math.pi) == pytest.approx(0, abs=0.01)


def test_a_line_of_a_car_says_where_its_front_is() -> None:
    car = only_blob('<line class="car" x1="100" y1="60" x2="100" y2="69" stroke="blue" stroke-width="4"/>')
    assert car.points
    assert car.yaw == pytest.approx(math.pi)
    assert (car.length, car.width) == (4.5, 2.0)


def test_an_outline_around_a_car_is_its_area() -> None:
    car = only_blob('<path id="car" d="M100 60 h4 v9 h-4 v-8" fill="none" stroke="blue"/>')
    assert not car.points
    assert (car.length, car.width) == pytest.approx((4.5, 2.0), abs=0.05)


def test_strokes_are_lines_with_a_width() -> None:
    road = only_stroke('<path id="street" d="M100 200 V0" stroke-width="14" stroke="gray"/>')
    assert (road.label, road.width, road.closed) == ("road", 7.0, False)
    np.testing.assert_allclose(road.line, [(-50, 0), (50, 0)])
    fence = only_stroke('<path id="fence" d="M0 0 h50 v50 z" fill="none" stroke="gray"/>')
    assert fence.closed
    np.testing.assert_allclose(fence.line[0], fence.line[-1])


def test_a_filled_area_of_a_road_is_its_stroke_and_a_hole_stays_one() -> None:
    road = only_stroke('<rect id="road" x="93" y="0" width="14" height="200"/>')
    assert road.width == pytest.approx(7, abs=0.2)
    assert np.ptp(road.line[:, 0]) == pytest.approx(100, abs=1.2)
    d = "M100 40 a60 60 0 1 0 .01 0 z M100 56 a44 44 0 1 0 .01 0 z"
    ring = only_stroke(f'<path id="roundabout" d="{d}"/>')
    assert ring.closed
    assert ring.width == pytest.approx(8, abs=0.3)


def test_names_of_groups_and_colours_say_the_class_where_the_shape_does_not() -> None:
    inner = (
        '<g id="trees"><circle id="c1" cx="50" cy="50" r="4" fill="rgb(0,0,142)"/></g>'
        '<circle cx="80" cy="50" r="4" fill="#00008e"/><circle id="odd" cx="90" cy="50" r="4" fill="orange"/>'
    )
    found = sketch(inner)
    assert [blob.label for blob in found.blobs] == ["vegetation", "car"]
    assert found.ignored == ["circle 'odd': neither a name nor a colour says its class"]


def test_the_ego_vehicle_and_the_scale() -> None:
    found = sketch('<g id="ego"><circle cx="100" cy="150" r="3"/></g><circle class="tree" cx="100" cy="130" r="4"/>')
    assert found.ego_marked
    assert found.metres_per_unit == 0.5
    np.testing.assert_allclose(found.blobs[0].center, (10, 0), atol=0.03)
    found = sketch('<circle class="tree" cx="100" cy="80" r="4"/>' + SCALE, metres=0.2)
    assert (found.metres_per_unit, found.ego_marked) == (0.2, False)
    np.testing.assert_allclose(found.blobs[0].center, (4, 0), atol=0.02)
    assert found.ignored == ["the scale bar: the scale is given in metres per pixel"]


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        ('<rect id="car" width="3" height="3"/>', 'name a line of it "scale 10 m"'),
        ('<circle id="scale 0 m" r="4"/>', "a scale of 0.0 m"),
        ('<line id="scale 5 m"/>', "that is 0.0 units long"),
        ('<line id="scale 10 m" x2="0.01"/><rect id="car" width="30" height="30"/>', "reaches further than 2000 m"),
    ],
)
def test_scales_that_cannot_be(inner: str, said: str) -> None:
    with pytest.raises(LayoutError, match=said):
        read_svg(f'<svg width="200" height="200">{inner}</svg>', None)


@pytest.mark.parametrize("name", ["scale 10 m", "scale_10_m", "Scale: 10 metres", "scale-10m"])
def test_ways_to_name_a_scale(name: str) -> None:
    assert read_svg(f'<svg width="9" height="9"><line id="{name}" x2="20"/></svg>', None).metres_per_unit == 0.5


def test_markings_of_a_road_are_told_and_are_no_road() -> None:
    found = sketch('<g id="roads"><g id="lane markings"><line id="l1" x2="90" stroke="white"/></g></g>')
    assert not found.strokes
    assert found.ignored == ["line 'l1': markings are not read"]
