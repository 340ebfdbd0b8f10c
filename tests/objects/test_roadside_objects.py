"""Fences, furniture, poles, signs and plants."""

from functools import partial

import numpy as np
import pytest
from built_objects import all_vertices, build, cast, extinction_along, placed, vertices

from lidardraft.objects import fences, plants
from lidardraft.objects.object_builder import built
from lidardraft.objects.plants import trunk_diameter


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


def test_a_dense_fence_has_close_palings_of_wood():
    made = placed("fence")
    for seed in range(20):
        parts = built(partial(fences.fence, dense=True), made, np.random.default_rng(seed))
        assert {p.material for p in parts} == {"wood"}
        palings = next(p for p in parts if p.size[1] == 0.0)
        assert palings.mesh is not None
        widths = np.ptp(palings.mesh.vertices.reshape(-1, 4, 3)[..., 0], axis=1) * palings.size[0]
        assert widths.sum() == pytest.approx(0.9 * made.size[0])


def test_a_shelter_is_open_to_its_left_and_behind_panes_elsewhere():
    made = placed("shelter")
    shelter = build(made, 1)
    panes = [p for p in shelter if p.material == "glass"]
    assert len(panes) == 3
    assert all(p.extinction is not None for p in panes)
    assert all(p.center[1] < 0.0 for p in panes)
    rng = np.random.default_rng(0)
    at = np.column_stack([rng.uniform(-1.0, 1.0, 200), np.full(200, -0.6), rng.uniform(1.0, 1.6, 200)])
    found = cast(shelter, (0.0, 6.0, 1.3), at)
    assert {shelter[index].material for index in found if index >= 0} <= {"glass", "metal"}


def test_the_sleeve_of_a_cone_reflects_on_its_outside():
    cone = build(placed("cone"), 0)
    at = np.array([[0.0, 0.0, 0.3]])
    assert cone[cast(cone, (5.0, 0.0, 0.3), at)[0]].material == "retroreflector"
    assert cone[cast(cone, (5.0, 0.0, 0.45), np.array([[0.0, 0.0, 0.45]]))[0]].material == "plastic"


@pytest.mark.parametrize("kind", ["letterbox", "hydrant", "cabinet"])
def test_what_stands_on_the_sidewalk_reaches_into_the_ground(kind: str):
    lowest = min(p.center[2] - p.size[2] / 2 for p in build(placed(kind), 0))
    assert lowest == pytest.approx(-0.3, abs=0.06)


def test_lenses_look_forward():
    for variant in (0, 1):
        primitives = build(placed("traffic_light", variant), 0)
        housings = [p for p in primitives if p.material == "plastic"]
        lenses = [p for p in primitives if p.material == "glass"]
        for housing, lens in zip(housings, lenses, strict=True):
            assert lens.center[0] > housing.center[0]


def test_signs_reflect_to_the_front_and_are_grey_behind():
    for seed in range(12):
        made = placed("sign", seed % 2)
        primitives = build(made, seed)
        middle = np.array([[0.0, 0.0, made.size[2] - 0.2]])
        plates = [p for p in primitives if p.label == "traffic-sign"]
        for x, material in ((6.0, "retroreflector"), (-6.0, "sign-back")):
            assert plates[cast(plates, (x, 0.05, made.size[2] - 0.2), middle)[0]].material == material


def test_plates_have_the_outlines_of_the_road_code():
    corners = set()
    for seed in range(300):
        plates = [p for p in build(placed("sign", 0), seed) if p.material == "retroreflector"]
        corners |= {len(p.mesh.vertices) for p in plates}
    assert corners == {3, 4, 8, 12}


def test_nothing_of_a_gantry_is_lower_than_its_clearance_between_the_posts():
    for seed in range(10):
        made = placed("gantry", seed)
        primitives = build(made, seed)
        boards = [p for p in primitives if p.label == "traffic-sign"]
        assert boards
        every = all_vertices(primitives)
        between = np.abs(every[:, 1]) < made.size[1] / 2 - 0.6
        ends = np.abs(every[:, 1]) >= made.size[1] / 2 - 1e-6
        assert np.sort(every[ends, 2])[0] < 0.0  # the posts reach into the ground
        truss = vertices(next(p for p in primitives if p.shape == "mesh" and p.label == "pole"))
        assert truss[:, 2].min() >= made.clearance - 1e-9
        assert between.any()
        assert every[between, 2].min() >= made.clearance - 1e-9


def test_plants_are_media_and_let_some_rays_through():
    for kind in ("tree", "bush", "hedge"):
        for seed in range(20):
            leaves = [p for p in build(placed(kind, seed % 2), seed) if p.label == "vegetation"]
            assert leaves
            assert all(p.extinction is not None and 0.0 < p.extinction < 25.0 for p in leaves)
            assert all(p.shape in ("ellipsoid", "box") for p in leaves)
    assert all(p.extinction is not None for p in build(placed("grass", 1), 0))


def test_trunks_are_solid_and_grow_with_the_height():
    for variant in range(4):
        made = placed("tree", variant)
        trunk = build(made, 0)[0]
        assert (trunk.label, trunk.shape, trunk.extinction) == ("trunk", "cylinder", None)
        assert trunk.size[0] == pytest.approx(trunk_diameter(made.size[2]))
        assert trunk.center[2] - trunk.size[2] / 2 == pytest.approx(-0.3)
    assert (trunk_diameter(4.5), trunk_diameter(13.0)) == pytest.approx((0.2, 0.39), abs=0.01)


def test_crowns_begin_at_the_clearance():
    for seed in range(30):
        made = placed("tree", seed)
        leaves = [p for p in build(made, seed) if p.label == "vegetation"]
        assert min(p.center[2] - p.size[2] / 2 for p in leaves) >= made.clearance - 0.02 * made.size[2]


def test_bare_trees_stop_a_fifth_of_the_light_and_are_few():
    densities = []
    for seed in range(400):
        made = placed("tree", 1)
        crown = made.size[2] - made.clearance
        densities.append(max(p.extinction or 0.0 for p in build(made, seed)) * crown)
    bare = [density for density in densities if density < 1.0]
    assert 0.02 < len(bare) / len(densities) < 0.13


def test_whether_a_tree_is_bare_can_be_said():
    made = placed("tree", 1)

    def light(seed: int, bare: bool | None) -> float:
        parts = built(partial(plants.tree, bare=bare), made, np.random.default_rng(seed))
        return max(p.extinction for p in parts if p.extinction is not None)

    assert all(light(seed, False) > 0.15 for seed in range(60))
    assert sum(light(seed, True) < 0.15 for seed in range(60)) > 50  # conifers are never bare
    assert light(3, None) == max(p.extinction for p in build(made, 3) if p.extinction is not None)
