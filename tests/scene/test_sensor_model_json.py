"""A sensor model in the file of its sensor."""

import json
import math
from dataclasses import replace

import pytest

from lidardraft import Sensor
from lidardraft.errors import LidarDraftError
from lidardraft.scene.intensity_curve import IntensityCurve
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.sensor_model_presets import MODELS

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
    assert SensorModel.from_sensor(read) == model
    assert "Infinity" not in sensor.to_json()  # which is no JSON


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ([], r"\[\] is no JSON object"),
        ({"colour": 1}, "unknown field 'colour'"),
        ({"jitter": "a"}, "jitter of the model is 'a'; it must be a finite number"),
        ({"jitter": None}, "jitter of the model is None; it must be a finite number"),
        ({"last_return": 1}, "last_return of the model is 1; it must be true or false"),
        ({"rays_per_beam": 3.5}, "rays_per_beam of the model is 3.5; it must be a whole number"),
        ({"rays_per_beam": 2}, "rays_per_beam is 2; it must be 1, or 3 to 19"),
        ({"compensation_range": "far"}, "compensation_range of the model is 'far'; it must be a number or null"),
        ({"intensity_curve": 3}, "3 is no JSON object"),
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


def test_no_model_is_none():
    assert "model" not in json.loads(SENSOR.to_json())
    assert Sensor.from_json(json.dumps(json.loads(SENSOR.to_json()) | {"model": None})) == SENSOR
