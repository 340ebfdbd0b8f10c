"""Labels of a generated scan."""

import dataclasses

import numpy as np

from lidardraft import Layout, Primitive, RangeImage, Sensor, raycast
from lidardraft.scene.labelling import agrees, label_by_agreement
from lidardraft.scene.road import Road
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="small", elevations=tuple(np.deg2rad([2.0, 0.0, -2.0, -4.0])), columns=360)
CAR = Primitive(shape="box", center=(10, 0, 1), size=(4, 2, 2), label="car", id="car_1", instance=7)
CROWN = Primitive(shape="ellipsoid", center=(0, 12, 2), size=(6, 6, 6), label="vegetation", id="tree_1.crown")
WALL = Primitive(shape="box", center=(-20, 0, 2), size=(1, 80, 6), label="wall", id="wall_1")
LAYOUT = Layout((CAR, CROWN, WALL))
POSE = SENSOR.pose()


def moved(depth: np.ndarray):  # type: ignore[no-untyped-def]
    condition_image = raycast(LAYOUT, SENSOR)
    blank = np.zeros(SENSOR.shape, np.uint8), np.zeros(SENSOR.shape, np.uint32)
    scan = dataclasses.replace(condition_image, depth=depth.astype(np.float32), label=blank[0], instance=blank[1])
    return label_by_agreement(scan, [condition_image], LAYOUT, POSE), condition_image


def test_a_scan_like_the_condition_image_gets_its_labels() -> None:
    condition_image = raycast(LAYOUT, SENSOR)
    labelled, _ = moved(condition_image.depth + np.where(condition_image.valid, 0.3, 0.0))
    assert np.array_equal(labelled.label, condition_image.label)
    assert np.array_equal(labelled.instance, condition_image.instance)
    assert 7 in labelled.instance


def test_a_return_from_inside_a_crown_is_vegetation() -> None:
    condition_image = raycast(LAYOUT, SENSOR)
    crown = condition_image.label == BY_NAME["vegetation"].id
    depth = np.where(
        crown, condition_image.depth + 1.5, condition_image.depth
    )  # beyond the tolerance, inside the shape
    labelled, _ = moved(depth)
    inside = crown & (np.abs(depth - 12) < 2)
    assert inside.any()
    assert (labelled.label[inside] == BY_NAME["vegetation"].id).all()


def test_a_return_of_a_moving_sensor_is_where_its_column_was() -> None:
    """At 100 m/s the columns of the crown, at the left, are taken 2.5 m behind the middle of the sweep."""
    poses = SENSOR.poses_in_motion(POSE, (100.0, 0.0, 0.0))
    layout = Layout((dataclasses.replace(CROWN, size=(2, 6, 6), center=(-2.5, 12, 2)),))
    image = raycast(layout, SENSOR, poses=poses)
    crown = image.valid
    inside = dataclasses.replace(
        image,
        depth=image.depth + np.where(crown, np.float32(1.5), 0),
        label=0 * image.label,
        instance=0 * image.instance,
    )
    assert crown.sum() > 10
    labelled = label_by_agreement(inside, [image], layout, poses)
    assert (labelled.label[crown] == BY_NAME["vegetation"].id).mean() > 0.8
    still = label_by_agreement(inside, [image], layout, POSE)
    assert (still.label[crown] == 0).all()


def test_what_is_known_of_no_shape_keeps_the_class_that_the_scan_has() -> None:
    condition_image = raycast(LAYOUT, SENSOR)
    car = condition_image.label == BY_NAME["car"].id
    pole = np.full_like(condition_image.label, BY_NAME["pole"].id) * condition_image.valid
    depth, instance = np.where(car, np.float32(40), condition_image.depth), np.full(SENSOR.shape, 3, np.uint32)
    scan = dataclasses.replace(condition_image, depth=depth, label=pole, instance=instance)
    labelled = label_by_agreement(scan, [condition_image], LAYOUT, POSE)
    assert car.any()
    assert (labelled.label[car] == BY_NAME["pole"].id).all()
    assert (labelled.instance[car] == 3).all()
    rest = ~car & labelled.valid
    np.testing.assert_array_equal(labelled.label[rest], condition_image.label[rest])


def test_a_return_where_the_condition_image_has_nothing_stays_without_class() -> None:
    condition_image = raycast(LAYOUT, SENSOR)
    car = condition_image.label == BY_NAME["car"].id
    labelled, _ = moved(np.where(car, 40.0, condition_image.depth))
    assert car.any()
    assert (labelled.label[car] == 0).all()
    assert (labelled.instance[car] == 0).all()
    assert (labelled.label[~labelled.valid] == 0).all()


def test_a_bend_does_not_label_the_gardens_beside_it() -> None:
    road = Road(curvature=0.02)
    layout = Layout(tuple(road_surfaces(road)))
    condition_image = raycast(layout, SENSOR)
    terrain = condition_image.label == BY_NAME["terrain"].id
    depth = np.where(terrain, condition_image.depth * 0.94, condition_image.depth).astype(np.float32)
    labelled = label_by_agreement(dataclasses.replace(condition_image, depth=depth), [condition_image], layout, POSE)
    assert terrain.sum() > 100
    assert not np.isin(labelled.label[terrain], [BY_NAME["sidewalk"].id, BY_NAME["road"].id]).any()


def test_tolerance_is_half_a_metre_or_five_percent() -> None:
    row = Sensor(name="row", elevations=(0.0,), columns=6)
    nothing = {"label": np.zeros((1, 6), np.uint8), "instance": np.zeros((1, 6), np.uint32)}
    condition_image = RangeImage(sensor=row, depth=np.array([[5.0, 5.0, 40.0, 40.0, 0.0, 5.0]], np.float32), **nothing)
    scan = RangeImage(sensor=row, depth=np.array([[5.4, 5.6, 41.9, 42.1, 5.0, 0.0]], np.float32), **nothing)
    assert agrees(scan, condition_image).tolist() == [[True, False, True, False, False, False]]
