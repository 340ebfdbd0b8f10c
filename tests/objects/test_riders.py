"""Riders: an instance of their own, on the saddle, hands and feet where the vehicle has them."""

import numpy as np
import pytest
from built_objects import all_vertices, build, placed

from lidardraft.objects.kinds import KINDS


@pytest.mark.parametrize("kind", ["cyclist", "motorcyclist"])
def test_a_rider_and_what_is_ridden_are_two_instances(kind: str):
    _, ridden = KINDS[kind].labels
    for seed in range(10):
        primitives = build(placed(kind, seed), seed)
        assert {(p.label, p.instance) for p in primitives} == {("rider", 5), (ridden, 6)}


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
