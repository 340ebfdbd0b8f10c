import html
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft import Layout, Primitive, Sensor, raycast, simulate, view
from lidardraft.drawing import Drawing, Eye
from lidardraft.errors import LayoutError
from page_fields import fields_of_page, page_data

CAR = Primitive(shape="box", center=(10, 0, 0.75), size=(4, 2, 1.5), label="car", id="car_1", instance=1)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(100, 8, 0), label="road", id="road")
LAYOUT = Layout((CAR, ROAD))
SENSOR = Sensor.preset("hdl32e")


def test_the_camera_sees_the_car_in_its_colour() -> None:
    picture = view.render_layout(LAYOUT)
    blue = picture[..., 2].astype(int) - picture[..., 0] > 40
    rows, columns = np.nonzero(blue)
    assert len(rows) > 500
    assert abs(columns.mean() - picture.shape[1] / 2) < 20  # straight ahead


def test_points_are_rendered_where_the_layout_is() -> None:
    scan = raycast(LAYOUT, SENSOR)
    rendered = view.render_scan(scan, SENSOR.pose(), by_label=True)
    car = (rendered == view.PALETTE[13]).all(axis=2)
    shape = view.render_layout(Layout((CAR,)))
    around = (shape != view.render_layout(Layout(()))).any(axis=2)
    assert car.sum() > 50
    assert (car & around).sum() > 0.8 * car.sum()


@pytest.mark.parametrize("seed", range(20))
def test_an_eye_shows_all_that_it_is_asked_to(seed: int) -> None:
    places = np.random.default_rng(seed).uniform((-14, -14, 0), (14, 14, 3), (6, 3))
    eye = Eye.showing(places, width=400, height=240)
    column, row, ahead = eye.seen(np.concatenate([places, np.zeros((1, 3))]))
    assert (ahead > 1).all()
    assert ((column > 0) & (column < 400) & (row > 0) & (row < 240)).all()
    # and is no further off than it has to be
    assert max(np.abs(column / 200 - 1).max(), np.abs(row / 120 - 1).max()) > 0.5


def test_an_eye_over_the_origin_measures_metres() -> None:
    eye = Eye.above(width=200, height=400, reach=50.0)  # 4 pixels a metre
    column, row, _ = eye.seen(np.array([[10.0, 0, 0], [0.0, 20.0, 0], [-30.0, -5.0, 0]]))
    np.testing.assert_allclose(np.stack([column, row]), [[100, 20, 120], [160, 200, 320]])
    bare, ring = (Drawing(eye, rings).picture().astype(int) for rings in ((), (10,)))
    rows, columns = np.nonzero((bare != ring).any(axis=2))
    assert (rows.min(), rows.max(), columns.min()) == (160, 240, 60)


@pytest.mark.parametrize("order", [1, -1])
def test_near_points_hide_far_ones(order: int) -> None:
    eye, near = view.BEHIND.pose[:3, 3], np.array([4.0, 0.0, 1.0])
    points = np.stack([near, eye + 1.5 * (near - eye)])  # in the same pixel
    colours = np.array([[255, 0, 0], [0, 255, 0]], dtype=np.uint8)
    picture = view.render_points(points[::order], colours[::order])
    assert (picture == (255, 0, 0)).all(axis=2).any()
    assert not (picture == (0, 255, 0)).all(axis=2).any()


def test_points_at_the_edge_do_not_come_back_on_the_other_side() -> None:
    eye = view.BEHIND
    rays = eye.rays()[1].reshape(eye.height, eye.width, 3)[:, -8:].reshape(-1, 3)  # of the columns on the right
    picture = view.render_points(eye.pose[:3, 3] + 5 * rays, np.full((len(rays), 3), 255, np.uint8), eye)
    _, columns = np.nonzero((picture == 255).all(axis=2))
    assert len(columns) > 100
    assert columns.min() >= eye.width - 8


def test_an_eye_shows_what_was_asked_for_and_not_what_stands_around_it() -> None:
    far = Primitive(shape="box", center=(-20, 15, 1), size=(4, 2, 2), label="car", id="around/car_1", instance=2)
    scan = raycast(Layout((CAR, far, ROAD)), SENSOR)
    points, boxes = view.points_on_road(scan), Layout((CAR, far)).boxes()
    alone, both = (view.render_returns(scan, points, boxes=some)[:560, :980] for some in (boxes[:1], boxes))
    assert (alone == both).all(axis=2).mean() > 0.99  # from the same place


def test_boxes_with_returns_are_drawn_around_them() -> None:
    scan = raycast(Layout((CAR, ROAD)), SENSOR)
    hidden = Primitive(shape="box", center=(18, 0, 0.75), size=(4, 2, 0.5), label="bus", id="bus_1", instance=2)
    points, boxes = view.points_on_road(scan), Layout((CAR, hidden)).boxes()
    with_boxes, with_hidden, bare = (view.render_returns(scan, points, boxes=some) for some in (boxes[:1], boxes, []))
    np.testing.assert_array_equal(with_boxes, with_hidden)  # nothing returned from the bus
    above = slice(986, None)  # the columns of the view from above: 560 rows are 100 m
    rows, columns = np.nonzero((with_boxes[:560, above] != bare[:560, above]).any(axis=2))
    assert rows.min() == pytest.approx(280 - 12.5 * 5.6, abs=1.5)  # the line to where it looks
    assert rows.max() == pytest.approx(280 - 8 * 5.6, abs=1.5)
    assert np.ptp(columns) == pytest.approx(2 * 5.6, abs=2)


def test_boxes_of_a_recording_are_drawn_though_it_does_not_say_whose_its_returns_are() -> None:
    image = raycast(LAYOUT, SENSOR)
    recorded = replace(image, instance=np.zeros_like(image.instance))
    points, boxes = view.points_on_road(image), LAYOUT.boxes()
    np.testing.assert_array_equal(
        view.render_returns(recorded, points, boxes=boxes), view.render_returns(image, points, boxes=boxes)
    )


def test_objects_have_the_colours_of_classes_and_the_rest_those_of_heights() -> None:
    scan = raycast(LAYOUT, SENSOR)
    z = view.points_on_road(scan)[:, 2]
    label = scan.label[scan.valid]
    by_height, by_label = (view.colour_returns(scan, z, by_label=flag) for flag in (False, True))
    assert (by_height[label == 13] == by_label[label == 13]).all()
    assert (by_label[label == 1] == view.PALETTE[1]).all()
    assert (by_height[label == 1] == view.colour_by_height(np.zeros(1))).all()


@pytest.mark.parametrize("name", ["vlp32c", "os1-32"])
def test_a_pole_is_upright_in_a_range_image_whose_beams_look_aside(name: str) -> None:
    pole = Primitive(shape="cylinder", center=(-6, 4, 0), size=(0.3, 0.3, 20), label="pole", id="pole")
    image = raycast(Layout((pole,)), Sensor.preset(name))
    _, columns = np.nonzero(image.label)
    assert np.ptp(columns) > 20  # in the image itself
    picture = view.render_image(image)
    strip = picture[len(picture) // 2 :]  # of labels
    _, columns = np.nonzero((strip == view.PALETTE[6]).all(axis=2))
    assert len(columns) > 100
    assert np.ptp(columns) <= 12  # 0.3 m at 7.2 m are 12 of 1,800 columns, 7 of 1,024


def test_a_layout_is_rendered_from_above() -> None:
    picture = view.render_from_above(LAYOUT, size=200, reach=25.0)
    car = picture[..., 2].astype(int) - picture[..., 0] > 60
    rows, columns = np.nonzero(car)
    # 8 to 12 m ahead is 32 to 48 of 100 pixels up from the middle, 1 m to either side 4 pixels
    assert (rows.min(), rows.max()) == (52, 67)
    assert (columns.min(), columns.max()) == (96, 103)
    assert (picture[100, 100] == 255).all()  # the ego vehicle
    left = Primitive(shape="box", center=(0, 10, 1), size=(4, 4, 2), label="car", id="left")
    _, columns = np.nonzero(view.render_from_above(Layout((left,)), size=200, reach=25.0)[..., 2] > 100)
    assert columns.min() == 52


def test_no_return_is_black_and_no_class_white() -> None:
    assert view.colour_by_depth(np.array([[0.0, 5.0]]))[0, 0].tolist() == [0, 0, 0]
    assert view.colour_by_depth(np.array([[0.0, 5.0]]))[0, 1].any()
    assert view.colour_by_label(np.array([0]))[0].tolist() == [255, 255, 255]


def test_a_picture_is_saved_as_it_is(tmp_path: Path) -> None:
    picture = np.random.default_rng(0).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    view.save_png(tmp_path / "a.png", picture)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "a.png").convert("RGB")), picture)


def test_a_page_of_html_holds_a_whole_scan() -> None:
    scan = simulate(Layout((ROAD, CAR)), Sensor.preset("vlp16"), speed=9.0)
    page = scan.html()
    assert not re.search(r"(src|href)=|https?:|import |fetch\(", page)  # no other file and no host
    held, image = fields_of_page(page), scan.image
    points = np.add(scan.points(), (0, 0, scan.pose[2, 3]))
    np.testing.assert_allclose(np.stack([held[axis] for axis in "xyz"], axis=1), points, atol=0.004)
    for name, values in {"label": scan.labels(), "instance": scan.instances(), "row": image.beams()}.items():
        np.testing.assert_array_equal(held[name], values)
    np.testing.assert_array_equal(held["column"], np.nonzero(image.valid)[1])
    np.testing.assert_allclose(held["range"], image.depth[image.valid], atol=0.006)  # and not that of the points
    np.testing.assert_allclose(held["time"], image.times(), atol=1e-6)
    np.testing.assert_allclose(held["intensity"], scan.intensities(), atol=0.002)
    (box,) = page_data(page)["boxes"]
    np.testing.assert_allclose(box["corners"], np.add(scan.boxes()[0].corners(), (0, 0, scan.pose[2, 3])), atol=1e-3)


def test_a_page_holds_titles_and_numbers_of_any_kind() -> None:
    points = np.array([[1.0, 2.0, 3.0], [-4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])
    hostile = view.html_page(points, {}, boxes=[], title="</script><script>alert(1)</script>")
    assert page_data(hostile)["title"] == "</script><script>alert(1)</script>"
    assert hostile.count("<script") == 2
    instance = np.array([2**32 - 1, 0, 2**31], np.uint32)
    (large,) = (fields_of_page(view.html_page(points, {"instance": instance}, boxes=[], title=""))["instance"],)
    np.testing.assert_array_equal(large.astype(np.int64) % 2**32, instance)
    stray = view.html_page(np.append(points, [[1e7, 0, 0]], axis=0), {"row": np.arange(4)}, boxes=[], title="")
    np.testing.assert_array_equal(fields_of_page(stray)["row"], [0, 1, 2])
    with pytest.raises(LayoutError, match="label must have a value for each of 3 points"):
        view.html_page(points, {"label": np.zeros(2, np.uint8)}, boxes=[], title="")


def test_a_notebook_shows_a_scan_that_fits_into_it() -> None:
    field = replace(ROAD, size=(200, 200, 0))
    scan = simulate(Layout((field, CAR)), Sensor.preset("os1-128"))
    shown = scan._repr_html_()
    assert shown.startswith('<iframe srcdoc="')
    data = page_data(html.unescape(shown.split('"')[1]))
    assert 10_000 < data["count"] <= 40_000 < len(scan.labels())
    assert len(shown) < 600_000
