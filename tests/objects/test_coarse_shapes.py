"""The coarse shapes of objects."""

import numpy as np
import pytest

from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.objects.kinds import kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.streets.street import make_street

# Every kind of thing with the extents it usually has, and what is drawn of it.
KINDS = {
    "saloon": ((4.6, 1.8, 1.5), {"car"}),
    "truck": ((8.0, 2.5, 3.3), {"truck"}),
    "trailer_truck": ((16.5, 2.55, 4.0), {"truck"}),
    "bus": ((12.0, 2.55, 3.1), {"bus"}),
    "tram": ((28.0, 2.4, 3.5), {"train"}),
    "person": ((0.6, 0.5, 1.8), {"person"}),
    "cyclist": ((1.8, 0.6, 1.7), {"rider", "bicycle"}),
    "motorcyclist": ((2.1, 0.8, 1.6), {"rider", "motorcycle"}),
    "house": ((12.0, 9.0, 9.0), {"building"}),
    "tree": ((5.0, 5.0, 9.0), {"trunk", "vegetation"}),
    "hedge": ((6.0, 1.0, 1.6), {"vegetation"}),
    "barrier": ((4.0, 0.3, 0.8), {"fence"}),
    "mesh_fence": ((4.0, 0.05, 1.5), {"fence"}),
    "wall": ((8.0, 0.3, 3.0), {"wall"}),
    "gantry": ((0.4, 14.0, 7.0), {"pole", "traffic-sign"}),
    "billboard": ((0.3, 4.0, 4.0), {"other"}),
    "grass": ((5.0, 3.0, 0.2), set()),
    **dict.fromkeys(("shelter", "cone", "letterbox", "hydrant", "cabinet"), ((1.0, 0.5, 1.2), {"other"})),
}


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_an_layout_shape_fills_the_extents_of_its_thing(kind: str):
    size, classes = KINDS[kind]
    clearance = {"house": 6.0, "tree": 2.5, "gantry": 5.0, "billboard": 1.5}.get(kind, 0.0)
    placed = PlacedObject(
        kind=kind, id=kind, x=3.0, y=1.0, z=0.0, level=0.0, yaw=0.0, size=size, clearance=clearance, instance=4
    )
    marks = kind_of(kind).coarse(placed)
    assert {mark.label for mark in marks} == classes
    assert (kind == "grass") == (not marks)
    for lobes in range(1, MOST_LOBES + 1):
        chosen = [mark for mark in marks if mark.lobes in (0, lobes)]
        if not chosen or kind in ("cyclist", "motorcyclist", "house"):
            continue
        low = np.min([np.subtract(mark.center, np.array(mark.size) / 2) for mark in chosen], axis=0)
        high = np.max([np.add(mark.center, np.array(mark.size) / 2) for mark in chosen], axis=0)
        # the lobes of a crown lie around its middle, not all the way to every side
        slack = 0.15 * np.array(size) * (lobes > 1 and kind == "tree")
        assert (low >= [-size[0] / 2 - 1e-9, -size[1] / 2 - 1e-9, -1e-9]).all()
        assert (high <= [size[0] / 2 + 1e-9, size[1] / 2 + 1e-9, size[2] + 1e-9]).all()
        assert (high - low >= size - slack - 1e-9).all()


def test_a_rider_sits_on_what_is_ridden():
    objects = [t for seed in range(12) for t in make_street(seed).occupancy.objects if t.kind == "cyclist"]
    rider, bicycle = kind_of("cyclist").coarse(objects[0])
    assert (rider.label, bicycle.label) == ("rider", "bicycle")
    assert (rider.instance_offset, bicycle.instance_offset) == (0, 1)
    assert rider.center[2] > bicycle.center[2]
    # the knees and feet belong to what is ridden
    assert 0.6 < rider.center[2] - rider.size[2] / 2 < bicycle.size[2]
