import numpy as np
import pytest

from lidardraft.drafting.solver.road_from_spec import road_from_spec
from lidardraft.drafting.solver.scene_spec import EGO_LANES, ObjectGroup, RoadSpec, SceneSpec
from lidardraft.errors import LayoutError
from lidardraft.scene.road import LEFT, RIGHT, Road


def road(kind: str = "straight", *groups: ObjectGroup, seed: int = 0, **fields: object) -> Road:
    spec = SceneSpec(road=RoadSpec(kind=kind, **fields), groups=groups)  # type: ignore[arg-type]
    return road_from_spec(spec, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(5))
def test_kinds_of_road(seed: int) -> None:
    assert road("straight", seed=seed).curvature == 0
    assert road("left-bend", seed=seed).curvature > 0 > road("right-bend", seed=seed).curvature
    assert road("crossroads", seed=seed).side_roads == (LEFT, RIGHT)
    assert len(road("t-junction", seed=seed).side_roads) == 1
    motorway = road("motorway", seed=seed)
    assert (motorway.sidewalk, motorway.junction, motorway.parking, motorway.median) == (0.0, None, 3.0, 4.0)
    assert road("motorway", ObjectGroup(kind="car", heading="across"), seed=seed).median == 0.0


def test_what_is_said_of_the_road_holds() -> None:
    assert road(lanes=3, sidewalk=False).lanes == 3
    assert road(lanes=3, sidewalk=False).sidewalk == 0
    assert road("motorway", sidewalk=True).sidewalk > 0


@pytest.mark.parametrize("seed", range(5))
def test_the_ego_drives_in_the_lane_that_is_said(seed: int) -> None:
    three = {name: road(lanes=3, seed=seed, ego_lane=name).ego_lane for name in EGO_LANES}
    assert three == {"left": 2, "middle": 1, "right": 0}
    assert road(seed=seed, ego_lane="left").lanes >= 2
    assert road(seed=seed, ego_lane="middle").lanes >= 3
    overtaken = ObjectGroup(kind="car", places=("right",), heading="with")
    assert road("straight", overtaken, seed=seed, ego_lane="left").ego_lane > 0
    with pytest.raises(LayoutError, match="road: ego_lane is 'slow'"):
        RoadSpec(ego_lane="slow")


def test_there_is_room_for_what_is_asked_for() -> None:
    parked = {kind: road("straight", ObjectGroup(kind=kind, heading="parked")) for kind in ("car", "truck", "person")}
    assert [parked[kind].parking for kind in ("car", "truck", "person")] == [2.2, 3.0, 0.0]
    assert road("straight", ObjectGroup(kind="car", heading="across")).junction is not None
    assert road("straight", ObjectGroup(kind="car", distance=(90.0, 90.0))).half_length == 105
    assert road("straight", ObjectGroup(kind="bus", count=4)).half_length > 90


@pytest.mark.parametrize("seed", range(12))
def test_lanes_that_are_open_leave_room_for_what_stands_at_a_distance_beside_them(seed: int) -> None:
    tree = ObjectGroup(kind="tree", places=("left",), distance=(10.0, 10.0))
    narrow = road("straight", tree, seed=seed)
    assert narrow.edge - narrow.lane(narrow.ego_lane) < 9.0


def test_a_parking_lot_ends_before_a_house() -> None:
    house = ObjectGroup(kind="house", places=("left",), distance=(20.0, 20.0))
    (right, left) = road("parking-lot", house).paved_areas
    assert right.across[0] == -24.0
    assert left.across[1] == 13.0
    (_, whole) = road("parking-lot", ObjectGroup(kind="tree", places=("left",), distance=(20.0, 20.0))).paved_areas
    assert whole.across[1] == 24.0


def test_further_than_a_sensor_sees() -> None:
    with pytest.raises(LayoutError, match="distance is 300 m; objects can be asked for up to 110 m away"):
        road("straight", ObjectGroup(kind="car", distance=(300.0, 300.0)))
