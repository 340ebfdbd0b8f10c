"""Fences, walls and barriers."""

import numpy as np
import pytest
from built_objects import build, cast, extinction_along, placed

from lidardraft.objects import fences


def test_rays_pass_between_palings():
    fence = build(placed("fence", 1), 0)
    rng = np.random.default_rng(0)
    x = np.column_stack([rng.uniform(-6, 6, 600), np.zeros(600), np.full(600, 0.9)])
    open_share = np.mean([(cast(fence, (float(a), 8.0, 0.9), x[k : k + 1]) < 0)[0] for k, (a, _, _) in enumerate(x)])
    assert 0.05 < open_share < 0.9


def test_one_in_eight_rays_meets_a_wire():
    mesh = [p for p in build(placed("mesh_fence", 1), 0) if p.extinction is not None]
    assert len(mesh) == 1
    assert extinction_along(mesh[0]) == pytest.approx(0.12, abs=1e-6)


def test_walls_reach_into_the_ground():
    for kind in ("garden_wall", "wall"):
        for seed in range(8):
            lowest = min(p.center[2] - p.size[2] / 2 for p in build(placed(kind, seed), seed))
            assert lowest <= -0.2 + 1e-9


def test_some_garden_walls_carry_an_iron_fence_if_they_are_high_enough():
    def fenced(variant: int) -> list[bool]:
        return [any(p.label == "fence" for p in build(placed("garden_wall", variant), seed)) for seed in range(60)]

    assert not any(fenced(0))
    assert 5 < sum(fenced(1)) < 35


def test_barriers_are_of_steel_or_from_a_height_on_of_concrete():
    assert {p.material for p in build(placed("barrier", 2), 0)} == {"concrete"}
    assert "concrete" not in {p.material for p in build(placed("barrier", 0), 0)}
    rails = [sum(p.size[2] == pytest.approx(0.31) for p in build(placed("barrier", v), 0)) for v in (0, 1)]
    assert rails == [1, 2]  # a wide one has rails on both sides


def test_a_dense_fence_has_close_palings_of_wood():
    made = placed("fence")
    for seed in range(20):
        parts = fences.fence(made, np.random.default_rng(seed), dense=True)
        assert {p.material for p in parts} == {"wood"}
        palings = next(p for p in parts if p.size[1] == 0.0)
        assert palings.mesh is not None
        widths = np.ptp(palings.mesh.vertices.reshape(-1, 4, 3)[..., 0], axis=1) * palings.size[0]
        assert widths.sum() == pytest.approx(0.9 * made.size[0])
