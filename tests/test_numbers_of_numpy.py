"""Seeds, instances and metres that come out of arrays, everywhere where a file may be written of them."""

from pathlib import Path

import numpy as np

import lidardraft
from lidardraft import Box, Layout, Primitive, Sensor
from lidardraft.scene.sensor_model import IntensityCurve, SensorModel
from lidardraft.simulation.motion.sequence import SequenceSimulator
from lidardraft.streets import StreetConfig, street_scan

ONE, HALF = np.int64(1), np.float32(0.5)
CURVE = IntensityCurve(responses=np.array([0.1, 1.0]), readings=np.array([[0.0, 1.0]]))  # type: ignore[arg-type]
SENSOR = Sensor(name="few", elevations=(0.1, -0.1), columns=64, model=SensorModel(unit=ONE, intensity_curve=CURVE))  # type: ignore[arg-type]


def test_scans_and_layouts_of_them_are_written_and_read(tmp_path: Path) -> None:
    scan = lidardraft.simulate("a car ahead", SENSOR, seed=ONE, speed=HALF)  # type: ignore[arg-type]
    simulator = SequenceSimulator(scan.layout, SENSOR, frames=ONE, hz=HALF, seed=ONE)  # type: ignore[arg-type]
    street = street_scan(ONE, seed=ONE, config=StreetConfig(sensor=SENSOR))  # type: ignore[arg-type]
    for number, made in enumerate((scan, simulator.frame(0), street)):
        made.save(tmp_path / str(number), picture=False)
        assert lidardraft.Scan.load(tmp_path / str(number)).layout == made.layout
    assert type(street.layout.provenance["seed"]) is int
    cloud = lidardraft.layout_from_cloud(scan.points(), scan.labels(), sensor_height=HALF)  # type: ignore[arg-type]
    boxes = lidardraft.layout_from_boxes([Box("c", "car", ONE, (9, 0, 0), (4, 2, 2), HALF)])  # type: ignore[arg-type]
    pixels = np.full((50, 50, 3), 255, np.uint8)
    pixels[20:28, 20:24] = (0, 0, 142)
    sketch = lidardraft.layout_from_sketch(pixels, metres_per_pixel=HALF, seed=ONE)  # type: ignore[arg-type]
    car = Primitive(shape="box", center=(9, 0, 0), size=(4, 2, 2), label="car", id="c", instance=ONE)  # type: ignore[arg-type]
    for layout in (cloud, boxes, sketch, Layout((car,))):
        assert Layout.from_json(layout.to_json()) == layout
