"""What placement keeps free for an object holds the object."""

import numpy as np
import pytest
from built_objects import build, placed, vertices

from lidardraft.objects.kinds import KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_every_detail_lies_in_a_box_of_its_object(kind: str):
    for seed in range(12):
        made = placed(kind, seed)
        boxes = np.array(KINDS[kind].boxes(made.size, made.clearance))
        # mirrors, chimneys, tips of leaves and of limbs stick out
        slack = 0.16 + 0.02 * max(made.size[:2]) + 0.1 * (kind in ("tree", "person"))
        low = np.column_stack([boxes[:, :2] - boxes[:, 2:4] / 2 - slack, boxes[:, 4] - 1.3])
        high = np.column_stack([boxes[:, :2] + boxes[:, 2:4] / 2 + slack, boxes[:, 5] + 0.8])
        for p in build(made, seed):
            corners = vertices(p)
            inside = ((corners[:, None] >= low) & (corners[:, None] <= high)).all(axis=2).any(axis=1)
            assert inside.all(), (p.id, corners[~inside][0])


def test_something_may_stand_under_a_crown_a_board_and_a_gantry():
    for kind in ("tree", "sign", "billboard", "gantry"):
        made = placed(kind, 1)
        boxes = KINDS[kind].boxes(made.size, made.clearance)
        low = [box for box in boxes if box.bottom < made.clearance]
        assert sum(box.length * box.width for box in low) < 0.6 * made.size[0] * made.size[1]
        assert max(box.top for box in boxes) == made.size[2]


def test_the_arm_of_a_lamp_is_on_its_left():
    post, arm = KINDS["lamp"].boxes((0.2, 0.2, 8.0), 0.0)
    assert post.y == 0.0
    assert arm.y - arm.width / 2 <= 0.0 < arm.y
    assert arm.bottom > 7.0
