"""Poles, lamps, signs and signals."""

import math

import pytest
from coarse_boxes import box, detailed, materials


def test_a_sign_on_its_post_has_a_plate_that_reflects_back() -> None:
    post = box("pole", (0.08, 0.08, 2.4), id="traffic-sign_1.pole", shape="cylinder")
    plate = box("traffic-sign", (0.05, 0.7, 0.7), at=(14.92, 3.0, 1.7), id="traffic-sign_1.sign")
    parts = detailed(post, plate)
    assert {p.label for p in parts} == {"pole", "traffic-sign"}
    assert {"retroreflector", "sign-back"} <= materials(parts)
    assert max(p.center[2] + p.size[2] / 2 for p in parts) == pytest.approx(2.4, abs=0.06)


@pytest.mark.parametrize(("y", "towards_ego"), [(-5.0, True), (6.0, False)])
@pytest.mark.parametrize("turned", [False, True])
def test_the_face_of_a_clustered_plate_is_towards_who_drives_there(y: float, towards_ego: bool, turned: bool) -> None:
    size, yaw = ((0.1, 0.7, 0.7), 0.1) if not turned else ((0.7, 0.1, 0.7), math.pi / 2 + 0.1)
    parts = detailed(box("traffic-sign", size, at=(15, y, 2), yaw=yaw), source="point cloud")
    face, back = (next(p for p in parts if p.material == m).center[0] for m in ("retroreflector", "sign-back"))
    assert (face < back) == towards_ego
    assert {p.label for p in parts} == {"traffic-sign"}


def test_a_signal_on_its_post_has_a_housing_and_lenses() -> None:
    post = box("pole", (0.15, 0.15, 2.4), id="traffic-light_1.pole", shape="cylinder")
    light = box("traffic-light", (0.35, 0.35, 0.9), at=(15.0, 3.0, 2.4), id="traffic-light_1.light")
    parts = detailed(post, light)
    assert {p.label for p in parts} == {"pole", "traffic-light"}
    assert {"plastic", "glass"} <= materials(parts)


def test_a_lamp_hangs_on_an_arm_at_its_end() -> None:
    mast = box("pole", (0.18, 0.18, 7.0), id="street-light_1.mast", shape="cylinder")
    lamp = box("pole", (0.3, 1.2, 0.15), at=(15.0, 2.5, 6.95), id="street-light_1.lamp")
    parts = detailed(mast, lamp)
    luminaire = next(p for p in parts if p.material == "plastic")
    assert luminaire.center[1] - max(luminaire.size[:2]) / 2 == pytest.approx(2.5 - 0.6)
    assert {p.label for p in parts} == {"pole"}


@pytest.mark.parametrize("size", [(0.05, 0.05, 3.0), (0.01, 0.01, 0.02), (3.0, 3.0, 0.5), (0.3, 0.3, 30.0)])
@pytest.mark.parametrize("label", ["pole", "traffic-light"])
def test_cylinders_of_any_size_stay_where_they_are(label: str, size: tuple[float, float, float]) -> None:
    parts = detailed(box(label, size, shape="cylinder"))
    assert parts[0].shape == "cylinder"
    assert parts[0].size == pytest.approx(size)
    assert parts[0].center == pytest.approx((15.0, 3.0, size[2] / 2))


def test_a_clustered_plate_fills_what_was_seen() -> None:
    for k in range(12):
        parts = detailed(box("traffic-sign", (0.1, 0.7, 0.7), at=(15, -5, 2), id=f"traffic-sign_{k}"), source="cloud")
        face = next(p for p in parts if p.material == "retroreflector")
        assert face.mesh is not None
        assert len(face.mesh.vertices) == 4
