"""Street furniture."""

import numpy as np
import pytest
from built_objects import build, cast, placed


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


def test_low_bins_are_round_and_high_ones_have_wheels():
    for variant in range(3):
        made = placed("bin", variant)
        bin = build(made, 0)
        assert [p.shape for p in bin] == (["cylinder"] if made.size[2] < 0.95 else ["mesh", "mesh"])


def test_most_benches_have_a_back():
    counts = [len(build(placed("bench"), seed)) for seed in range(60)]
    assert set(counts) == {3, 5}
    assert counts.count(5) > 35


def test_the_sleeve_of_a_cone_reflects_on_its_outside():
    cone = build(placed("cone"), 0)
    at = np.array([[0.0, 0.0, 0.3]])
    assert cone[cast(cone, (5.0, 0.0, 0.3), at)[0]].material == "retroreflector"
    assert cone[cast(cone, (5.0, 0.0, 0.45), np.array([[0.0, 0.0, 0.45]]))[0]].material == "plastic"


@pytest.mark.parametrize("kind", ["letterbox", "hydrant", "cabinet"])
def test_what_stands_on_the_sidewalk_reaches_into_the_ground(kind: str):
    lowest = min(p.center[2] - p.size[2] / 2 for p in build(placed(kind), 0))
    assert lowest == pytest.approx(-0.3, abs=0.06)
