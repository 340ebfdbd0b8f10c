import math
import os
from pathlib import Path

import numpy as np
import pytest

import report_image
from lidardraft import Box, Layout, Primitive
from rendered_pictures import render

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


def test_hidden_and_cut_vehicles_are_told_from_whole_ones():
    cars = (car("a", 12, 0, instance=1), car("b", 24, 0.8, instance=2), car("c", 25, -7, instance=3))
    layout = Layout((*cars, car("d", 3, 3, instance=4)))
    picture = render(layout)
    assert [box.id for box in report_image.visible(picture, layout)] == ["a", "c"]
    assert [box.id for box in report_image.visible(picture, layout, hidden=True)] == ["b"]


def test_vehicles_of_rendered_pictures_are_recovered():
    """What the report says, on six scenes: nine of ten vehicles that stand free within 0.5 m and 5 degrees."""
    rows = [row for scene in report_image.rendered(6) for row in scene]
    good = [row.centre < report_image.CLOSE and row.yaw < report_image.STRAIGHT for row in rows]
    assert len(good) >= 12
    assert np.mean(good) >= 0.9


@pytest.mark.skipif(DATA is None, reason="needs LIDARDRAFT_DATA")
def test_cars_of_kitti_are_recovered_from_the_depth_of_the_lidar():
    rows = [row for frame in report_image.kitti(Path(DATA)) for row in frame]
    if not rows:
        pytest.skip("no labelled pictures of KITTI in LIDARDRAFT_DATA")
    found = [row.centre for row in rows if math.isfinite(row.centre)]
    assert len(found) >= 0.8 * len(rows)
    assert np.median(found) < 0.5


def test_the_table_has_a_row_for_each_set(capsys, monkeypatch):
    monkeypatch.delenv("LIDARDRAFT_DATA", raising=False)
    monkeypatch.setattr("sys.argv", ["report_image.py", "--scenes", "1"])
    report_image.main()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert len({line.count("|") for line in lines}) == 1
