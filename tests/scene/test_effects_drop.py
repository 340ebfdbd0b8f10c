"""Which returns are lost, against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from observed_walls import IDEAL, SENSOR, THRESHOLD, seen, wall

from lidardraft import Layout, Primitive, raycast
from lidardraft.scene.sensor_model import sub_rays
from lidardraft.scene.weather import Weather


@pytest.mark.parametrize("distance", [20.0, 50.0, 100.0])
def test_ray_drop_follows_the_power(distance: float):
    scan = seen(wall(distance, "plaster"), replace(IDEAL, detection_threshold=THRESHOLD))
    power = 0.45 * (1 / distance**2) / THRESHOLD
    assert scan.valid.mean() == pytest.approx(math.exp(-2 / power**1.25), abs=0.02)


def test_a_threshold_of_0_detects_everything():
    assert seen(wall(190.0, "rubber"), IDEAL).valid.all()


def test_the_drop_exponent_holds_for_near_bright_surfaces():
    assert seen(wall(3.0), replace(IDEAL, drop_exponent=0.1)).valid.mean() == pytest.approx(math.exp(-0.1), abs=0.01)


def test_beams_that_make_several_echoes_are_dropped_by_their_own_probability():
    panel = Primitive(shape="box", center=(6.0, 0.0, 0.0), size=(0.1, 5.0, 8.0), label="building", id="panel")
    layout = Layout(primitives=(*wall(20.0).primitives, panel))
    fan = replace(IDEAL, rays_per_beam=3, divergence_h=9e-3, divergence_v=9e-3)
    depth = raycast(layout, sub_rays(SENSOR, fan)).depth.reshape(4, 3, -1)
    split = np.ptp(depth, axis=1) > fan.pulse_length
    assert split.sum() >= 8
    np.testing.assert_array_equal(seen(layout, replace(fan, edge_drop=20.0)).valid, ~split)
    scans = [seen(layout, replace(fan, edge_drop=0.5), seed=seed).valid for seed in range(40)]
    assert np.mean([valid[split] for valid in scans]) == pytest.approx(math.exp(-0.5), abs=0.1)
    assert all(valid[~split].all() for valid in scans)


def test_fading_keeps_the_share_of_dropped_rays_and_makes_runs_of_them():
    layout = wall(40.0, "rubber")
    power = 0.03 / 40.0**2 / 1e-6
    drops = 1 - math.exp(-2 / power**1.25)
    lengths = []
    for fading in (0.0, 1.6):
        dropped = np.concatenate(
            [~seen(layout, replace(IDEAL, detection_threshold=1e-6, fading=fading), seed=s).valid for s in range(12)]
        )
        starts = dropped[:, 1:] & ~dropped[:, :-1]
        lengths.append(dropped.sum() / starts.sum())
        assert dropped.mean() == pytest.approx(drops, abs=0.015)
    assert lengths[0] == pytest.approx(1.0 / (1 - drops), abs=0.05)
    assert lengths[1] > lengths[0] + 0.1


def test_glass_that_is_turned_away_is_dropped_where_plaster_is_not():
    # a ring seen from far below its axis: 60 degrees of incidence
    steep = replace(SENSOR, elevations=(-1.0, -1.05))
    for material, most in (("glass", 0.65), ("plaster", 0.0)):
        scan = seen(wall(15.0, material), replace(IDEAL, detection_threshold=THRESHOLD), sensor=steep)
        assert (~scan.valid).mean() >= most
    assert scan.valid.mean() > 0.9


def road() -> Layout:
    return Layout(primitives=(
        Primitive(shape="plane", center=(0.0, 0.0, 0.0), size=(400.0, 400.0, 0.0), label="road", id="road"),
    ))  # fmt: skip


def test_grazing_incidence_and_a_wet_road_drop_returns():
    down = replace(SENSOR, elevations=(-0.06, -0.15, -0.3), columns=16384)
    model = replace(IDEAL, detection_threshold=THRESHOLD / 10)
    dry, wet = (seen(road(), model, sensor=down, weather=Weather(wetness=w)).valid.mean(axis=1) for w in (0.0, 1.0))
    assert (np.diff(dry) > 0).all()
    assert (wet < dry).all()
    assert (dry - wet)[0] > 0.3


def test_a_return_from_nothing_is_no_return_in_every_image():
    scan = seen(wall(100.0, "rubber"), replace(IDEAL, detection_threshold=THRESHOLD))
    dropped = ~scan.valid
    assert dropped.mean() > 0.9
    for name, blank in (("label", 0), ("instance", 0), ("intensity", 0), ("incidence", 0), ("primitive", -1)):
        assert (getattr(scan, name)[dropped] == blank).all()
