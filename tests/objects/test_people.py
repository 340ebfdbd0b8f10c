"""People, riders and what they ride."""

import numpy as np
import pytest
from built_objects import all_vertices, build, cast, placed, vertices

from lidardraft.objects.human_body import bent_joint, hanging
from lidardraft.objects.kinds import KINDS


@pytest.mark.parametrize("variant", range(4))
def test_a_person_fills_the_stature_and_walks(variant: int):
    made = placed("person", variant)
    strides = []
    for seed in range(40):
        primitives = build(made, seed)
        every = all_vertices(primitives)
        assert every[:, 2].max() == pytest.approx(made.size[2], abs=0.01)
        assert every[:, 2].min() == pytest.approx(0.0, abs=0.02)
        strides.append(np.ptp(vertices(primitives[0])[:, 0]))
    # the feet of one who stands are side by side; of one who walks they meet and part
    apart = max(strides) - min(strides)
    assert (apart < 0.02) if made.size[0] <= 0.3 else (apart > 0.1 * made.size[2])


def test_a_childs_head_is_larger_against_the_stature():
    def share(variant: int) -> float:
        made = placed("person", variant)
        return next(p for p in build(made, 0) if p.material == "skin").size[2] / made.size[2]

    assert share(0) > share(1) > share(2) == pytest.approx(0.13)


@pytest.mark.parametrize("knee", [True, False])
def test_a_joint_keeps_the_lengths_of_its_segments(knee: bool):
    rng = np.random.default_rng(0)
    for _ in range(50):
        start = rng.uniform(-1, 1, 3)
        end = start + rng.uniform(0.2, 0.45) * hanging(rng.uniform(-1.0, 1.0))
        joint = bent_joint(start, end, 0.25, 0.24, knee=knee)
        assert np.linalg.norm(joint - start) == pytest.approx(0.25)
        assert np.linalg.norm(joint - end) == pytest.approx(0.24)
        off = joint - (start + end) / 2
        assert off[0] > 0 if knee else off[2] < 0


@pytest.mark.parametrize("kind", ["cyclist", "motorcyclist"])
def test_a_rider_touches_the_vehicle(kind: str):
    for seed in range(10):
        primitives = build(placed(kind, seed), seed)
        rider, vehicle = (all_vertices([p for p in primitives if (p.label == "rider") is who]) for who in (True, False))
        apart = np.linalg.norm(rider[:, None] - vehicle[None], axis=2)
        hands = rider[:, 0] > 0.25
        assert apart[hands].min() < 0.12
        assert rider[:, 2].min() > 0.0


def test_uncounted_riders_stay_uncounted():
    made = placed("cyclist")
    primitives = KINDS["cyclist"].build(type(made)(**{**fields_of(made), "instance": 0}), np.random.default_rng(0))
    assert {p.instance for p in primitives} == {0}


def fields_of(made: object) -> dict:
    return {name: getattr(made, name) for name in type(made).__dataclass_fields__}


def test_rays_pass_between_the_spokes():
    bicycle = build(placed("bicycle"), 3)
    rng = np.random.default_rng(0)
    at = np.column_stack([rng.uniform(0.48, 0.62, 400), np.zeros(400), rng.uniform(0.2, 0.28, 400)])
    assert 0.7 < (cast(bicycle, (0.55, 8.0, 0.3), at) < 0).mean() < 1.0


def test_a_cyclist_is_as_high_as_the_extents_say():
    for seed in range(10):
        made = placed("cyclist", seed)
        rider = [p for p in build(made, seed) if p.label == "rider"]
        assert all_vertices(rider)[:, 2].max() == pytest.approx(made.size[2], abs=0.12)
