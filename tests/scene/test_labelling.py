import dataclasses

import numpy as np

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.scene.labelling import agrees, label_from_drawing
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="small", elevations=tuple(np.deg2rad([2.0, 0.0, -2.0, -4.0])), columns=360)
CAR = Primitive(shape="box", center=(10, 0, 1), size=(4, 2, 2), label="car", id="car_1", instance=7)
CROWN = Primitive(shape="ellipsoid", center=(0, 12, 2), size=(6, 6, 6), label="vegetation", id="tree_1.crown")
WALL = Primitive(shape="box", center=(-20, 0, 2), size=(1, 80, 6), label="wall", id="wall_1")
LAYOUT = Layout((CAR, CROWN, WALL))
POSE = SENSOR.pose()


def moved(depth: np.ndarray):  # type: ignore[no-untyped-def]
    drawing = raycast(LAYOUT, SENSOR)
    blank = np.zeros(SENSOR.shape, np.uint8), np.zeros(SENSOR.shape, np.uint32)
    scan = dataclasses.replace(drawing, depth=depth.astype(np.float32), label=blank[0], instance=blank[1])
    return label_from_drawing(scan, drawing, LAYOUT, POSE), drawing


def test_a_scan_like_the_drawing_gets_its_labels() -> None:
    drawing = raycast(LAYOUT, SENSOR)
    labelled, _ = moved(drawing.depth + np.where(drawing.valid, 0.3, 0.0))
    assert np.array_equal(labelled.label, drawing.label)
    assert np.array_equal(labelled.instance, drawing.instance)
    assert 7 in labelled.instance


def test_a_return_from_inside_a_crown_is_vegetation() -> None:
    drawing = raycast(LAYOUT, SENSOR)
    crown = drawing.label == BY_NAME["vegetation"].id
    depth = np.where(crown, drawing.depth + 1.5, drawing.depth)  # beyond the tolerance, inside the shape
    labelled, _ = moved(depth)
    inside = crown & (np.abs(depth - 12) < 2)
    assert inside.any()
    assert (labelled.label[inside] == BY_NAME["vegetation"].id).all()


def test_a_return_where_nothing_was_drawn_stays_without_class() -> None:
    drawing = raycast(LAYOUT, SENSOR)
    car = drawing.label == BY_NAME["car"].id
    labelled, _ = moved(np.where(car, 40.0, drawing.depth))
    assert car.any()
    assert (labelled.label[car] == 0).all()
    assert (labelled.instance[car] == 0).all()
    assert (labelled.label[~labelled.valid] == 0).all()


def test_tolerance_is_half_a_metre_or_five_percent() -> None:
    drawn = np.array([5.0, 5.0, 40.0, 40.0, 0.0, 5.0])
    depth = np.array([5.4, 5.6, 41.9, 42.1, 5.0, 0.0])
    assert agrees(depth, drawn).tolist() == [True, False, True, False, False, False]
