"""Houses, blocks and sheds, and their walls with windows."""

import numpy as np
import pytest
from built_objects import all_vertices, build, placed, vertices

from lidardraft.objects.buildings import BALCONY, EAVES
from lidardraft.objects.facades import PLINTH, RECESS, STOREY, WINDOW_BAY, front, walls


def test_houses_have_windows_in_recesses():
    for seed in range(8):
        house = build(placed("house", seed), seed)
        panes = [p for p in house if p.material == "window"]
        assert panes
        wall, pane = house[0], panes[0]
        assert pane.size[1] < wall.size[1] - 0.1


def test_walls_end_at_the_eaves_and_roofs_overhang():
    for seed in range(12):
        made = placed("house", seed)
        length, width, height = made.size
        house = build(made, seed)
        wall = house[0]
        assert vertices(wall)[:, 2].max() == pytest.approx(made.clearance)
        roof = next(p for p in house if p.material in ("roof-tile", "metal"))
        corners = vertices(roof)
        assert corners[:, 2].min() == pytest.approx(made.clearance)
        assert corners[:, 2].max() == pytest.approx(height)
        assert np.ptp(corners[:, :2], axis=0) == pytest.approx((length + 2 * EAVES, width + 2 * EAVES))


def test_gables_end_under_the_roof():
    for seed in range(12):
        made = placed("house", seed)
        house = build(made, seed)
        # a gable is two triangles; it is as high as the roof is over the wall that it continues
        for gable in (p for p in house if p.mesh is not None and len(p.mesh.faces) == 2 and p.material != "window"):
            rise = made.size[2] - made.clearance
            along = gable.size[1] == made.size[1] and len(np.unique(np.round(vertices(gable)[:, 0], 6))) == 2
            span = made.size[1] if along else made.size[0]
            assert gable.size[2] == pytest.approx(rise * (1 - 2 * EAVES / (span + 2 * EAVES)))


def test_blocks_have_balconies_before_their_fronts_or_none():
    depths = set()
    for seed in range(40):
        made = placed("block", 1)
        front = -all_vertices(build(made, seed))[:, 1].min() - made.size[1] / 2
        depths.add(round(float(front), 2))
    assert max(depths) == pytest.approx(BALCONY)
    assert min(depths) < 0.1


def test_walls_reach_under_the_ground():
    for kind in ("house", "block", "shed"):
        assert all_vertices(build(placed(kind), 0))[:, 2].min() == pytest.approx(-0.8, rel=0.2)  # stretched


def test_wide_sheds_have_more_gates():
    gates = [sum(p.size[1] == pytest.approx(0.06) for p in build(placed("shed", v), 0)) for v in (0, 1)]
    assert gates == [1, 4]


PANE = 0.02  # m before its frame


@pytest.mark.parametrize(("bays", "deep", "storeys"), [(1, 1, 1), (4, 3, 2), (10, 5, 6)])
@pytest.mark.parametrize("blind", [False, True])
def test_a_facade_has_a_pane_for_each_window(bays: int, deep: int, storeys: int, blind: bool):
    _, panes = walls(bays, deep, storeys, 0.45, blind)
    front, back, side = bays * storeys - 1, max(1, bays // 2) * storeys, deep * storeys  # the door is no pane
    assert len(panes.mesh.faces) == 2 * (front + back + (0 if blind else 2 * side))


def test_walls_go_from_under_the_ground_to_the_roof():
    wall, panes = walls(4, 3, 2, 0.45, False)
    height = 2 * STOREY
    low, high = ((wall.center[2] + side * wall.size[2] / 2) * height for side in (-1, 1))
    assert low == pytest.approx(-PLINTH)
    assert high == pytest.approx(height)
    # panes of the front and the sides lie behind the wall, those of the back just before it
    depth = 3 * WINDOW_BAY
    y = (panes.center[1] + panes.mesh.vertices[:, 1] * panes.size[1]) * depth
    assert y.min() == pytest.approx(-depth / 2 + RECESS - PANE)
    assert y.max() == pytest.approx(depth / 2 + 0.03)


def test_a_larger_opening_has_more_glass():
    def area(opening: float) -> float:
        _, panes = walls(4, 3, 2, opening, True)
        corners = panes.mesh.vertices * panes.size * np.array([4 * WINDOW_BAY, 3 * WINDOW_BAY, 2 * STOREY])
        a, b, c = (corners[panes.mesh.faces[:, k]] for k in range(3))
        facing = np.abs(np.cross(b - a, c - a)[:, 1])
        return float(facing.sum())

    assert area(0.36) < area(0.45) < area(0.6)


def test_a_front_alone_is_that_of_a_building_without_its_door():
    wall, panes = front(4, 2, 0.45)
    assert len(panes.mesh.faces) == 2 * 4 * 2
    assert wall.size[0] == pytest.approx(1.0)
    assert (wall.center[2] + wall.size[2] / 2) * 2 * STOREY == pytest.approx(2 * STOREY)
    # panes lie behind the wall's face, y = 0, and ledges before it
    assert panes.center[1] == pytest.approx(RECESS - PANE)
    assert -0.1 < wall.center[1] - wall.size[1] / 2 < 0.0


def test_three_tenths_of_a_window_are_its_frame():
    _, panes = front(4, 2, 0.45)
    corners = (panes.mesh.vertices * panes.size * np.array([4 * WINDOW_BAY, 1.0, 2 * STOREY]))[panes.mesh.faces]
    glass = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 1]).sum() / 2
    assert glass == pytest.approx(8 * 0.7 * (0.45 * WINDOW_BAY) * (2.25 - 0.9))
