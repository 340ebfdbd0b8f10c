"""A ring of wall around a sensor, and what the sensor reports of it."""

from lidardraft import Layout, Primitive, RangeImage, Sensor, raycast
from lidardraft.scene.effects import observe, sub_rays
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces

SENSOR = Sensor(name="small", elevations=(0.04, 0.02, -0.02, -0.04), columns=1024, range_sigma=0.0, max_range=200.0)
IDEAL = SensorModel.ideal()
THRESHOLD = 0.10 / 50.0**2  # a response of 0.1 at 50 m has power 1


def wall(distance: float, material: str | None = "plaster") -> Layout:
    """A ring of wall around the sensor, every ray at a right angle and at one distance."""
    ring = Primitive(
        shape="cylinder",
        center=(0.0, 0.0, 0.0),
        size=(2 * distance, 2 * distance, 40.0),
        label="building",
        id="ring",
        material=material,
    )
    return Layout(primitives=(ring,))


def seen(layout: Layout, model: SensorModel, *, sensor: Sensor = SENSOR, seed: int = 0, weather=None) -> RangeImage:
    """What the sensor reports of a layout, whose materials do not vary."""
    image = raycast(layout, sub_rays(sensor, model), primitive=True, incidence=True)
    wetness = 0.0 if weather is None else weather.wetness
    surfaces = Surfaces.from_layout(layout, variation=False, wetness=wetness)
    return observe(image, surfaces, seed=seed, sensor=sensor, model=model, weather=weather)
