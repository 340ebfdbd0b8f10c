"""Cars: bodies and how often they are, sizes, what rays see in them."""

from collections import Counter

import numpy as np
import pytest
from built_objects import build, cast, placed, vertices

from lidardraft.objects.cars import BODIES, SHARES, sample_car, sample_paint
from lidardraft.objects.kinds import KINDS
from lidardraft.scene.materials import MATERIAL_BY_NAME


def test_every_body_is_a_kind_and_has_a_share():
    assert {name for name, kind in KINDS.items() if kind.labels == ("car",)} == set(BODIES) == set(SHARES)
    assert sum(SHARES.values()) == pytest.approx(1.0)


def test_cars_are_of_many_bodies_and_sizes():
    rng = np.random.default_rng(0)
    cars = [sample_car(rng) for _ in range(3000)]
    counts = Counter(name for name, _ in cars)
    for name, share in SHARES.items():
        assert counts[name] / len(cars) == pytest.approx(share, abs=0.03), name
    for name, size in cars:
        assert np.array(size) / BODIES[name].size == pytest.approx(np.ones(3), abs=0.101)


def test_lacquers_have_their_shares():
    rng = np.random.default_rng(0)
    counts = Counter(sample_paint(rng) for _ in range(3000))
    assert set(counts) == {"light-paint", "mid-paint", "dark-paint"} <= set(MATERIAL_BY_NAME)
    assert [counts[name] / 3000 for name in ("light-paint", "dark-paint", "mid-paint")] == pytest.approx(
        [0.2, 0.5, 0.3], abs=0.03
    )


def test_cars_of_one_body_share_their_meshes():
    one, two = (build(placed("suv", yaw=yaw), seed) for yaw, seed in ((0.0, 1), (1.0, 2)))
    meshes = [(a.mesh, b.mesh) for a, b in zip(one, two, strict=True) if a.mesh is not None]
    assert len(meshes) >= 6
    assert all(a is b for a, b in meshes)


@pytest.mark.parametrize("body", BODIES)
def test_plates_face_forward_and_back_at_both_ends(body: str):
    car = build(placed(body), 0)
    plates = [p for p in car if p.material == "retroreflector"]
    assert len(plates) == 1
    x = vertices(plates[0])[:, 0]
    half = BODIES[body].size[0] / 2
    assert x.max() == pytest.approx(half, abs=0.03)
    assert x.min() == pytest.approx(-half, abs=0.03)


def test_rays_go_into_a_car_and_some_through_it():
    car = build(placed("estate"), 0)
    rng = np.random.default_rng(1)
    z = rng.uniform(1.05, 1.2, 500)
    at = np.column_stack([rng.uniform(-1.6, 0.3, 500), np.zeros(500), z])
    found = cast(car, (-0.3, 30.0, 1.15), at)
    materials = [car[index].material if index >= 0 else "nothing" for index in found]
    for material in ("car-glass", "dark-cloth", "nothing"):
        assert materials.count(material) > 10, material
    assert 0.5 < materials.count("car-glass") / len(materials) < 0.92
