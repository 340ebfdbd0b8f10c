"""Specs: read, refused, and put into words."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.drafting.solver.scene_spec import (
    HEADINGS,
    MAX_COUNT,
    PLACES,
    ROADS,
    ObjectGroup,
    RoadSpec,
    SceneSpec,
    relations,
)
from lidardraft.errors import LidarDraftError
from lidardraft.json_fields import parse_object
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.sentence_kind import COUNTS

kinds_and_surfaces = st.sampled_from(sorted(SENTENCE_KINDS)).map(lambda kind: (kind, None)) | st.sampled_from(
    [("person", "road"), ("person", "sidewalk"), ("bicycle", "sidewalk"), ("car", "road"), ("bench", "sidewalk")]
)
groups = st.builds(
    lambda on, **fields: ObjectGroup(kind=on[0], surface=on[1], **fields),
    on=kinds_and_surfaces,
    count=st.integers(1, MAX_COUNT) | st.sampled_from(COUNTS),
    places=st.lists(st.sampled_from(PLACES), max_size=3, unique=True).map(tuple),
    heading=st.none() | st.sampled_from(HEADINGS),
    distance=st.none() | st.tuples(st.floats(0, 50), st.floats(50, 100)),
    spacing=st.none() | st.floats(0.1, 50),
)
roads = st.builds(
    RoadSpec,
    kind=st.sampled_from(ROADS),
    lanes=st.none() | st.integers(1, 6),
    sidewalk=st.none() | st.booleans(),
)


@settings(deadline=None)
@given(roads, st.lists(groups, max_size=4), st.lists(st.sampled_from(sorted(SENTENCE_KINDS)), max_size=2))
def test_json_round_trip(road: RoadSpec, wanted: list[ObjectGroup], absent: list[str]) -> None:
    spec = SceneSpec(road=road, groups=tuple(wanted), absent=tuple(absent), not_understood=("bus stop",))
    assert SceneSpec.from_dict(json.loads(json.dumps(spec.to_dict()))) == spec


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            '{"groups": [{"kind": "car", "distance": 9}]}',
            "car: distance is 9; it must be a range in metres",
        ),
        ('{"groups": [{"kind": "car", "size": [1, "b", 2]}]}', "car: size is [1, 'b', 2]; it must be three numbers"),
        ('{"groups": [{"kind": "car", "count": [1, 2, 3]}]}', "car: count is [1, 2, 3]; it must be 1 to 5000"),
        ('{"groups": [{"kind": "car", "places": "front"}]}', "car: places is 'front'; it must be a list"),
        ('{"road": {"sidewalk": 1}}', "road: sidewalk is 1; it must be true, false or null"),
        ('{"road": {"oncoming_lanes": 1}}', "road: oncoming_lanes is 1; it must be null, unless the road is two-way"),
        ('{"groups": [{"kind": "car", "distance": [1, 1' + "0" * 400 + "]}]}", "car: distance is [1, 10000"),
        ('{"sky": 1}', "unknown field 'sky'"),
        ('{"groups": [{"kind": "dragon"}]}', "group: kind is 'dragon'; it must be one of vehicle, car"),
        ('{"groups": [{"kind": "car", "count": 0}]}', "car: count is 0; it must be 1 to 5000, or one of few, some"),
        ('{"groups": [{"kind": "car", "count": "lots"}]}', "car: count is 'lots'; it must be one of few, some, many"),
        ('{"groups": [{"kind": "car", "surface": "sidewalk"}]}', "car: surface is 'sidewalk'; it must be one of road"),
        ('{"groups": [{"kind": "house", "surface": "road"}]}', "house: surface is 'road'; it must be one of none"),
        (
            '{"groups": [{"kind": "wall", "surface": "sidewalk"}]}',
            "wall: surface is 'sidewalk'; it must",
        ),
        ('{"groups": [{"kind": "car", "distance": [9, 3]}]}', "car: distance is [9, 3]; it must be a range in metres"),
        ('{"groups": [{"kind": "car", "spacing": 0}]}', "car: spacing is 0; it must be 0.1 m or more"),
        ('{"road": {"kind": "river"}}', "road: kind is 'river'; it must be one of straight"),
        ('{"road": {"lanes": 7}}', "road: lanes is 7; it must be 1 to 6 in each direction"),
        ('{"road": {"sidewalk": "wide"}}', "road: sidewalk is 'wide'; it must be true, false or null"),
        ('{"groups": [{"kind": "car", "at_junction": "no"}]}', "car: at_junction is 'no'"),
        ('{"groups": [{"kind": "car", "words": 5}]}', "car: words is 5; it must be text"),
        ('{"not_understood": [null]}', "not_understood: part is None; it must be text"),
        ('{"absent": ["sky"]}', "absent: kind is 'sky'; it must be one of vehicle"),
    ],
)
def test_wrong_specs_name_what_is_wrong(text: str, message: str) -> None:
    with pytest.raises(LidarDraftError) as caught:
        SceneSpec.from_dict(parse_object(text))
    assert message in str(caught.value)


def test_every_relation_of_a_spec_is_a_line() -> None:
    spec = SceneSpec(
        road=RoadSpec(kind="motorway", lanes=3, sidewalk=False),
        groups=(
            ObjectGroup(kind="car", count=2, places=("front-left", "behind"), heading="parked", distance=(10, 20)),
            ObjectGroup(kind="person", count=(2, 3), relation="in-front-of", references=(0,), size=(None, None, 1.8)),
        ),
        absent=("tree",),
    )
    assert relations(spec) == [
        "road: motorway",
        "road: 3 lanes each way",
        "road: no sidewalks",
        "car: 2, in front, on the left, 10 to 20 m away, parked",
        "car: 2, behind, 10 to 20 m away, parked",
        "person: 2 to 3, in front of car, 1.8 m high",
        "tree: none",
    ]
