"""Sentences that are understood to the last word, and the layouts of them."""

import pytest

from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.text.layout import layout_from_text, spec_from_text
from lidardraft.scene.check import check
from lidardraft.scene.layout import Layout

PAPER = (
    "a vehicle driving on a road with vehicles both in front and behind, "
    "with trees and houses along both sides of the road"
)
SIDES = ("left", "right")


def group(kind: str, count: int | str = "some", *places: str, **fields: object) -> ObjectGroup:
    return ObjectGroup(kind=kind, count=count, places=places, **fields)  # type: ignore[arg-type]


# Sentence, road, groups: understood to the last word.
UNDERSTOOD: list[tuple[str, RoadSpec, list[ObjectGroup]]] = [
    (
        PAPER,
        RoadSpec(),
        [group("vehicle", "some", "front", "behind"), group("tree", "some", *SIDES), group("house", "some", *SIDES)],
    ),
    ("a car ahead", RoadSpec(), [group("car", 1, "front")]),
    (
        "two parked cars on the left and a bus behind",
        RoadSpec(),
        [group("car", 2, "left", heading="parked"), group("bus", 1, "behind")],
    ),
    (
        "a busy crossroads with pedestrians crossing",
        RoadSpec(kind="crossroads"),
        [group("person", heading="across"), group("vehicle", "many"), group("vehicle", heading="across")],
    ),
    (
        "a quiet residential street with houses, gardens, trees and parked cars on both sides",
        RoadSpec(),
        [
            *(group(kind, "some", *SIDES) for kind in ("house", "garden", "tree")),
            group("car", "some", *SIDES, heading="parked"),
        ],
    ),
    ("a t-intersection with three cars in front", RoadSpec(kind="t-junction"), [group("car", 3, "front")]),
    (
        "a motorway with three lanes and trucks on the right",
        RoadSpec(kind="motorway", lanes=3),
        [group("truck", "some", "right")],
    ),
    (
        "four people on the right sidewalk, a cyclist 20 m ahead",
        RoadSpec(sidewalk=True),
        [group("person", 4, "right", surface="sidewalk"), group("bicycle", 1, "front", distance=(20, 20))],
    ),
    ("heavy traffic", RoadSpec(), [group("vehicle", "many")]),
    ("an empty road", RoadSpec(), []),
    ("no traffic", RoadSpec(), []),
    (
        "a row of trees on the left, a wall on the right",
        RoadSpec(),
        [group("tree", "many", "left"), group("wall", 1, "right")],
    ),
    ("12 cars", RoadSpec(), [group("car", 12)]),
    ("a dozen automobiles and twenty-five people", RoadSpec(), [group("car", 12), group("person", 25)]),
    ("a car is driving behind me", RoadSpec(), [group("car", 1, "behind", heading="with")]),
    ("a car is driving on the road behind us", RoadSpec(), [group("car", 1, "behind", heading="with")]),
    (
        "On the left, two parked vans; on the right a hedge and a fence.",
        RoadSpec(),
        [group("van", 2, "left", heading="parked"), group("hedge", 1, "right"), group("fence", 1, "right")],
    ),
    (
        "trees every 10 metres along both sides of the road",
        RoadSpec(),
        [group("tree", "some", *SIDES, spacing=10)],
    ),
    (
        "lamp posts on both sides, a traffic light at the crossroads",
        RoadSpec(kind="crossroads"),
        [group("street-light", "some", *SIDES), group("traffic-light", 1)],
    ),
    (
        "a lorry 10 to 30 metres behind and a motorbike beside us",
        RoadSpec(),
        [group("truck", 1, "behind", distance=(10, 30)), group("motorcycle", 1, "beside")],
    ),
    ("residential street without trees, no parked cars", RoadSpec(), [group("house", "some", *SIDES)]),
    ("a residential street with no houses", RoadSpec(), []),
    ("houses on both sides, no houses on the right", RoadSpec(), [group("house", "some", "left")]),
    ("a man riding a bike on the left", RoadSpec(), [group("bicycle", 1, "left")]),
    (
        "we are driving on a highway with oncoming traffic",
        RoadSpec(kind="motorway"),
        [group("vehicle", heading="against")],
    ),
    (
        "a left-hand bend with bushes and traffic signs",
        RoadSpec(kind="left-bend"),
        [group("bush"), group("traffic-sign")],
    ),
    (
        "In front of us there is a bus, and behind us are three kids.",
        RoadSpec(),
        [group("bus", 1, "front"), group("person", 3, "behind")],
    ),
    ("cars in front, behind and on the left", RoadSpec(), [group("car", "some", "front", "behind", "left")]),
    (
        "a tree-lined city street with pedestrians walking along the road",
        RoadSpec(),
        [group("person"), group("building", "some", *SIDES), group("tree", "many", *SIDES)],
    ),
    ("children playing on the street", RoadSpec(), [group("person", surface="road")]),
    (
        "a car 20 m ahead and a car 30 m behind",
        RoadSpec(),
        [group("car", 1, "front", distance=(20, 20)), group("car", 1, "behind", distance=(30, 30))],
    ),
    (
        "a country road that curves to the right with a few trees, no houses or fences",
        RoadSpec(kind="right-bend", sidewalk=False),
        [group("tree", "few")],
    ),
    (
        "the ego vehicle on a four-lane road with cars parked along the road",
        RoadSpec(lanes=2),
        [group("car", "some", heading="parked")],
    ),
    (
        "bins and benches on the pavement, a couple of pedestrians nearby",
        RoadSpec(sidewalk=True),
        [group("bin", surface="sidewalk"), group("bench", surface="sidewalk"), group("person", 2, distance=(8, 18))],
    ),
    ("a taxi ahead on the left", RoadSpec(), [group("car", 1, "front-left")]),
]


@pytest.mark.parametrize(("sentence", "road", "groups"), UNDERSTOOD, ids=[row[0] for row in UNDERSTOOD])
def test_sentence_is_understood_to_the_last_word(sentence: str, road: RoadSpec, groups: list[ObjectGroup]) -> None:
    spec = spec_from_text(sentence, strict=True)
    assert spec.road == road
    assert list(spec.groups) == groups
    assert spec.not_understood == ()


@pytest.mark.parametrize("sentence", [row[0] for row in UNDERSTOOD])
def test_layouts_pass_every_check_and_survive_json(sentence: str) -> None:
    for seed in range(20):
        layout = layout_from_text(sentence, seed=seed)
        assert check(layout) == []
    assert Layout.from_json(layout.to_json()) == layout
    assert layout.provenance["sentence"] == sentence
    assert SceneSpec.from_dict(layout.provenance["spec"]) == spec_from_text(sentence)
