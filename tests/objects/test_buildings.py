"""Houses, blocks and sheds."""

import numpy as np
import pytest
from built_objects import all_vertices, build, placed, vertices

from lidardraft.objects.buildings import BALCONY, EAVES


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
