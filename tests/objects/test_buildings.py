"""Houses, blocks and sheds, and their walls with windows."""

import numpy as np
import pytest
from built_objects import all_vertices, build, placed, vertices

from lidardraft.objects.buildings import EAVES
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


def test_walls_reach_under_the_ground():
    for kind in ("house", "block", "shed"):
        assert all_vertices(build(placed(kind), 0))[:, 2].min() == pytest.approx(-0.8, rel=0.2)  # stretched


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


def test_a_front_alone_is_that_of_a_building_without_its_door():
    wall, panes = front(4, 2, 0.45)
    assert len(panes.mesh.faces) == 2 * 4 * 2
    assert wall.size[0] == pytest.approx(1.0)
    assert (wall.center[2] + wall.size[2] / 2) * 2 * STOREY == pytest.approx(2 * STOREY)
    # panes lie behind the wall's face, y = 0, and ledges before it
    assert panes.center[1] == pytest.approx(RECESS - PANE)
    assert -0.1 < wall.center[1] - wall.size[1] / 2 < 0.0
