"""Reports of pictures and sketches, and the pictures of the docs."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import pictures
import report_image
import report_inputs
from lidardraft import Box, Layout, Primitive
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.semantics import BY_NAME
from lidardraft.view import save_png
from rendered_pictures import SKY, as_networks_give_it, render

CAMERA = Pinhole(fx=100, fy=100, cx=50, cy=30, width=101, height=61)
WALL = Primitive(shape="box", center=(11, 0, 5), size=(2, 40, 20), label="wall", id="wall")
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(100, 100, 0), label="road", id="road")


def test_depth_is_that_along_the_axis():
    picture = render(Layout((WALL,)), CAMERA, height=2.0)
    np.testing.assert_allclose(picture.depth, 10, atol=1e-4)
    assert (picture.labels == BY_NAME["wall"].id).all()


@pytest.mark.parametrize("pitch", [0.0, 0.2])
def test_the_horizon_is_where_the_camera_looks_level(pitch):
    picture = render(Layout((ROAD,)), CAMERA, height=2.0, pitch=pitch)
    rows = np.flatnonzero(picture.labels[:, 50] > 0)
    assert rows[0] == pytest.approx(30 - 100 * math.tan(pitch) + 100 * 2 / 50, abs=2)
    assert picture.pixels[0, 50].tolist() == list(SKY)
    down = pitch + math.atan((60 - 30) / 100)
    assert picture.depth[60, 50] == pytest.approx(2 / math.sin(down) * math.cos(down - pitch), rel=1e-5)


def test_errors_of_networks_are_of_the_size_that_is_said():
    picture = render(Layout((ROAD, WALL)))
    wrong = as_networks_give_it(picture, 0)
    ratio = wrong.depth / picture.depth
    assert np.mean(ratio) == pytest.approx(1.12, rel=0.02)
    assert np.std(ratio) == pytest.approx(0.03 * 1.12, rel=0.2)
    assert not np.array_equal(wrong.depth, as_networks_give_it(picture, 1).depth)


DATA = os.environ.get("LIDARDRAFT_DATA")


def car(id, x, y, yaw=0.0, instance=1):
    return Primitive(shape="box", center=(x, y, 0.75), size=(4, 2, 1.5), label="car", id=id, yaw=yaw, instance=instance)


def test_what_was_found_is_held_against_what_there_is():
    truth = [
        Box("car_1", "car", 1, (10, 0, 1), (4, 2, 1.5), 0.1),
        Box("car_2", "car", 2, (30, 0, 1), (4, 2, 1.5), 0.0),
        Box("bus_1", "bus", 3, (10, 0, 1), (12, 2, 3), 0.0),
    ]
    near, far = report_image.compare(truth[:2], Layout((car("a", 10.3, 0.4, yaw=0.1 + math.pi),)))
    assert (near.centre, near.yaw) == (pytest.approx(0.5), pytest.approx(0, abs=1e-6))
    assert math.isnan(far.centre)
    (other,) = report_image.compare(truth[2:], Layout((car("a", 10, 0),)))
    assert math.isnan(other.centre)


@pytest.mark.parametrize(("scenes", "least"), [(1, 2), pytest.param(4, 8, marks=pytest.mark.slow)])
def test_vehicles_of_rendered_pictures_are_recovered(scenes, least):
    """What the report says: nine of ten vehicles that stand free within 0.5 m and 5 degrees."""
    rows = [row for scene in report_image.rendered(scenes) for row in scene]
    good = [row.centre < report_image.CLOSE and row.yaw < report_image.STRAIGHT for row in rows]
    assert len(good) >= least
    assert np.mean(good) >= 0.9


@pytest.mark.skipif(DATA is None, reason="needs LIDARDRAFT_DATA")
def test_cars_of_kitti_are_recovered_from_the_depth_of_the_lidar():
    rows = [row for frame in report_image.kitti(Path(DATA)) for row in frame]
    if not rows:
        pytest.skip("no labelled pictures of KITTI in LIDARDRAFT_DATA")
    found = [row.centre for row in rows if math.isfinite(row.centre)]
    assert len(found) >= 0.8 * len(rows)
    assert np.median(found) < 0.5


DOCS = Path(__file__).parents[2] / "docs"


def test_the_pictures_of_the_docs_show_what_is_read_now(tmp_path: Path) -> None:
    """Where they are out of date, `python benches/pictures.py inputs` writes them anew."""
    for name, picture in pictures.inputs():
        save_png(tmp_path / f"{name}.png", picture)
        with Image.open(DOCS / "images" / f"{name}.png") as image:
            shown = np.asarray(image)
        assert shown.shape == picture.shape, tmp_path
        assert (np.abs(shown.astype(int) - picture) > 2).any(axis=2).mean() < 0.001, tmp_path
        page = "pictures" if name == "images" else name
        assert f"(../images/{name}.png)" in (DOCS / "how-to" / f"{page}.md").read_text()


def test_sketches_are_found_again(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(report_inputs, "SKETCHES", 2)
    report_inputs.report_sketches()
    assert "20 of 20 objects of 2 sketches found within 1 m, and 0 that nobody drew" in capsys.readouterr().out
