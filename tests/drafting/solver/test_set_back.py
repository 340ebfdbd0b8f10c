"""Distances from the kerb and the sidewalk are those of the near side."""

import math

import pytest

from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.scene.check import check
from spec_checker import broken


@pytest.mark.parametrize("kind", ["house", "tree", "wall", "person"])
@pytest.mark.parametrize("said", ["from_road", "from_sidewalk"])
def test_the_near_side_is_at_the_distance(kind: str, said: str) -> None:
    fields = {said: (4.0, 4.0)}
    spec = SceneSpec(road=RoadSpec(sidewalk=True), groups=(ObjectGroup(kind=kind, count=2, **fields),))  # type: ignore[arg-type]
    layout = layout_from_spec(spec, seed=0)
    assert broken(spec, layout) == []
    assert check(layout) == []


def test_what_drives_stands_before_the_kerb() -> None:
    spec = SceneSpec(groups=(ObjectGroup(kind="car", places=("right",), heading="parked", from_road=(0.3, 0.3)),))
    layout = layout_from_spec(spec, seed=0)
    (box,) = layout.boxes()
    assert abs(math.cos(box.yaw)) > 0.99
    assert broken(spec, layout) == []
