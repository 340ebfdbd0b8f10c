"""Models of sensors: their presets, the rays of a beam, curves of intensity, and their files."""

import json
import math
import pickle
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError, SensorError
from lidardraft.scene.effects import beam_tilts, sub_rays
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.sensor_model import MODELS, IntensityCurve, SensorModel, beam_fan


@pytest.mark.parametrize("degrees", [2.0, 0.125, 0.1, 0.01])
def test_the_beams_of_any_sensor_can_be_split(degrees: float):
    elevations = tuple(np.deg2rad(np.arange(200) * -degrees / 2 + 20).tolist())
    sensor = Sensor(name="dense", elevations=elevations[:60], columns=64)
    model = sensor.assumed_model
    assert len(sub_rays(sensor, model).elevations) == 180
    assert (model == SensorModel()) == (degrees > 0.3)
    for unit in range(200):  # tilted in any way
        sub_rays(sensor, replace(model, unit=unit))


def test_every_preset_has_a_model_and_another_sensor_a_typical_one():
    assert set(MODELS) == set(PRESETS)
    assert PRESETS["vlp16"].assumed_model is MODELS["vlp16"]
    assert Sensor(name="mine", elevations=(0.0,), columns=8).assumed_model == SensorModel()


def test_the_name_of_a_preset_with_other_beams_is_another_sensor():
    vlp16 = PRESETS["vlp16"]
    half = replace(vlp16, elevations=vlp16.elevations[::2])
    wide = replace(vlp16, elevations=tuple(2 * elevation for elevation in vlp16.elevations))
    for other in (half, wide, replace(vlp16, name="mine")):
        assert other.assumed_model == SensorModel() != MODELS["vlp16"]


def test_settings_and_rounding_do_not_make_another_sensor():
    vlp32c = PRESETS["vlp32c"]
    ahead = replace(vlp32c, columns=360, azimuth_start=0.5, azimuth_span=1.0, mount_height=2.0, max_range=80.0)
    rounded = replace(vlp32c, elevations=tuple(round(elevation, 4) for elevation in vlp32c.elevations))
    for same in (ahead, rounded, replace(vlp32c, azimuth_offsets=())):
        assert same.assumed_model is MODELS["vlp32c"]


def test_a_model_goes_to_another_process():
    model = replace(MODELS["os1-32"], unit=7)
    there = pickle.loads(pickle.dumps(model))
    assert there == model
    assert there.pulse_length == model.pulse_length


@pytest.mark.parametrize("name", sorted(MODELS))
def test_a_facing_surface_of_a_tenth_is_seen_to_some_tens_of_metres(name):
    reach = math.sqrt(0.10 / MODELS[name].detection_threshold)
    assert 20.0 <= reach <= 250.0


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_the_sub_rays_of_every_preset_are_a_sensor(name):
    sensor, model = PRESETS[name], MODELS[name]
    rays = sub_rays(sensor, model)
    assert rays.shape == (3 * sensor.shape[0], sensor.shape[1])
    assert sub_rays(sensor, model) is rays
    beams = np.array(rays.elevations).reshape(-1, 3)
    # their middle is the beam, in its place
    np.testing.assert_allclose(beams.mean(axis=1), sensor.elevations + beam_tilts(sensor, model), atol=1e-12)
    np.testing.assert_array_equal(rays.pattern.origins()[0, 0, 2], sensor.pattern.origins()[0, 0, 2])


@pytest.mark.parametrize("rays", [1, 3, 4, 7, 19])
def test_the_fan_has_the_power_and_the_width_of_a_gaussian_beam(rays):
    model = SensorModel(rays_per_beam=rays, divergence_h=4e-3, divergence_v=2e-3)
    across, up, share = beam_fan(model).T
    assert share.sum() == pytest.approx(1.0)
    assert share @ across == pytest.approx(0.0, abs=1e-12)
    assert (np.diff(up) < 0).all()
    if rays > 3 or rays == 3:
        # 1 / e^2 at half the divergence is two standard deviations
        assert share @ across**2 == pytest.approx((4e-3 / 4) ** 2)
        assert share @ up**2 == pytest.approx((2e-3 / 4) ** 2)


def test_one_ray_that_looks_where_it_should_is_the_sensor_itself():
    sensor = PRESETS["hdl64e"]
    assert sub_rays(sensor, SensorModel.ideal()) is sensor
    askew = sub_rays(sensor, SensorModel(rays_per_beam=1, tilt_spread=1e-3))
    assert askew.shape == sensor.shape
    assert (np.array(askew.elevations) != sensor.elevations).all()


def test_each_unit_has_tilts_of_its_own_less_where_beams_are_close():
    steps = np.array([0.25, 1.0, 5.0])
    tilts = []
    for step in steps:
        sensor = Sensor(name="mine", elevations=tuple(np.deg2rad(step) * np.arange(16.0, 0.0, -1.0)), columns=8)
        models = [SensorModel(unit=unit, tilt_spread=2e-3) for unit in range(60)]
        tilts.append([beam_tilts(sensor, model) for model in models])
        np.testing.assert_array_equal(beam_tilts(sensor, models[0]), tilts[-1][0])
    spread = np.std(tilts, axis=(1, 2))
    np.testing.assert_allclose(spread, 2e-3 * np.minimum(steps, 1.0), rtol=0.06)
    assert np.abs(np.corrcoef(tilts[0][0], tilts[0][1])[0, 1]) < 0.6


def test_beams_that_overlap_are_refused():
    close = Sensor(name="close", elevations=(0.001, 0.0), columns=8)
    with pytest.raises(
        SensorError, match=r"close: beams 1\.00 mrad apart overlap at a divergence of 3\.00 mrad; rays_per_beam"
    ):
        sub_rays(close, SensorModel(divergence_v=3e-3))


def test_a_pulse_of_5_ns_is_75_cm_long():
    assert SensorModel(pulse_duration=5e-9).pulse_length == pytest.approx(0.7495, abs=1e-4)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"detection_threshold": -1.0}, "detection_threshold is -1; it must be finite and 0 or more"),
        ({"speckle": math.nan}, "speckle is nan; it must be a finite number"),
        ({"jitter": math.inf}, "jitter is inf; it must be a finite number"),
        ({"drop_exponent": 1.5}, r"drop_exponent is 1\.5; it must be 0 to 1"),
        ({"knee": 0.0}, "knee is 0; it must be greater than 0 and at most 1"),
        ({"compensation_range": 0.0}, "compensation_range is 0; it must be greater than 0"),
        ({"pulse_duration": 0.0}, "pulse_duration is 0; it must be finite and greater than 0"),
        ({"unit": -1}, "unit is -1; it must be 0 or more"),
        ({"levels": 2.5}, "levels is 2.5; it must be a whole number"),
        ({"full_scale": 10**400}, "full_scale is 10+; it must be a finite number"),
        ({"divergence_v": "a"}, "divergence_v is 'a'; it must be a finite number"),
        ({"last_return": 1}, "last_return is 1; it must be true or false"),
        ({"rays_per_beam": 2}, "rays_per_beam is 2; it must be 1, or 3 to 19"),
        (
            {"divergence_v": 0.0},
            r"divergence is 0\.003 by 0\.0 rad; it must be greater than 0, or rays_per_beam 1",
        ),
    ],
)
def test_a_model_that_cannot_be(wrong, message):
    with pytest.raises(SensorError, match=message):
        replace(SensorModel(), **wrong)


def test_range_offsets_go_with_the_beams():
    with pytest.raises(SensorError, match="small: range_offsets has 1 values; it needs one for each of 2 beams"):
        Sensor(name="small", elevations=(0.1, 0.0), columns=4, model=SensorModel(range_offsets=(0.1,)))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"responses": (0.1, 0.2)}, "readings of a beam of the intensity curve has 1 values; it needs 2"),
        ({"responses": (), "readings": ((),)}, "responses of the intensity curve has 0 values; it needs 1"),
        ({"responses": (0.2, 0.1), "readings": ((0, 1),)}, "a response of the curve is 0.1; it must be greater than"),
        ({"readings": ((1.5,),)}, "a reading of the curve is 1.5; it must be 0 to 1"),
        ({"readings": "a"}, "readings of the intensity curve is 'a'; it must be a list of lists"),
        ({"distances": (1.0,), "distance_gains": ((),)}, "distance_gains of a beam of the intensity curve has 0"),
        ({"distance_gains": (1.0,)}, "distance_gains of the intensity curve is 1.0; it must be a list of finite"),
        ({"distances": (2, 1), "distance_gains": ((1, 1),)}, "a distance of the curve is 1; it must be greater than"),
        ({"distances": (2,), "distance_gains": ((0,),)}, "a gain of the curve is 0; it must be finite and greater"),
        ({"cutoffs": (-1.0,)}, "a cut-off of the curve is -1; it must be finite and 0 or more"),
    ],
)
def test_a_curve_that_cannot_be(wrong, message):
    with pytest.raises(SensorError, match=message):
        SensorModel(intensity_curve=IntensityCurve(**{"responses": (0.1,), "readings": ((0.5,),)} | wrong))


def test_a_curve_goes_with_the_beams_of_its_sensor():
    sensor = Sensor(name="mine", elevations=(0.1, 0.0, -0.1), columns=8)
    curve = IntensityCurve(responses=(0.1,), readings=((0.5,), (0.6,)))
    with pytest.raises(SensorError, match="mine: readings of the intensity curve has 2 values; it needs 3"):
        replace(sensor, model=SensorModel(intensity_curve=curve))


SENSOR = Sensor(name="mine", elevations=(0.1, -0.1), columns=8)
CURVE = IntensityCurve(responses=(0.1, 1.0), readings=((0.0, 0.5), (0.1, 0.2)), cutoffs=(0.1, 0.0))


@pytest.mark.parametrize(
    "model",
    [
        SensorModel(),
        MODELS["hdl64e"],
        replace(MODELS["vlp32c"], intensity_curve=CURVE, last_return=True, compensation_range=math.inf),
    ],
    ids=["default", "hdl64e", "all"],
)
def test_a_sensor_file_carries_the_model(model, tmp_path):
    sensor = replace(SENSOR, model=model)
    (tmp_path / "mine.json").write_text(sensor.to_json())
    read = Sensor.load(tmp_path / "mine.json")
    assert read == sensor
    assert read.assumed_model == model
    assert "Infinity" not in sensor.to_json()  # which is no JSON


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ([], r"\[\] is not a JSON object"),
        ({"colour": 1}, "unknown field 'colour'"),
        ({"unit": 1e30}, "unit is 1e.30; it must be a whole number"),
        ({"intensity_curve": 3}, "3 is not a JSON object"),
        ({"intensity_curve": {"responses": [1]}}, "'readings' is missing"),
        ({"intensity_curve": {"responses": [1], "readings": [["a"]]}}, r"readings of the intensity curve is \['a'\]"),
        (
            {"intensity_curve": {"responses": [1], "readings": [[1]], "cutoffs": [0.1]}},
            "mine: cutoffs of the intensity curve has 1 values; it needs 2",
        ),
    ],
    ids=str,
)
def test_a_model_that_is_none(fields, message):
    text = json.dumps(json.loads(SENSOR.to_json()) | {"model": fields})
    with pytest.raises(LidarDraftError, match=message):
        Sensor.from_json(text)


def test_the_page_explains_every_number():
    page = (Path(__file__).parents[2] / "docs" / "explanation" / "sensor-model.md").read_text()
    assert not [field.name for field in fields(SensorModel) if f"`{field.name}`" not in page]


def test_no_model_is_none():
    assert "model" not in json.loads(SENSOR.to_json())
    assert Sensor.from_json(json.dumps(json.loads(SENSOR.to_json()) | {"model": None})) == SENSOR


def test_the_hdl64e_reads_roads_at_a_quarter():
    curve = MODELS["hdl64e"].intensity_curve
    assert curve is not None
    (readings,) = curve.readings
    assert np.interp(np.log(0.1), np.log(curve.responses), readings) == pytest.approx(0.26, abs=0.002)
    assert max(readings) == 1.0
