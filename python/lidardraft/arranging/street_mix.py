"""The composition of streets: the frequency of each district, and the amount of objects in it."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from lidardraft.arranging.district import DISTRICTS, STREET_DISTRICTS, District
from lidardraft.errors import LayoutError


@dataclass(frozen=True, kw_only=True, slots=True)
class StreetMix:
    """The composition of streets; the defaults are those of docs/explanation/realism.md.

    `residential` to `roadworks` are the weights of the districts. The others are factors of the districts' own numbers:
    `parked_cars` along kerbs, `traffic` vehicles on the road, `riders` on two wheels, `people`, `buildings` (plots
    that are built on), `fences` in front of gardens, `plants` (thickets, wild trees and street trees). Objects with
    other causes stay: car parks, queues at lights, people at stops, corners of side roads. Probabilities end at 1.

    Raises `LayoutError` for a number that is negative or not finite, or shares that are all 0.
    """

    residential: float = DISTRICTS["residential"].share
    urban: float = DISTRICTS["urban"].share
    avenue: float = DISTRICTS["avenue"].share
    retail: float = DISTRICTS["retail"].share
    country: float = DISTRICTS["country"].share
    motorway: float = DISTRICTS["motorway"].share
    alley: float = 0.0
    village: float = 0.0
    industrial: float = 0.0
    forest: float = 0.0
    school: float = 0.0
    roadworks: float = 0.0
    parked_cars: float = 1.0
    traffic: float = 1.0
    riders: float = 1.0
    people: float = 1.0
    buildings: float = 1.0
    fences: float = 1.0
    plants: float = 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0.0 <= value < math.inf:
                raise LayoutError(f"{field.name} of the street mix is {value}; it must be finite and 0 or more")
        if not any(getattr(self, name) for name in STREET_DISTRICTS):
            raise LayoutError(
                f"the street mix has no district; one of {', '.join(STREET_DISTRICTS)} must be more than 0"
            )

    def sample_district(self, rng: np.random.Generator) -> str:
        """The name of a district."""
        shares = np.cumsum([getattr(self, name) for name in STREET_DISTRICTS])
        return list(STREET_DISTRICTS)[int(np.searchsorted(shares / shares[-1], rng.random(), side="right"))]


USUAL_MIX = StreetMix()


def only(name: str) -> dict[str, float]:
    """Shares of a `StreetMix` of one district."""
    return {each: float(each == name) for each in STREET_DISTRICTS}


def applied(mix: StreetMix, district: District) -> District:
    """The district with its numbers times the factors of the mix."""
    return replace(
        district,
        parked=min(district.parked * mix.parked_cars, 1.0),
        traffic_gap=district.traffic_gap / mix.traffic if mix.traffic > 0 else math.inf,
        riders=district.riders * mix.riders,
        people=district.people * mix.people,
        built=min(district.built * mix.buildings, 1.0),
        front_fences=min(district.front_fences * mix.fences, 1.0),
        street_trees=min(district.street_trees * mix.plants, 1.0),
        thickets=district.thickets * mix.plants,
        wild_trees=round(district.wild_trees * mix.plants),
    )
