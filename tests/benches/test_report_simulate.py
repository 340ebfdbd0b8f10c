"""The report of what layouts become, on little."""

import os
from pathlib import Path

import numpy as np
import pytest

import recordings
from cases import Case, CaseSet, street_set
from lidardraft import RangeImage, layout_from_text, simulate
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS, Sensor
from report_simulate import EQUAL, losses, markdown, report, table_of

SENSOR = PRESETS["hdl64e"]
needs_recordings = pytest.mark.skipif("LIDARDRAFT_DATA" not in os.environ, reason="LIDARDRAFT_DATA is not set")


def test_a_scan_held_against_itself_agrees_in_all_rows() -> None:
    layout = layout_from_text("two cars ahead, trees on the left and a building on the right", seed=3)
    recorded = Sweep.by_azimuth(simulate(layout, SENSOR, seed=0).image)
    cases = CaseSet(
        [Case(recorded, layout, SENSOR, SENSOR.pose())], Sweep.by_azimuth, np.ones(SENSOR.shape, bool), True
    )
    table = report(cases)
    for row, cells in table.items():
        assert cells["simulated"] == (pytest.approx(0.0, abs=1e-6) if "JSD" in row or "MMD" in row else 1.0) or (
            row.startswith("dropped")
        ), row
    assert {"near, on car", "IoU of vegetation", "intensity of building (JSD)", "drop recall"} <= set(table)
    assert table["dropped"]["simulated"] == table["dropped in recording"]["cast"] > 0.0
    assert table["IoU of car"]["+ sensor model"] < 0.8
    assert max(losses(table).values()) < EQUAL
    assert ", 0 worse." in markdown(table)


def test_pixels_that_the_vehicle_hides_do_not_count() -> None:
    layout = layout_from_text("a bus 12 m ahead and a building on the left", seed=1)
    recorded = Sweep.by_azimuth(simulate(layout, SENSOR, seed=5).image)
    shown = np.zeros(SENSOR.shape, dtype=bool)
    shown[:, 460:560] = True
    table = report(CaseSet([Case(recorded, layout, SENSOR, SENSOR.pose())], Sweep.by_azimuth, shown, True))
    assert "near, on truck" in table
    assert table["near, on truck"]["cast"] > 0.5
    assert "near, on building" not in table


def test_scans_of_a_case_have_one_road() -> None:
    points = np.zeros((2, 400, 3), dtype=np.float32)
    points[..., 0] = 6.0
    points[0, :, 2], points[1, :, 2] = -1.72, -1.98
    label = np.ones((2, 400), dtype=np.uint8)

    def without(row: int) -> Sweep:
        return Sweep(np.where((np.arange(2) == row)[:, None, None] & (np.arange(400) < 9)[:, None], 0, points), label)

    # the commonest height is the one of either row: by a road of its own, all of a scan would lie 0.25 m off
    table = table_of([{"recorded": without(1), "cast": without(0), "simulated": without(0)}], firings=True)
    assert table["height over the road (JSD)"]["simulated"] < 0.02


def test_worse_is_less_of_a_share_and_more_of_a_distance() -> None:
    table = {
        "near": {"+ sensor model": 0.8, "simulated": 0.7},
        "IoU of car": {"+ sensor model": 0.4, "simulated": 0.6},
        "range (JSD)": {"+ sensor model": 0.1, "simulated": 0.2},
        "dropped": {"+ sensor model": 0.1, "simulated": 0.2},
        "near, on bus": {"simulated": 0.2},
    }
    assert losses(table) == pytest.approx({"near": 0.1, "IoU of car": -0.2, "range (JSD)": 0.1})
    assert markdown(table).endswith("of 3 rows: 1 better, 2 worse (near by 0.100, range (JSD) by 0.100).")


def test_details_bring_coarse_layouts_nearer_to_their_streets() -> None:
    table = report(street_set(4))
    assert table["IoU of car"]["simulated"] > table["IoU of car"]["+ sensor model"] + 0.05
    name = "intensity of vegetation (JSD)"
    assert table[name]["simulated"] < 0.5 * table[name]["+ sensor model"]


@needs_recordings
@pytest.mark.parametrize(
    ("images", "grid"),
    [
        (recordings.kitti_images, PRESETS["hdl64e-linear"]),
        (recordings.nuscenes_images, recordings.NUSCENES_GRID),
    ],
)
def test_images_of_recordings_are_on_their_grid(images: object, grid: Sensor) -> None:
    assert callable(images)
    for sweep in images(Path(os.environ["LIDARDRAFT_DATA"])):
        image = RangeImage.project(sweep.points[sweep.valid], grid)
        same = (image.valid & sweep.valid).sum() / sweep.valid.sum()
        assert same > 0.97
        assert set(np.unique(sweep.label[~sweep.valid])) <= {0}
