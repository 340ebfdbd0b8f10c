"""Bodies of vehicles: wheels on the ground, glazing within the cabin."""

import numpy as np
import pytest
from built_objects import build, placed, vertices

from lidardraft.objects.cars import BODIES
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
