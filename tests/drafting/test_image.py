"""Pictures of known layouts become layouts: what was rendered is found where it was."""

import dataclasses
import json
import math

import numpy as np
import pytest
from PIL import ExifTags, Image
from scipy import ndimage

import rendered_pictures
from lidardraft import Layout, Primitive, layout_from_image
from lidardraft.drafting.picture import layout as picture_layout
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.errors import CheckpointError, LayoutError
from lidardraft.scene.check import check
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.detail.detail import detail

CAMERA = Pinhole.from_hfov(math.radians(80), 640, 400)


def shape(shape, center, size, label, id, **fields):
    return Primitive(shape=shape, center=center, size=size, label=label, id=id, **fields)


STREET = Layout(
    (
        shape("plane", (0, 0, -0.1), (300, 300, 0), "terrain", "terrain"),
        shape("plane", (0, 0, 0), (200, 10, 0), "road", "road"),
        shape("plane", (0, 7, 0.1), (200, 4, 0), "sidewalk", "sidewalk"),
        shape("box", (14, 3, 0.75), (4.4, 1.8, 1.5), "car", "car_1", yaw=0.2, instance=1),
        shape("box", (20, -3, 0.75), (3.9, 1.7, 1.5), "car", "car_2", yaw=-0.5, instance=2),
        shape("box", (35, 0, 1.6), (11, 2.5, 3.2), "bus", "bus_1", yaw=0.6, instance=3),
        shape("box", (12, 7, 0.9), (0.7, 0.6, 1.8), "person", "person_1", instance=4),
        shape("box", (30, 18, 4), (24, 8, 8), "building", "building"),
        shape("cylinder", (16, -6, 3), (0.3, 0.3, 6), "pole", "pole"),
        shape("ellipsoid", (22, -10, 3), (4, 4, 4), "vegetation", "tree.crown"),
        shape("cylinder", (22, -10, 0.7), (0.4, 0.4, 1.4), "trunk", "tree.trunk"),
    )
)
PICTURE = rendered_pictures.render(STREET, CAMERA)
KNOWN = {"depth": PICTURE.depth, "semantics": PICTURE.labels, "hfov": math.radians(80)}


def drafted(picture=PICTURE, **options):
    known = {"depth": picture.depth, "semantics": picture.labels, "hfov": math.radians(80)}
    return layout_from_image(picture.pixels, **(known | options))


def findings(layout):
    """Those of all checks, but of crowns, which are many ellipsoids that touch."""
    return [finding for finding in check(layout) if "vegetation" not in finding.ids[0]]


def assert_vehicles_are_recovered(layout, centre=0.5, degrees=5.0):
    found = layout.boxes()
    vehicles = [box for box in STREET.boxes() if box.label in ("car", "bus")]
    assert sorted(box.label for box in found if box.label in ("car", "bus")) == ["bus", "car", "car"]
    for box in vehicles:
        off, best = min((math.dist(f.center, box.center), f) for f in found if f.label == box.label)
        assert off < centre, (box, best)
        assert abs(math.degrees(math.remainder(best.yaw - box.yaw, math.pi))) < degrees, (box, best)


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (0.15, 0.0), (-0.05, 0.04)])
def test_vehicles_are_recovered_however_the_camera_is_tilted(pitch, roll):
    picture = rendered_pictures.render(STREET, CAMERA, pitch=pitch, roll=roll)
    layout = drafted(picture)
    assert_vehicles_are_recovered(layout)
    assert layout.provenance["scale"] == pytest.approx(1, abs=0.01)
    assert findings(layout) == []


@pytest.mark.parametrize("wrong", [0.5, 1.3, 40.0])
def test_the_height_of_the_camera_sets_the_scale(wrong):
    layout = drafted(depth=PICTURE.depth * wrong)
    assert_vehicles_are_recovered(layout)
    assert layout.provenance["scale"] == pytest.approx(1 / wrong, rel=0.01)


def test_without_a_height_depth_is_metres():
    picture = rendered_pictures.render(STREET, CAMERA, height=2.4)
    layout = drafted(picture, camera_height=None)
    assert_vehicles_are_recovered(layout)
    assert layout.provenance["sensor_height"] == pytest.approx(2.4, abs=0.02)


def test_all_classes_stand_where_they_were():
    layout = drafted()
    (pole,) = [p for p in layout if p.label == "pole"]
    np.testing.assert_allclose(pole.center[:2], (16, -6), atol=0.3)
    crown = np.array([p.center for p in layout if p.label == "vegetation"])
    np.testing.assert_allclose(np.median(crown, axis=0), (21, -10, 3), atol=1.2)
    facade = [p for p in layout if p.label == "building"]
    assert min(p.center[1] - p.size[1] / 2 for p in facade if abs(p.yaw) < 0.1) == pytest.approx(14, abs=0.3)
    assert {p.label for p in layout} >= {"road", "sidewalk", "terrain", "person", "trunk"}
    road = layout["road"]
    assert abs(road.center[2]) < 0.1


def test_things_that_touch_are_told_apart_by_their_numbers():
    """By masks, which take the class of most of their pixels."""
    cars = [
        shape("box", (14, y, 0.75), (4, 1.8, 1.5), "car", f"car_{k}", instance=k) for k, y in enumerate((1, -0.8), 1)
    ]
    picture = rendered_pictures.render(Layout((*STREET.primitives[:2], *cars)), CAMERA)
    assert len(drafted(picture).boxes()) == 1
    labels = picture.labels.copy()
    labels[:, 330:334][picture.instances[:, 330:334] > 0] = BY_NAME["bus"].id  # a network's error
    masks = np.stack([picture.instances == number for number in (1, 2)])
    for given in (masks, picture.instances, lambda _, __: (picture.labels, picture.instances)):
        boxes = drafted(picture, semantics=labels, masks=given).boxes()
        assert sorted((box.label, round(box.center[1], 1)) for box in boxes) == [("car", -0.8), ("car", 1.0)]


def test_masks_that_reach_over_the_edge_do_not_make_objects_as_deep_as_what_is_behind():
    """As polygons drawn by hand do, by a degree: what they hold of the wall is no part of the car."""
    car = shape("box", (12, 1, 0.75), (4.2, 1.8, 1.5), "car", "car_1", yaw=0.4, instance=1)
    wall = shape("box", (24, 0, 3), (1, 30, 6), "building", "wall")
    picture = rendered_pictures.render(Layout((*STREET.primitives[:2], car, wall)), CAMERA)
    mask = ndimage.binary_dilation(picture.instances == 1, iterations=6)
    (box,) = drafted(picture, masks=mask[None]).boxes()
    assert math.dist(box.center[:2], car.center[:2]) < 0.6
    np.testing.assert_allclose(box.size, car.size, atol=0.9)


def test_a_near_car_is_not_refuted_by_what_is_seen_over_its_hood():
    """Near points are thinned, and what is seen past them is not: the rays that points stand for are compared."""
    base = (*STREET.primitives[:2], shape("box", (40, 12, 4), (60, 6, 8), "building", "houses"))
    for x, y, degrees in ((5.8, -2.6, 73), (4.4, -0.1, 97), (5.5, -0.9, 119), (4.4, -2.0, 109)):
        place = {"center": (x, y, 0.75), "size": (4.4, 1.8, 1.5), "yaw": math.radians(degrees)}
        car = Primitive(shape="box", label="car", id="car_1", instance=1, **place)
        picture = rendered_pictures.render(detail(Layout((*base, car)), seed=0), CAMERA)
        cars = [box for box in drafted(picture).boxes() if box.label == "car"]
        assert len(cars) == 1, (x, y, degrees)
        assert math.dist(cars[0].center[:2], car.center[:2]) < 1.5


def test_intrinsics_may_be_a_file(tmp_path):
    matrix = [[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]]
    (tmp_path / "camera.json").write_text(json.dumps({"K": matrix}))
    layout = drafted(hfov=None, intrinsics=tmp_path / "camera.json")
    assert layout == drafted(hfov=None, intrinsics=matrix)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"masks": np.ones((2, 3, 4), bool)}, r"masks are bool \[2, 3, 4\]; a picture of that size needs"),
        ({"masks": np.ones((1, 400, 640))}, r"masks are float64 \[1, 400, 640\]"),
        ({"masks": np.ones((3, 3), int)}, r"masks has shape \[3, 3\]"),
        ({"masks": np.arange(400 * 640).reshape(400, 640)}, "there are 255999 masks; up to 1000"),
    ],
)
def test_masks_that_cannot_be(options, said):
    with pytest.raises(LayoutError, match=said):
        drafted(**options)


def test_the_camera_may_stand_anywhere():
    place = (1.5, -0.4, math.radians(90))
    layout, moved = drafted(), drafted(place=place)
    assert [p.id for p in moved] == [p.id for p in layout]
    car, there = layout["car_1"], moved["car_1"]
    np.testing.assert_allclose(there.center, (1.5 - car.center[1], -0.4 + car.center[0], car.center[2]))
    assert there.yaw == pytest.approx(car.yaw + math.radians(90))
    assert moved.coverage == pytest.approx([edge + math.radians(90) for edge in layout.coverage])


def test_depth_that_is_known_here_and_there_is_enough():
    """As a LiDAR measures it: one pixel in six."""
    some = np.random.default_rng(0).random(PICTURE.depth.shape) < 1 / 6
    assert_vehicles_are_recovered(drafted(depth=np.where(some, PICTURE.depth, 0)))


def test_what_networks_get_wrong_is_borne():
    layout = drafted(rendered_pictures.as_networks_give_it(PICTURE, 0))
    assert_vehicles_are_recovered(layout, centre=1.5, degrees=20)
    assert layout.provenance["scale"] == pytest.approx(1 / 1.12, rel=0.05)


def test_a_picture_larger_than_networks_see_gives_the_same_boxes(monkeypatch):
    """Callables are shown a picture of so many pixels at most; arrays are of the whole picture."""
    monkeypatch.setattr(picture_layout, "_LONGEST_SIDE", 640)
    camera = CAMERA.resized(800, 500)
    picture = rendered_pictures.render(STREET, camera)
    shown = []

    def depth(pixels):
        shown.append(pixels.shape)
        return rendered_pictures.render(STREET, CAMERA.resized(pixels.shape[1], pixels.shape[0])).depth

    layout = drafted(picture, depth=depth)
    assert shown == [(400, 640, 3)]
    assert_vehicles_are_recovered(layout)


def test_a_file_says_its_focal_length(tmp_path):
    exif = Image.Exif()
    film = 36 / 2 / math.tan(math.radians(40)) * math.hypot(36, 24) / math.hypot(36, 36 * 400 / 640)
    exif.get_ifd(ExifTags.IFD.Exif)[ExifTags.Base.FocalLengthIn35mmFilm] = round(film)
    Image.fromarray(PICTURE.pixels).save(tmp_path / "a.jpg", exif=exif)
    layout = layout_from_image(tmp_path / "a.jpg", depth=PICTURE.depth, semantics=PICTURE.labels)
    assert math.degrees(layout.provenance["hfov"]) == pytest.approx(80, abs=2)
    Image.fromarray(PICTURE.pixels).save(tmp_path / "b.png")
    with pytest.raises(LayoutError, match=r"b.png: the picture has no focal length; give hfov"):
        layout_from_image(tmp_path / "b.png", depth=PICTURE.depth, semantics=PICTURE.labels)


BROKEN = np.where(np.arange(640) == 7, np.nan, PICTURE.depth)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"depth": BROKEN}, "depth at row 0, column 7 is nan; it must be finite, and 0 if unknown"),
        ({"depth": -PICTURE.depth}, "depth at row .* is -"),
        ({"depth": PICTURE.depth[:-1]}, r"depth has shape \[399, 640\]; a picture of that size needs \[400, 640\]"),
        ({"depth": PICTURE.depth.astype(str)}, "depth holds <U"),
        ({"depth": 0 * PICTURE.depth}, "depth is 0 everywhere"),
        ({"semantics": PICTURE.labels[:, :9]}, r"semantics has shape \[400, 9\]"),
        ({"semantics": PICTURE.labels + 40}, "is 4.; it must be a class id, 0 to 20; other tables are read by"),
        ({"semantics": PICTURE.labels.astype(float)}, "semantics holds float64; it must hold whole numbers"),
        ({"semantics": 0 * PICTURE.labels}, "semantics is 0 everywhere"),
        ({"semantics": 0 * PICTURE.labels + BY_NAME["building"].id}, "no ground is visible"),
        ({"depth": np.full_like(PICTURE.depth, 9)}, "no plane of the ground"),
        ({"masks": -1 * PICTURE.instances.astype(int)}, "masks at row .* is -"),
        ({"hfov": 0.0}, "hfov is 0.0 rad"),
        ({"hfov": math.radians(200)}, r"hfov is 3.49.* rad \(200 degrees\)"),
        ({"intrinsics": np.eye(2)}, "give one of them"),
        ({"intrinsics": np.eye(2), "hfov": None}, r"intrinsics have shape \(2, 2\)"),
        ({"hfov": None}, "has no focal length"),
        ({"camera_height": 0}, "camera_height is 0 m; it must be 0.1 to 100"),
        ({"camera_height": math.nan}, "camera_height is nan"),
        ({"place": (1, 2)}, "place is"),
    ],
)
def test_what_cannot_be_is_one_clear_line(options, said):
    with pytest.raises(LayoutError, match=said) as raised:
        drafted(**options)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("pixels", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), np.uint8)])
def test_pixels_that_are_none(pixels):
    with pytest.raises(LayoutError, match=r"the picture is .*; it must be uint8"):
        layout_from_image(pixels, **KNOWN)


def test_a_picture_of_one_colour_is_told_before_networks_are_loaded():
    with pytest.raises(LayoutError, match="the picture is of one colour"):
        layout_from_image(np.full((400, 640, 3), 90, np.uint8), hfov=1.4)


def test_a_network_that_is_not_there_is_one_clear_line(tmp_path):
    pytest.importorskip("transformers")
    with pytest.raises(CheckpointError, match=r"semantic network '.*nowhere' cannot be loaded: ") as raised:
        layout_from_image(PICTURE.pixels, depth=PICTURE.depth, semantics=tmp_path / "nowhere", hfov=1.4)
    assert "\n" not in str(raised.value)


def test_provenance_says_what_was_asked():
    assert dataclasses.asdict(drafted())["provenance"] == {
        "source": "image",
        "depth": "array",
        "semantics": "array",
        "hfov": pytest.approx(math.radians(80)),
        "sensor_height": 1.65,
        "scale": pytest.approx(1, abs=0.01),
    }
