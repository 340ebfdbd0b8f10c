from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft import Layout, Primitive, Sensor, raycast, view
from lidardraft.errors import FormatError
from lidardraft.scene.range_image import RangeImage

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


def test_a_layout_is_rendered_over_the_scan_from_above() -> None:
    scan, pose = raycast(LAYOUT, SENSOR), SENSOR.pose()
    picture, bare = (
        view.render_top_view(scan, LAYOUT, pose, size=200),
        view.render_top_view(scan, Layout((ROAD,)), pose, size=200),
    )
    rows, columns = np.nonzero((picture != bare).any(axis=2))
    # 8 to 12 m ahead is 16 to 24 of 100 pixels up from the middle, 1 m to either side 2 pixels
    assert (rows.min(), rows.max()) == (76, 84)
    assert (columns.min(), columns.max()) == (98, 102)
    assert (picture[76, 98:103] == view.PALETTE[13]).all()


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


def test_a_top_view_reaches_as_far_as_it_is_asked_to() -> None:
    empty = RangeImage.empty(SENSOR)
    picture, bare = (
        view.render_top_view(empty, layout, SENSOR.pose(), size=200, reach=25.0) for layout in (LAYOUT, Layout(()))
    )
    rows, _ = np.nonzero((picture != bare).any(axis=2))
    # 8 to 12 m ahead is 32 to 48 of 100 pixels up from the middle
    assert (rows.min(), rows.max()) == (52, 68)


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


def test_pictures_stack_and_are_saved(tmp_path: Path) -> None:
    first, second = np.zeros((4, 10, 3), np.uint8), np.full((6, 8, 3), 255, np.uint8)
    assert view.stack([first, second]).shape == (16, 10, 3)
    assert view.stack([first, second], across=True).shape == (6, 24, 3)
    view.save_png(tmp_path / "a.png", view.caption(np.zeros((60, 200, 3), np.uint8), "scan"))
    assert np.asarray(Image.open(tmp_path / "a.png")).max() == 255


@pytest.mark.parametrize("name", ["layout.json", "image.npz"])
def test_files_are_rendered(tmp_path: Path, name: str) -> None:
    LAYOUT.save(tmp_path / "layout.json")
    raycast(LAYOUT, SENSOR).save(tmp_path / "image.npz")
    picture = view.render_file(tmp_path / name, SENSOR)
    assert picture.ndim == 3
    assert picture.std() > 5


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"there is no picture of \.txt; it must be \.bin, \.npz or \.json"):
        view.render_file(tmp_path / "a.txt", SENSOR)
