"""Buildings: bodies with their fronts to the road, fronts without a body."""

import math

import numpy as np
import pytest
from coarse_boxes import box, detailed, materials

from lidardraft import Layout, Primitive, Raycaster, detail
from lidardraft.scene.layout import primitive_mesh


def windows(parts: list[Primitive]) -> int:
    return sum(len(p.mesh.faces) // 2 for p in parts if p.material == "window" and p.mesh is not None)


def test_storeys_and_bays_are_of_real_size() -> None:
    low, high = (detailed(box("building", (20.0, 12.0, height), at=(0, 30, 0), id="block_1")) for height in (6.0, 18.0))
    assert 2.5 < windows(high) / windows(low) < 3.6
    assert windows(detailed(box("building", (40.0, 12.0, 6.0), at=(0, 30, 0), id="block_1"))) > 1.4 * windows(low)


def test_a_front_has_a_hundred_bays_at_most() -> None:
    low, high = (windows(detailed(box("building", (length, 0.5, 6.0)))) for length in (300.0, 6000.0))
    assert low == high > 100


@pytest.mark.parametrize("yaw", [0.0, math.pi / 2, math.pi, -math.pi / 2])
@pytest.mark.parametrize("y", [20.0, -20.0])
def test_the_front_of_a_house_is_towards_the_road(yaw: float, y: float) -> None:
    road = Primitive(shape="plane", center=(0, 0, 0), size=(120, 8, 0), label="road", id="road")
    house = box("building", (10.0, 9.0, 7.0), at=(30, y, 0), yaw=yaw, id="house_1")
    parts = detail(Layout(primitives=(road, house))).primitives
    door = next(p for p in parts if p.material == "wood" and p.shape == "box")
    assert (door.center[1] - y) * y < -3.0


@pytest.mark.parametrize("depth", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("turned", [False, True])
def test_a_front_without_a_body_has_recessed_windows_towards_the_ego(depth: float, turned: bool) -> None:
    size, yaw = ((9.0, depth, 6.0), 0.0) if not turned else ((depth, 9.0, 6.0), math.pi / 2)
    parts = detailed(box("building", size, at=(4.0, 12.0, 0.0), yaw=yaw), headed=False)
    assert materials(parts) == {"plaster", "window"}
    wall, panes = (
        np.concatenate([primitive_mesh(p).vertices for p in parts if p.material == m]) for m in ("plaster", "window")
    )
    assert wall[:, 1].min() >= 12.0 - depth / 2 - 1e-9
    assert 0.0 < panes[:, 1].mean() - wall[:, 1].min() <= depth + 1e-9
    hits = Raycaster(Layout(primitives=tuple(parts))).cast(
        np.zeros((40, 3)), np.column_stack([np.linspace(0.2, 7.8, 40), np.full(40, 12.0), np.full(40, 2.0)])
    )
    assert hits.valid.sum() > 37
    assert len({parts[k].material for k in hits.primitive[hits.valid]}) == 2


def test_fronts_that_a_clustering_saw_have_smaller_windows() -> None:
    def widths(headed: bool, seed: int) -> float:
        parts = detailed(box("building", (9.0, 0.3, 6.0), at=(4.0, 12.0, 0.0)), seed=seed, headed=headed)
        (panes,) = (primitive_mesh(p) for p in parts if p.material == "window")
        return float(np.ptp(panes.vertices[panes.faces], axis=1)[:, 0].mean())

    seen = {widths(False, seed) for seed in range(5)}
    assert len(seen) == 1
    assert max(seen) < 0.6 * min(widths(True, seed) for seed in range(5))


def test_what_is_too_small_for_a_window_stays() -> None:
    piece = box("building", (1.0, 0.3, 1.2))
    (part,) = detailed(piece, headed=False)
    assert (part.shape, part.size, part.id, part.material) == ("box", piece.size, piece.id, "plaster")
