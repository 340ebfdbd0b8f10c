"""What streets are made of can be moved, and nothing moves by itself."""

from collections import Counter

import numpy as np
import pytest

from lidardraft.errors import LayoutError
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.plan import plan_street
from lidardraft.streets.placement.street_mix import StreetMix

STREETS = 24
ONLY_URBAN = {name: 0.0 for name in DISTRICTS if name != "urban"}


def kinds(mix: StreetMix) -> Counter[str]:
    plans = [plan_street(np.random.default_rng([seed, 5]), 60.0, mix) for seed in range(STREETS)]
    return Counter(placed.kind for occupancy, _, _ in plans for placed in occupancy.objects)


def test_the_usual_mix_changes_no_district():
    for district in DISTRICTS.values():
        assert StreetMix().applied(district) == district


def test_districts_have_their_shares():
    rng = np.random.default_rng(0)
    mix = StreetMix(**ONLY_URBAN | {"motorway": 0.54, "urban": 0.18})
    counts = Counter(mix.sample_district(rng) for _ in range(2000))
    assert set(counts) == {"urban", "motorway"}
    assert counts["motorway"] / 2000 == pytest.approx(0.75, abs=0.04)
    names = {plan_street(np.random.default_rng(k), 60.0, StreetMix(**ONLY_URBAN))[2] for k in range(5)}
    assert names == {"urban"}


def test_there_is_more_of_what_is_asked_for():
    cars = ("hatchback", "saloon", "estate", "suv", "minivan")
    usual, more = kinds(StreetMix()), kinds(StreetMix(parked_cars=3.0, traffic=3.0, people=4.0, plants=0.2))
    assert sum(more[name] for name in cars) > 1.4 * sum(usual[name] for name in cars)
    assert more["person"] > 2 * usual["person"]
    assert more["tree"] < 0.7 * usual["tree"]


def test_nearly_nothing_of_a_kind_can_be_asked_for():
    usual, none = (kinds(StreetMix(**dict.fromkeys(("traffic", "people", "buildings"), k))) for k in (1.0, 0.0))
    assert none["person"] < 0.5 * usual["person"]  # some wait at stops or cross
    assert none["house"] + none["block"] < 0.3 * (usual["house"] + usual["block"])  # those along side roads
    assert none["truck"] + none["bus"] < 0.3 * (usual["truck"] + usual["bus"])


@pytest.mark.parametrize("value", [-1.0, float("inf"), float("nan")])
def test_an_amount_that_cannot_be_is_refused(value):
    with pytest.raises(LayoutError, match=r"people of the street mix is .*; it must be finite and 0 or more"):
        StreetMix(people=value)


def test_no_district_at_all_is_refused():
    with pytest.raises(LayoutError, match="the street mix has no district; one of residential"):
        StreetMix(**dict.fromkeys(DISTRICTS, 0.0))
