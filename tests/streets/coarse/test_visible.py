"""What a scan saw of the objects of a street."""

import numpy as np
from scanned import NAMES, OBJECTS, SCAN, STREET, VISIBLE

from lidardraft.scene.layout import object_of
from lidardraft.semantics import NUM_CLASSES
from lidardraft.streets.coarse.visible import owners_of


def test_every_primitive_has_its_object_and_the_ground_has_none():
    owners = owners_of(STREET.scene, OBJECTS)
    assert owners[-1] == -1
    for primitive, owner in zip(STREET.scene, owners[:-1].tolist(), strict=True):
        if owner >= 0:
            assert object_of(primitive) == OBJECTS[owner].id
        else:
            assert object_of(primitive) not in {placed.id for placed in OBJECTS}


def test_returns_are_counted_by_object_and_class():
    assert VISIBLE.returns.shape == (len(OBJECTS), NUM_CLASSES)
    on_ground = np.isin(SCAN.label, [NAMES.index(name) for name in ("road", "sidewalk", "terrain")])
    # plants of the ground are objects too, so all that is not ground is someone's
    assert VISIBLE.returns.sum() >= (SCAN.valid & ~on_ground).sum()
    cars = [number for number, placed in enumerate(OBJECTS) if placed.kind == "saloon"]
    assert VISIBLE.returns[cars][:, NAMES.index("building")].sum() == 0


def test_points_are_an_even_share_of_the_returns():
    points, keys = VISIBLE.points()
    kept = np.bincount(keys, minlength=len(OBJECTS) * NUM_CLASSES).reshape(-1, NUM_CLASSES)
    returns = VISIBLE.returns
    few = returns <= 200
    assert (kept[few] == returns[few]).all()
    some = (returns > 200) & (returns <= 1200)
    assert some.any()
    assert (np.abs(kept[some] / returns[some] - 1 / 4) < 0.06).all()
    # in the frame of the ego vehicle the sensor looks from its height over the road
    assert points[:, 2].min() > -3.0
