"""Signs, billboards and sign bridges."""

import numpy as np
import pytest
from built_objects import all_vertices, build, cast, placed, vertices


def test_signs_reflect_to_the_front_and_are_grey_behind():
    for seed in range(12):
        made = placed("sign", seed % 2)
        primitives = build(made, seed)
        middle = np.array([[0.0, 0.0, made.size[2] - 0.2]])
        plates = [p for p in primitives if p.label == "traffic-sign"]
        for x, material in ((6.0, "retroreflector"), (-6.0, "sign-back")):
            assert plates[cast(plates, (x, 0.05, made.size[2] - 0.2), middle)[0]].material == material


def test_a_wide_sign_stands_on_two_posts():
    posts = [[p for p in build(placed("sign", v), 0) if p.label == "pole"] for v in (0, 2)]
    assert [len(row) for row in posts] == [1, 2]


def test_plates_have_the_outlines_of_the_road_code():
    corners = set()
    for seed in range(300):
        plates = [p for p in build(placed("sign", 0), seed) if p.material == "retroreflector"]
        corners |= {len(p.mesh.vertices) for p in plates}
    assert corners == {3, 4, 8, 12}


def test_two_plates_are_one_over_the_other():
    for seed in range(30):
        plates = [p for p in build(placed("sign", 1), seed) if p.material == "retroreflector"]
        assert len(plates) in (1, 2)
        if len(plates) == 2:
            upper, lower = plates
            assert upper.center[2] - upper.size[2] / 2 >= lower.center[2] + lower.size[2] / 2


def test_billboards_stand_on_one_post_or_two():
    posts = [sum(p.size[0] == pytest.approx(0.16) for p in build(placed("billboard", v), 0)) for v in (0, 1)]
    assert posts == [2, 1]


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
