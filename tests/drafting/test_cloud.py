import io
import lzma
import math
import os
import re
from pathlib import Path

import numpy as np
import pytest

from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.errors import LayoutError
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.semantickitti import read_label
from lidardraft.scene.labelling import agrees
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, CLASSES

SENSOR = Sensor.preset("hdl64e")
# SemanticKITTI's training ids 0 to 19 as our classes.
TRAIN_IDS = ["none", "car", "bicycle", "motorcycle", "truck", "truck", "person", "rider", "rider", "road", "road"]
TRAIN_IDS += ["sidewalk", "terrain", "building", "fence", "vegetation", "trunk", "terrain", "pole", "traffic-sign"]


def primitive(shape, center, size, label, id, **fields):
    return Primitive(shape=shape, center=center, size=size, label=label, id=id, **fields)


STREET = Layout(
    primitives=(
        primitive("plane", (0, 0, 0), (160, 10, 0), "road", "road"),
        primitive("plane", (0, 7, 0.12), (160, 4, 0), "sidewalk", "sidewalk"),
        primitive("plane", (0, 0, -0.1), (200, 200, 0), "terrain", "terrain"),
        primitive("box", (12, 3, 0.75), (4.2, 1.8, 1.5), "car", "car_1", yaw=0.1, instance=1),
        primitive("box", (12, -3, 0.75), (4.2, 1.8, 1.5), "car", "car_2", instance=2),
        primitive("box", (8, -8, 0.85), (0.6, 0.6, 1.7), "person", "person_1", instance=3),
        primitive("box", (10, 16, 3), (30, 6, 6), "building", "building"),
        primitive("cylinder", (6, 6, 2.5), (0.3, 0.3, 5), "pole", "pole"),
        primitive("ellipsoid", (-10, -10, 1.5), (3, 3, 3), "vegetation", "bush"),
    )
)


def street_cloud():
    image = raycast(STREET, SENSOR)
    return image.points(), image.label[image.valid], image.instance[image.valid]


def test_a_scanned_street_is_scanned_again():
    points, labels, instances = street_cloud()
    layout = layout_from_cloud(points, labels, instances=instances)
    scan, condition_image = raycast(STREET, SENSOR), raycast(layout, SENSOR)
    good = agrees(scan, condition_image)
    least = {"road": 0.97, "car": 0.95, "building": 0.95, "pole": 0.6, "person": 0.9, "vegetation": 0.7}
    for name, share in least.items():
        assert good[scan.label == BY_NAME[name].id].mean() > share, name


@pytest.mark.parametrize("numbered", [True, False])
def test_things_become_numbered_boxes_where_they_are(numbered):
    points, labels, instances = street_cloud()
    layout = layout_from_cloud(points, labels, instances=instances if numbered else None)
    boxes = layout.boxes()
    assert sorted(box.label for box in boxes) == ["car", "car", "person"]
    assert [box.instance for box in boxes] == [1, 2, 3]
    cars = sorted((box for box in boxes if box.label == "car"), key=lambda box: box.center[1])
    for car, y in zip(cars, (-3.0, 3.0), strict=True):
        np.testing.assert_allclose(car.center, (12.0, y, 0.75), atol=0.3)
        np.testing.assert_allclose(car.size, (4.2, 1.8, 1.5), atol=0.4)


def standing_alone(label, yaw, at, size=None):
    """Points and labels of one object on a road, and the object; the road shows under it, its foot reads as road."""
    size = size or BY_NAME[label].size
    center = (12.0 * math.cos(at), 12.0 * math.sin(at), (0.3 + size[2]) / 2)
    placed = primitive("box", center, (*size[:2], size[2] - 0.3), label, "object", yaw=yaw, instance=1)
    image = raycast(Layout(primitives=(STREET["road"], STREET["terrain"], placed)), SENSOR)
    points, labels = image.points(), image.label[image.valid]
    labels = np.where(points[:, 2] + SENSOR.mount_height < 0.4, BY_NAME["road"].id, labels)
    return points, labels, placed


def overlap(a, b):
    """Intersection over union of two boxes seen from above, on a grid of 0.1 m."""
    x, y = np.meshgrid(np.arange(-30, 30, 0.1), np.arange(-30, 30, 0.1))
    inside = []
    for one in (a, b):
        cos, sin = math.cos(one.yaw), math.sin(one.yaw)
        u, v = x - one.center[0], y - one.center[1]
        inside.append((abs(cos * u + sin * v) < one.size[0] / 2) & (abs(cos * v - sin * u) < one.size[1] / 2))
    return np.count_nonzero(inside[0] & inside[1]) / np.count_nonzero(inside[0] | inside[1])


@pytest.mark.parametrize("label", ["car", "truck", "bus", "motorcycle", "rider"])
@pytest.mark.parametrize("degrees", range(0, 180, 30))
def test_an_object_seen_from_one_side_is_completed_over_the_road_seen_under_it(label, degrees):
    points, labels, placed = standing_alone(label, math.radians(degrees), at=0.5)
    (box,) = layout_from_cloud(points, labels, detail="objects").boxes()
    assert overlap(box, placed) > 0.65


@pytest.mark.parametrize("size", [(3.2, 1.5, 1.5), (4.8, 2.0, 1.8), (5.4, 2.0, 2.2)])
@pytest.mark.parametrize("degrees", range(0, 180, 30))
def test_small_cars_and_vans_are_completed_too(size, degrees):
    points, labels, placed = standing_alone("car", math.radians(degrees), at=-0.8, size=size)
    (box,) = layout_from_cloud(points, labels, detail="objects").boxes()
    assert overlap(box, placed) > 0.5


@pytest.mark.parametrize("degrees", [40, 45, 50])
def test_an_object_does_not_grow_to_where_rays_passed(degrees):
    # both sides of a car much smaller than others; what is behind it was seen past it
    points, labels, placed = standing_alone("car", math.radians(degrees), at=0.0, size=(2.2, 1.5, 1.2))
    (box,) = layout_from_cloud(points, labels).boxes()
    assert overlap(box, placed) > 0.7


def test_a_car_of_a_parked_row_that_is_partly_hidden_stands_as_the_row_does():
    """A van hides all but 1.4 m of the flank of a car parked across the way ahead, beside one that is seen whole."""
    across = {"size": (4.2, 1.8, 1.5), "yaw": math.pi / 2}
    row = (
        primitive("box", (20, 6, 0.75), label="car", id="car_1", instance=1, **across),
        primitive("box", (23, 0, 0.75), label="car", id="car_2", instance=2, **across),
        primitive("box", (12, -1.0, 1.5), (4, 2.2, 3), "truck", "truck", instance=3),
    )
    image = raycast(Layout(primitives=(*row, STREET.primitives[2])), SENSOR)
    layout = layout_from_cloud(image.points(), image.label[image.valid])
    hidden = min(layout.boxes(), key=lambda box: math.dist(box.center[:2], (23, 0)))
    assert math.dist(hidden.center[:2], (23, 0)) < 0.4
    assert abs(math.remainder(hidden.yaw - math.pi / 2, math.pi)) < 0.1


def test_people_who_stand_close_stay_apart():
    people = [(8.0, 0.45 * k, 0.0) for k in range(5)]
    body = np.array(
        [[x, y, z] for x in (0.0, 0.1) for y in np.arange(-0.2, 0.21, 0.05) for z in np.arange(-1.7, 0, 0.1)]
    )
    points = np.concatenate([body + one for one in people])
    labels = np.full(len(points), BY_NAME["person"].id)
    instances = np.repeat(np.arange(1, 6), len(body))
    assert len(layout_from_cloud(points, labels, instances=instances).boxes()) == 5


def test_points_that_rays_pass_by_the_hundred_are_no_car():
    points, labels, _ = street_cloud()
    specks = np.random.default_rng(0).uniform((7, 7, -1.0), (8, 7.5, -0.2), (20, 3))  # in front of the building
    layout = layout_from_cloud(
        np.concatenate([points, specks]), np.concatenate([labels, np.full(20, BY_NAME["car"].id, np.uint8)])
    )
    assert sorted(box.label for box in layout.boxes()) == ["car", "car", "person"]


def test_road_that_is_called_a_car_is_none():
    points, labels, _ = street_cloud()
    labels[(np.abs(points[:, :2] - (8, 0)) < 1.5).all(axis=1) & (labels == BY_NAME["road"].id)] = BY_NAME["car"].id
    assert sorted(box.label for box in layout_from_cloud(points, labels).boxes()) == ["car", "car", "person"]


def test_the_layout_says_where_it_came_from_and_stays_the_same():
    points, labels, instances = street_cloud()
    layout = layout_from_cloud(points, labels, instances=instances, source="street.bin")
    assert layout.provenance == {"source": "street.bin", "sensor_height": 1.73}
    assert layout == layout_from_cloud(points, labels, instances=instances, source="street.bin")
    assert layout == Layout.from_json(layout.to_json())


def test_a_facade_around_the_sensor_does_not_swallow_it():
    walls = Layout(
        primitives=(
            primitive("plane", (0, 0, 0), (60, 60, 0), "road", "road"),
            *(
                primitive("box", (x, y, 2), size, "building", f"building_{k}")
                for k, (x, y, size) in enumerate(
                    [(0, 10, (22, 1, 4)), (0, -10, (22, 1, 4)), (10.5, 0, (1, 20, 4)), (-10.5, 0, (1, 20, 4))]
                )
            ),
        )
    )
    image = raycast(walls, SENSOR)
    condition_image = raycast(layout_from_cloud(image.points(), image.label[image.valid]), SENSOR)
    assert agrees(image, condition_image)[image.valid].mean() > 0.95


def test_the_ground_slopes_with_the_points():
    slope = Primitive.from_mesh(
        np.array([[-40.0, -40, -2], [40, -40, 2], [40, 40, 2], [-40, 40, -2]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
        label="road",
        id="road",
    )
    image = raycast(Layout(primitives=(slope,)), SENSOR)
    layout = layout_from_cloud(image.points(), image.label[image.valid])
    assert agrees(image, raycast(layout, SENSOR))[image.valid].mean() > 0.97


@pytest.mark.parametrize("name", [row.name for row in CLASSES[1:]])
def test_one_point_of_any_class_is_enough_not_to_fail(name):
    labels = np.array([BY_NAME[name].id], dtype=np.uint8)
    layout = layout_from_cloud(np.array([[5.0, 1.0, -1.0]]), labels, instances=np.array([7], dtype=np.uint32))
    assert layout["ground"].label == "terrain"


def test_sensor_height_lifts_the_points():
    points = np.array([[x, y, -2.0] for x in np.arange(3, 9, 0.3) for y in np.arange(-3, 3, 0.3)])
    layout = layout_from_cloud(points, np.full(len(points), BY_NAME["road"].id), sensor_height=2.5)
    assert layout["road"].center[2] == pytest.approx(0.5)


POINTS, LABELS = np.ones((4, 3)), np.ones(4, dtype=np.uint8)


@pytest.mark.parametrize(
    ("points", "labels", "instances", "message"),
    [
        (np.zeros((4, 2)), LABELS, None, r"points have shape \(4, 2\); they must be \[N, 3\] with N > 0"),
        (np.zeros((0, 3)), LABELS[:0], None, r"points have shape \(0, 3\); they must be \[N, 3\] with N > 0"),
        (POINTS, LABELS[:3], None, r"labels have shape \(3,\); 4 points need \(4,\)"),
        (POINTS, LABELS, np.zeros(5, dtype=int), r"instances have shape \(5,\); 4 points need \(4,\)"),
        (np.array([[0, 0, 1.0], [np.nan, 0, 1]]), LABELS[:2], None, r"point 1 is \[nan, 0.0, 1.0\]; every coordinate"),
        (POINTS, LABELS * 21, None, r"point 0 has label 21; it must be 0 to 20"),
        (POINTS, LABELS * 0, None, r"all 4 points have label 0, unlabelled"),
        (POINTS * 1e9, LABELS, None, r"point 0 is \[1000000000.0, .*\]; a scan reaches 1000 m"),
        (POINTS, LABELS * 1.5, None, r"labels are float64; they must be whole numbers"),
        (POINTS, lambda _: LABELS[:2], None, r"labels have shape \(2,\); 4 points need \(4,\)"),
    ],
)
def test_arrays_that_cannot_be_a_cloud(points, labels, instances, message):
    with pytest.raises(LayoutError, match=message):
        layout_from_cloud(points, labels, instances=instances)


ALONG, ACROSS = np.random.default_rng(0).uniform(0, 1, (2, 600))
ZEROS = np.zeros(600)


@pytest.mark.parametrize("detail", ["fine", "objects"])
@pytest.mark.parametrize("name", ["road", "car", "vegetation", "building", "pole", "traffic-sign"])
@pytest.mark.parametrize(
    ("points", "said"),
    [
        (np.tile([[7.0, 2.0, -0.5]], (600, 1)), "all 600 points lie in one spot; they show no shape"),
        (np.outer(5 + 30 * ALONG, [0.8, 0.5, -0.05]), "all 600 points lie on one line"),
        (np.column_stack([ZEROS + 5, ZEROS + 1, 3 * ALONG]), "all 600 points lie on one line"),
        (np.column_stack([ZEROS, ACROSS, ALONG]) * (np.arange(600) != 7)[:, None], "point 7 .* in the sensor itself"),
        (np.column_stack([5 + 20 * ALONG, 10 * ACROSS - 5, ZEROS - 1]), None),
        (np.column_stack([ZEROS + 8, 10 * ALONG - 5, 3 * ACROSS - 1.7]), None),
        (np.column_stack([20 * ALONG - 10, ZEROS, 3 * ACROSS - 1.7]), None),  # through the sensor
    ],
    ids=["spot", "ray", "upright", "sensor", "flat", "wall", "fan"],
)
def test_points_of_fewer_than_three_dimensions(points, said, name, detail):
    labels = np.full(600, BY_NAME[name].id)
    if said:
        with pytest.raises(LayoutError, match=said):
            layout_from_cloud(points, labels, detail=detail)
    else:
        layout = layout_from_cloud(points, labels, detail=detail)
        assert all(math.isfinite(value) for one in layout for value in (*one.center, *one.size, one.yaw))


def test_labels_may_be_told_by_a_function_of_the_points():
    points, labels, _ = street_cloud()
    asked = []

    def segment(given):
        asked.append(given)
        return labels

    assert layout_from_cloud(points, segment) == layout_from_cloud(points, labels)
    assert len(asked) == 1
    np.testing.assert_array_equal(asked[0], points)


@pytest.mark.parametrize("detail", ["fine", "objects"])
def test_objects_stay_whole_in_any_detail(detail):
    points, labels, _ = street_cloud()
    layout = layout_from_cloud(points, labels, detail=detail)
    assert sorted(box.label for box in layout.boxes()) == ["car", "car", "person"]
    assert [one.shape for one in layout if one.label == "pole"] == ["cylinder"]


def woods():
    """A hedge of 30 m, a house with a corner, and a row of trees, on both sides of a road."""
    trees = [primitive("ellipsoid", (x, 9, 4), (4, 4, 4), "vegetation", f"tree_{x}") for x in range(-20, 25, 8)]
    return Layout(
        primitives=(
            primitive("plane", (0, 0, 0), (120, 120, 0), "road", "road"),
            primitive("box", (0, -6, 0.75), (30, 1, 1.5), "vegetation", "hedge"),
            primitive("box", (12, 20, 4), (16, 8, 8), "building", "house"),
            primitive("box", (24, 28, 4), (8, 20, 8), "building", "wing"),
            *trees,
        )
    )


def test_few_objects_are_for_hands_and_many_pieces_for_the_cast():
    image = raycast(woods(), SENSOR)
    labels = image.label[image.valid]
    fine, objects = (layout_from_cloud(image.points(), labels, detail=detail) for detail in ("fine", "objects"))
    agreed = {len(each): agrees(image, raycast(each, SENSOR))[image.valid].mean() for each in (fine, objects)}
    assert len(objects) < 25 < len(fine)
    assert agreed[len(fine)] > 0.93
    assert agreed[len(objects)] > 0.8
    # what is to be edited stands on the ground
    assert all(one.center[2] - one.size[2] / 2 < 0.1 for one in objects if one.label == "building")


def test_a_long_hedge_is_tiled():
    image = raycast(woods(), SENSOR)
    mine = image.label[image.valid] == BY_NAME["vegetation"].id
    layout = layout_from_cloud(image.points(), image.label[image.valid] * mine, detail="objects")
    hedge = [one for one in layout if one.label == "vegetation" and one.center[1] < 0]
    assert 4 <= len(hedge) <= 12
    assert 2.0 < max(max(one.size[:2]) for one in hedge) < 11.0


def recordings():
    folder = os.environ.get("LIDARDRAFT_DATA")
    if not folder or not (Path(folder) / "kitti").is_dir():
        pytest.skip("LIDARDRAFT_DATA does not name a folder with kitti/ in it")
    return Path(folder) / "kitti"


def odometry_scan(folder):
    points, _ = read_bin(folder / "odometry_00/velodyne/000000.bin")
    return points, *read_label(folder / "odometry_00/labels/000000.label", len(points))


def range_image_scan(folder):
    packed = (folder / "range_images_00/000020.npy.xz").read_bytes()
    image = np.load(io.BytesIO(lzma.decompress(packed))).reshape(-1, 6)
    image = image[image[:, 4] > 0]
    table = np.array([BY_NAME[name].id for name in TRAIN_IDS], dtype=np.uint8)
    return image[:, :3], table[image[:, 5].astype(int)], None


@pytest.mark.parametrize("read", [odometry_scan, range_image_scan])
def test_a_real_scan_becomes_a_layout_that_agrees_with_it(read):
    points, labels, instances = read(recordings())
    layout = layout_from_cloud(points, labels, instances=instances)
    scan = RangeImage.project(points, SENSOR, label=labels)
    good = agrees(scan, raycast(layout, SENSOR))
    for name, least in {"road": 0.9, "building": 0.8, "car": 0.55, "vegetation": 0.65}.items():
        assert good[scan.label == BY_NAME[name].id].mean() > least, name
    assert len(layout) < 1000


def test_arguments_that_no_scan_has() -> None:
    for name, value, said in (
        ("sensor_height", 10**400, "m; it must be finite"),
        ("sensor_height", math.nan, "nan m; it must be finite"),
        ("detail", [], "it must be one of fine, objects"),
        ("detail", "finer", "'finer'; it must be one of fine, objects"),
        ("weights", np.ones(2), "4 points need as many numbers over 0"),
        ("weights", np.zeros(4), "4 points need as many numbers over 0"),
    ):
        with pytest.raises(LayoutError, match=f"{name} (is|have) .*{re.escape(said)}"):
            layout_from_cloud(POINTS, LABELS, **{name: value})
    with pytest.raises(LayoutError, match="they must hold numbers"):
        layout_from_cloud(np.full((4, 3), "a"), LABELS)
