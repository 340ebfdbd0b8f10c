"""The vehicle that carries a sensor: what it hides, and its own returns."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import (
    Layout,
    Mount,
    Primitive,
    Rig,
    Sensor,
    SequenceSimulator,
    Simulator,
    World,
    raycast,
    simulate,
    with_vehicle,
)
from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene.range_image import images_of
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME

CAR = BY_NAME["car"].id
GROUND = Layout((Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road"),))
BONNET = Layout((Primitive(shape="box", center=(1.5, 0, 1), size=(1.5, 1.6, 0.1), label="car", id="ego", instance=1),))
HDL = replace(PRESETS["hdl64e"], columns=512)
MINE = Sensor(name="mine", elevations=(-0.2, -0.4, -0.6), columns=360)
FORMS = {
    "turn": HDL,
    "sector": replace(HDL, azimuth_start=1.0, azimuth_span=2.0, columns=200),
    "staggered": replace(MINE, azimuth_offsets=(0.0, 0.1, -0.1)),
    "one beam": Sensor(name="one", elevations=(-0.5,), columns=360),
    "flash": replace(HDL, sweep_time=0.0),
}


@pytest.mark.parametrize("sensor", FORMS.values(), ids=FORMS)
@pytest.mark.parametrize("speed", [0.0, 12.0])
def test_a_vehicle_hides_the_rays_that_meet_it_and_no_others(sensor, speed):
    bare = simulate(GROUND, sensor, carrier=False, speed=speed)
    scan = simulate(GROUND, sensor, carrier=BONNET, speed=speed)
    met = raycast(BONNET, replace(sensor, min_range=1e-3), sensor.pose()).valid
    assert bare.image.sensor == sensor
    assert 0 < met.sum() < met.size
    assert not scan.image.valid[met].any()
    edge = met | np.roll(met, 1, axis=1) | np.roll(met, -1, axis=1)
    for name, image in images_of(bare.image).items():
        np.testing.assert_array_equal(getattr(scan.image, name)[~edge], image[~edge], err_msg=name)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_know_a_car_that_hides_some_of_the_ground_and_nothing_higher(name):
    sensor = with_vehicle(PRESETS[name])
    hidden = sensor.blocked_pixels
    over_it = name in ("os1-32", "os2-128")  # their lowest beams pass over the car
    assert (0.0 if over_it else 0.005) <= hidden.mean() < 0.3
    assert not hidden[np.array(sensor.elevations) > math.radians(-3)].any()
    np.testing.assert_array_equal(simulate(GROUND, PRESETS[name]).image.sensor.blocked_pixels, hidden)
    assert with_vehicle(sensor) == sensor


def test_its_own_returns_lie_on_the_car_and_belong_to_no_object():
    for name, size in (("hdl64e", (4.77, 1.82, 1.47)), ("pandar64", (5.17, 2.02, 1.78))):
        scan, without = (simulate(GROUND, PRESETS[name], own_returns=own) for own in (True, False))
        hidden = without.image.sensor.blocked_pixels
        own = scan.image.valid & hidden
        assert own.sum() > 0.2 * hidden.sum()
        assert set(scan.image.label[own]) == {CAR}
        assert not scan.image.instance[own].any()
        points = scan.image.points()[scan.labels() == CAR] + [0, 0, PRESETS[name].mount_height]
        assert (np.abs(points) <= np.add(size, 0.8) / [2, 2, 1]).all()
        np.testing.assert_array_equal(np.where(hidden, 0, scan.image.depth), without.image.depth)
        assert not scan.image.sensor.blocked_pixels[own].any()


def test_sequences_and_worlds_carry_it_along():
    street = "a street with a bus ahead"
    sequence = SequenceSimulator(street, HDL, frames=2, own_returns=True)
    again = pickle.loads(pickle.dumps(sequence))
    world = World(street, HDL)
    world.step(0.5)
    hidden = with_vehicle(HDL).blocked_pixels
    for number in range(2):
        image = sequence.frame(number).image
        own = (image.label == CAR) & (image.instance == 0)
        assert own.sum() > 100
        assert not own[~hidden].any()
        np.testing.assert_array_equal(again.frame(number).image.depth, image.depth)
    assert not world.scan().image.valid[hidden].any()
    assert world.scan().image.valid[~hidden].mean() > 0.5


def test_a_sensor_of_a_rig_sees_the_car_from_its_mount():
    left = (0.3, 0.8, 1.8, 1.2)
    rig = Rig({"top": Mount(HDL, (0.0, 0.0, 1.73, 0.0)), "left": Mount(HDL, left)})
    scans = World(GROUND, rig).scans()
    assert scans["top"].image.sensor == with_vehicle(HDL)
    assert scans["left"].image.sensor == with_vehicle(HDL, spot=left)
    assert scans["left"].image.sensor != scans["top"].image.sensor
    hidden = scans["left"].image.sensor.blocked_pixels[-1]
    right = (HDL.azimuths[-1] + 1.2 + math.pi) % (2 * math.pi) < math.pi  # of the car
    assert hidden[right].mean() > hidden[~right].mean() + 0.2


def test_without_a_known_vehicle_a_line_says_so():
    low = replace(HDL, mount_height=0.6)
    for sensor, line in (
        (MINE, "mine has no known vehicle: none is carried"),
        (low, r"hdl64e stands 0.6 m over the road, within its typical car of 1.47 m: none is carried"),
    ):
        scan = simulate(GROUND, sensor)
        assert scan.image.sensor == sensor
        assert line in scan.notes
        with pytest.raises(SensorError, match=line):
            with_vehicle(sensor)
        with pytest.raises(SensorError, match=f"own_returns of {sensor.name} need the shape of its vehicle"):
            Simulator(GROUND, sensor, own_returns=True)
        assert line not in simulate(GROUND, sensor, carrier=False).notes
    fitted = replace(HDL, blocked=(((0.0, 1.0),),) * 64)
    assert simulate(GROUND, fitted).image.sensor == fitted


def test_an_invalid_vehicle():
    shell = Layout((Primitive(shape="ellipsoid", center=(0, 0, 1.7), size=(3, 3, 3), label="car", id="ego"),))
    with pytest.raises(LayoutError, match=r"the vehicle hides every ray of hdl64e at \(0, 0, 1.73\) m; move one"):
        simulate(GROUND, HDL, carrier=shell)
    with pytest.raises(LayoutError, match="carrier is an empty layout; it must have shapes"):
        simulate(GROUND, HDL, carrier=Layout())
    with pytest.raises(TypeError, match="carrier"):
        simulate(GROUND, HDL, carrier="car")
    with pytest.raises(SensorError, match="own_returns of hdl64e need the shape"):
        simulate(GROUND, HDL, carrier=False, own_returns=True)
