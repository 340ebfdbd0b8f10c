"""Cars, trucks, buses and trams: bodies, wheels, glazing, loads, and what rays see in them."""

from collections import Counter

import numpy as np
import pytest
from built_objects import build, cast, placed, vertices

from lidardraft.objects.cars import BODIES, SHARES, sample_car
from lidardraft.objects.kinds import KINDS
from lidardraft.objects.vehicle_bodies import GLAZING, body_mesh, wheel_meshes

WHEELED = (*BODIES, "truck", "trailer_truck", "bus")


@pytest.mark.parametrize("kind", WHEELED)
def test_wheels_stand_on_the_ground_within_the_width(kind: str):
    for seed in range(6):
        made = placed(kind, seed)
        tyres = [p for p in build(made, seed) if p.material == "rubber"]
        assert tyres
        axles = set()
        for tyre in tyres:
            assert tyre.center[2] - tyre.size[2] / 2 == pytest.approx(0.0, abs=1e-6)
            assert tyre.size[1] <= made.size[1] + 1e-9
            assert 0.5 < tyre.size[2] < 1.1
            lowest = vertices(tyre)[vertices(tyre)[:, 2] < 0.01]
            assert lowest[:, 1].max() == pytest.approx(-lowest[:, 1].min()) == pytest.approx(made.size[1] / 2, rel=0.03)
            axles |= set((lowest[:, 0] / 0.6).round().tolist())
        assert len(axles) >= 2


@pytest.mark.parametrize("name", BODIES)
def test_a_body_fills_its_extents_and_is_alike_on_both_sides(name: str):
    mesh = body_mesh(BODIES[name])
    low, high = np.array(mesh.center) - np.array(mesh.size) / 2, np.array(mesh.center) + np.array(mesh.size) / 2
    assert low[:2] == pytest.approx((-0.5, -0.5), abs=1e-6)
    assert high == pytest.approx((0.5, 0.5, 1.0), abs=1e-6)
    assert 0.0 < low[2] * BODIES[name].size[2] <= BODIES[name].clearance + 1e-9
    places = {tuple(row) for row in np.round(mesh.mesh.vertices, 6).tolist()}
    assert {(x, -y, z) for x, y, z in places} == places


def test_wheels_are_round_whatever_the_proportions_of_the_vehicle():
    for body in BODIES.values():
        tyres, _ = wheel_meshes(body)
        assert tyres.size[2] * body.size[2] == pytest.approx(body.wheel_diameter)
        span = (body.axles[-1] - body.axles[0]) * body.size[0] + body.wheel_diameter
        assert tyres.size[0] * body.size[0] == pytest.approx(span, rel=0.01)


@pytest.mark.parametrize("name", BODIES)
def test_glazing_is_a_medium_within_the_cabin(name: str):
    body = BODIES[name]
    glazing = [p for p in build(placed(name), 0) if p.material == "car-glass"]
    assert 1 <= len(glazing) <= 2
    for p in glazing:
        assert p.extinction == GLAZING
        assert p.center[2] - p.size[2] / 2 >= body.belt_line * body.size[2] - 1e-9
        assert p.center[2] + p.size[2] / 2 <= body.size[2]
        assert p.size[1] < body.size[1]


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


def test_cars_of_one_body_share_their_meshes():
    one, two = (build(placed("suv", yaw=yaw), seed) for yaw, seed in ((0.0, 1), (1.0, 2)))
    meshes = [(a.mesh, b.mesh) for a, b in zip(one, two, strict=True) if a.mesh is not None]
    assert len(meshes) >= 6
    assert all(a is b for a, b in meshes)


def test_rays_end_at_the_windows_of_a_car_or_go_through_it():
    car = build(placed("estate"), 0)
    rng = np.random.default_rng(1)
    z = rng.uniform(1.05, 1.2, 6000)
    at = np.column_stack([rng.uniform(-1.6, 0.3, 6000), np.zeros(6000), z])
    found = cast(car, (-0.3, 30.0, 1.15), at)
    materials = [car[index].material if index >= 0 else "nothing" for index in found]
    for material in ("car-glass", "nothing"):
        assert materials.count(material) > 2, material
    assert 0.5 < materials.count("car-glass") / len(materials) < 0.99


def test_all_loads_are_carried_and_end_where_the_truck_does():
    shapes = set()
    for seed in range(120):
        made = placed("trailer_truck", seed)
        load = build(made, seed)
        every = np.concatenate([vertices(p) for p in load])
        assert every[:, 2].max() <= made.size[2] + 0.1
        shapes |= {p.material for p in load}
    # tarpaulins, tanks of steel, heaps of a tipper, the floor of a flatbed
    assert {"cloth", "chrome", "gravel", "wood", "light-paint", "mid-paint"} <= shapes


def test_rays_through_the_windows_end_at_glass_or_seats_or_go_through():
    bus = build(placed("bus", 1), 0)
    rng = np.random.default_rng(0)
    at = np.column_stack([rng.uniform(-4.0, 4.0, 6000), np.zeros(6000), rng.uniform(1.6, 1.8, 6000)])
    found = cast(bus, (0.0, 40.0, 1.7), at)
    materials = [bus[index].material if index >= 0 else "nothing" for index in found]
    assert materials.count("car-glass") > 3000
    assert materials.count("dark-cloth") > 0
    assert {p.label for p in bus} == {"bus"}
