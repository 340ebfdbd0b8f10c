"""What is compared with what, on measurements by hand."""

import math

import numpy as np
import pytest

from comparison import compare
from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import CLASS_SETS, PROPERTIES, Property
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME


def mean_gap(first: lifelike.Features, second: lifelike.Features) -> float:
    return abs(float(np.mean(first)) - float(np.mean(second)))


GAP = Property("gap", lambda _: np.zeros(1), mean_gap, lambda features: float(np.mean(features)))


def values(*numbers: float) -> list[np.ndarray]:
    return [np.array([number]) for number in numbers]


def test_generated_sweeps_stand_in_for_each_group() -> None:
    found = compare(GAP, {"a": values(1, 1), "b": values(3, 3)}, values(*[4.0] * 8))
    assert (found.recorded, found.generated) == (2.0, 4.0)
    assert found.recorded_vs_recorded == 2.0
    assert found.generated_vs_recorded == pytest.approx((3 + 1) / 2)
    assert found.ratio == 1.0


def test_drives_that_are_equal_by_chance_differ_as_their_halves_do() -> None:
    groups = {"a": values(0, 0, 2, 2), "b": values(1, 1, 1, 1)}
    assert compare(GAP, groups, values(1, 1)).recorded_vs_recorded == 1.0


def test_only_as_many_generated_sweeps_as_the_group_has() -> None:
    sizes = []

    def counted(first: lifelike.Features, second: lifelike.Features) -> float:
        sizes.append((len(first), len(second)))
        return 1.0

    row = Property("counted", GAP.measure, counted, GAP.summary)
    compare(row, {"a": values(*[1.0] * 3), "b": values(*[1.0] * 2)}, values(*range(13)))
    # recorded against recorded, then 2 for b's place beside a and 3 for a's place beside b, each several times
    assert sizes == [(3, 2), *[(2, 3)] * 6, *[(3, 2)] * 4]


def test_a_group_without_any_count_is_left_out() -> None:
    found = compare(GAP, {"a": values(1, 1), "b": values(0, 0)}, values(2, 2))
    assert math.isnan(found.recorded_vs_recorded)
    assert math.isnan(found.ratio)
    assert found.generated_vs_recorded == 1.0


def test_a_sweep_without_a_measurement_does_not_leave_its_group_out() -> None:
    row = Property("value", GAP.measure, lifelike.value_difference, lifelike._mean_value)
    groups = {"a": [np.array(1.0), np.array(math.nan)], "b": [np.array(3.0)] * 2}
    found = compare(row, groups, [np.array(2.0)] * 2)
    assert (found.recorded, found.recorded_vs_recorded, found.generated_vs_recorded) == (2.0, 2.0, 1.0)


def test_pooled_means_use_bins_that_both_have() -> None:
    first = [np.array([[30.0, 100.0], [5.0, 10.0]])]
    second = [np.array([[25.0, 50.0], [100.0, 100.0]]), np.array([[25.0, 50.0], [0.0, 100.0]])]
    assert lifelike.mean_difference(first, second) == pytest.approx(0.2)
    assert math.isnan(lifelike.mean_difference(first, [np.zeros((2, 2))]))


def test_values_that_are_not_known_are_left_out() -> None:
    known, unknown = [np.float64(0.25), np.float64(math.nan)], [np.float64(math.nan)]
    assert lifelike.value_difference(known, [np.float64(0.5)]) == pytest.approx(0.25)
    assert math.isnan(lifelike.value_difference(known, unknown))


def test_class_counts_sum_members_and_leave_out_the_rest() -> None:
    label = np.array([[BY_NAME[name].id for name in ("wall", "fence", "rider", "other", "car")]], dtype=np.uint8)
    points = np.ones((1, 5, 3), dtype=np.float32)
    points[0, 4] = 0  # no return
    counted = dict(zip(CLASS_SETS, lifelike.class_counts(Sweep(points, label)), strict=True))
    assert {name: count for name, count in counted.items() if count} == {"fence": 2, "person": 1}


def test_every_property_has_no_distance_to_itself(street_sweep: Sweep) -> None:
    for one in (*PROPERTIES, *lifelike.INTENSITY_PROPERTIES, *lifelike.class_properties()):
        measured = one.measure(street_sweep)
        if np.nansum(np.abs(measured)) > 0:
            assert one.distance([measured], [measured]) == pytest.approx(0.0, abs=1e-6), one.name


@pytest.fixture(scope="module")
def street_sweep() -> Sweep:
    from lidardraft.streets import StreetConfig, make_street, streets

    sensor = PRESETS["vlp16"]
    assert raycast(make_street(seed=0).scene, sensor).valid.any()
    return Sweep.from_image(next(streets(seed=0, config=StreetConfig(sensor=sensor, poses_per_street=1))).scan)
