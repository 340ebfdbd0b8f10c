"""Relations in words."""

from lidardraft.drafting.solver.relation_text import relations
from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec


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
