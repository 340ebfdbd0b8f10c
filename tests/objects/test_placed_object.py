"""An object before it has a shape."""

from dataclasses import FrozenInstanceError

import pytest

from lidardraft.objects.kinds import kind_of
from lidardraft.objects.placed_object import PlacedObject


def test_every_builder_takes_it_and_none_can_change_it():
    placed = PlacedObject(kind="bin", id="bin_1", x=1.0, y=2.0, z=0.1, level=0.0, yaw=0.3, size=(0.6, 0.6, 1.0))
    assert placed.instance == 0
    assert placed.clearance == 0.0
    assert kind_of(placed.kind).coarse(placed)[0].size == placed.size
    with pytest.raises(FrozenInstanceError):
        placed.yaw = 0.0  # type: ignore[misc]
