"""Poles, furniture, walls, fences and plants."""

import math

import numpy as np
import pytest
from coarse_boxes import box, detailed, materials

from lidardraft.scene.layout import primitive_mesh


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
    parts = detailed(box("traffic-sign", size, at=(15, y, 2), yaw=yaw), headed=False)
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
        parts = detailed(box("traffic-sign", (0.1, 0.7, 0.7), at=(15, -5, 2), id=f"traffic-sign_{k}"), headed=False)
        face = next(p for p in parts if p.material == "retroreflector")
        assert face.mesh is not None
        assert len(face.mesh.vertices) == 4


def test_a_name_says_what_it_is() -> None:
    bench = detailed(box("other", (1.6, 0.5, 0.8), id="bench_1"))
    assert "wood" in materials(bench)
    bin = detailed(box("other", (0.6, 0.6, 1.1), id="bin_1"))
    assert "plastic" in materials(bin)


def test_extents_tell_a_bench_from_a_bin_from_a_shelter() -> None:
    assert "wood" in materials(detailed(box("other", (0.5, 1.6, 0.8))))
    assert "rubber" in materials(detailed(box("other", (0.6, 0.7, 1.1))))
    assert "glass" in materials(detailed(box("other", (4.0, 1.5, 2.5))))


def test_what_is_like_nothing_stays() -> None:
    given = box("other", (5.0, 4.0, 0.2))
    (part,) = detailed(given)
    assert (part.center, part.size, part.material) == (given.center, given.size, "plaster")


def test_a_name_of_another_class_says_nothing() -> None:
    (part,) = detailed(box("other", (5.0, 4.0, 0.2), id="car_1"))
    assert part.label == "other"


def test_segments_of_one_fence_are_alike() -> None:
    for seed in range(10):
        segments = [box("fence", (4.0, 0.1, 1.5), at=(15 + 4 * k, 3, 0), id=f"fence_1.{k + 1}") for k in range(4)]
        made = detailed(*segments, seed=seed)
        near = [{(p.shape, p.material) for p in made if abs(p.center[0] - 15 - 4 * k) < 2} for k in range(4)]
        assert near[0] == near[1] == near[2] == near[3]


def test_fences_are_seen_through_and_some_are_of_mesh() -> None:
    made = [detailed(box("fence", (12.0, 0.1, 1.5), id=f"fence_{k}")) for k in range(60)]
    meshes = sum(any(p.extinction for p in parts) for parts in made)
    assert 3 < meshes < 25
    assert {p.label for parts in made for p in parts} == {"fence"}
    assert {"wood", "metal"} <= {p.material for parts in made for p in parts}


def test_a_fence_along_the_width_of_its_box_stands_there() -> None:
    parts = detailed(box("fence", (0.1, 12.0, 1.5)))
    assert max(p.size[0] for p in parts) > 11.0
    assert len({p.material for p in parts}) == 1


def test_walls_have_plinths_or_copings_and_no_other_class() -> None:
    low, high = (detailed(box("wall", (12.0, 0.3, height))) for height in (0.8, 2.5))
    assert "paving" in materials(low)
    assert "concrete" in materials(high)
    assert {p.label for p in low + high} == {"wall"}


def test_a_thick_block_stays_a_block() -> None:
    (part,) = detailed(box("fence", (4.0, 3.0, 1.5)))
    assert (part.size, part.material) == ((4.0, 3.0, 1.5), "wood")


def test_the_fences_of_a_clustering_send_back_most_rays() -> None:
    pieces = [box("fence", (2.5, 0.3, 1.2), at=(15, 3 * k, 0), id=f"fence_{k}") for k in range(20)]
    made = detailed(*pieces, headed=False)
    assert {p.material for p in made} == {"wood"}
    assert not any(p.extinction for p in made)


def test_a_trunk_and_a_crown_become_one_tree() -> None:
    trunk = box("trunk", (0.5, 0.5, 3.0), id="tree_1.trunk", shape="cylinder")
    crown = box("vegetation", (4.0, 4.0, 5.0), at=(15.0, 3.0, 2.0), id="tree_1.crown", shape="ellipsoid")
    for seed in range(30):
        parts = detailed(trunk, crown, seed=seed)
        stem = parts[0]
        assert (stem.shape, stem.size[:2], stem.center[:2]) == ("cylinder", (0.5, 0.5), (15.0, 3.0))
        leaves = [p for p in parts if p.label == "vegetation"]
        assert all(p.extinction is not None for p in leaves)
        vertices = np.concatenate([primitive_mesh(p).vertices for p in leaves])
        assert vertices[:, 2].min() >= 2.0 - 1e-6
        assert vertices[:, 2].max() <= 7.0 + 1e-6
        assert max(p.extinction for p in leaves) > 0.2, "it is in leaf"


def test_a_trunk_and_a_crown_of_two_names_become_one_tree() -> None:
    trunk = box("trunk", (0.5, 0.5, 3.0), id="stem", shape="cylinder")
    crown = box("vegetation", (4.0, 4.0, 5.0), at=(15.0, 3.0, 2.0), id="leaves", shape="ellipsoid")
    parts = detailed(trunk, crown)
    boughs = [p for p in parts if p.label == "trunk"]
    assert len(boughs) > 1
    assert {p.id.split(".")[0] for p in boughs} == {"stem"}
    assert {p.id.split(".")[0] for p in parts if p.label == "vegetation"} == {"leaves"}
    (alone,) = [p for p in detailed(trunk, crown, headed=False) if p.label == "trunk"]
    assert alone.size == trunk.size


def test_a_bush_beside_a_trunk_is_not_its_crown() -> None:
    trunk = box("trunk", (0.5, 0.5, 3.0), id="stem", shape="cylinder")
    for at in ((16.5, 3.0, 2.0), (15.0, 3.0, 0.0), (15.0, 3.0, 4.0)):  # aside, on the ground, high over it
        bush = box("vegetation", (4.0, 4.0, 2.0), at=at, id="bush", shape="ellipsoid")
        (stem,) = [p for p in detailed(trunk, bush) if p.label == "trunk"]
        assert stem.size == trunk.size


def test_pieces_of_a_crown_become_a_medium_each() -> None:
    pieces = [
        box("vegetation", (1.0, 1.2, 0.9), at=(15, k, 2), id=f"vegetation_{k}", shape="ellipsoid") for k in range(5)
    ]
    made = detailed(*pieces, headed=False)
    assert [(p.id, p.shape, p.center, p.size) for p in made] == [(p.id, p.shape, p.center, p.size) for p in pieces]
    assert all(p.extinction for p in made)


def test_pieces_of_a_clustering_are_as_dense_whatever_their_size() -> None:
    sizes = ((0.6, 0.5, 0.4), (1.5, 1.6, 1.69), (2.0, 2.5, 1.8))
    pieces = [
        box("vegetation", s, at=(15, 4 * k, 2), id=f"vegetation_{k}", shape="ellipsoid") for k, s in enumerate(sizes)
    ]
    made = detailed(*pieces, headed=False)
    assert len(made) == 3
    paths = [p.extinction * min(p.size) for p in made if p.extinction is not None]
    assert paths == pytest.approx([paths[0]] * 3)
    assert paths[0] > 4.0


@pytest.mark.parametrize("shape", ["ellipsoid", "cylinder", "box"])
@pytest.mark.parametrize("size", [(0.02, 0.02, 0.02), (2.0, 2.0, 1.5), (20.0, 20.0, 0.3), (1.0, 8.0, 1.5)])
def test_foliage_of_any_shape_is_a_medium(shape: str, size: tuple[float, float, float]) -> None:
    parts = detailed(box("vegetation", size, shape=shape))
    assert all(p.extinction for p in parts)
    assert materials(parts) == {"foliage"}


def test_the_trunks_that_a_clustering_finds_stay() -> None:
    (part,) = detailed(box("trunk", (0.3, 0.3, 2.0), shape="cylinder"), headed=False)
    assert (part.size, part.material) == ((0.3, 0.3, 2.0), "bark")
