"""A street as annotators would mark it."""

import pytest
from scanned import OBJECTS, in_street, made

from lidardraft.streets.coarse.as_boxes import BoxStyle


def test_annotations_have_every_thing_at_its_place():
    table = in_street(made(BoxStyle()))
    row = {id: number for number, id in enumerate(table.ids)}
    for placed in OBJECTS:
        assert table.centers[row[placed.id], :2] == pytest.approx((placed.x, placed.y), abs=0.1)
        if placed.instance and placed.kind not in ("cyclist", "motorcyclist"):
            assert table.sizes[row[placed.id]] == pytest.approx(placed.size)
            assert table.yaws[row[placed.id]] == pytest.approx(placed.yaw)
            assert table.instances[row[placed.id]] == placed.instance
