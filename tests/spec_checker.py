"""Which relations of a spec do not hold in a layout, seen from the layout alone: nothing of the solver is used."""

import math

import numpy as np

from lidardraft.drafting.solver.scene_spec import ObjectGroup, SceneSpec, split_place
from lidardraft.scene.check import objects
from lidardraft.scene.layout import Layout
from lidardraft.scene.road import Road

EGO_HALF = 2.25  # m


class Placed:
    """An object of a layout, from its primitives: its box on the ground, in the frame of the road."""

    def __init__(self, parts, road: Road) -> None:
        body = max(parts, key=lambda part: part.size[0] * part.size[1])
        self.yaw = body.yaw
        corners = []
        for part in parts:
            cos, sin = math.cos(part.yaw), math.sin(part.yaw)
            for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                dx, dy = x * part.size[0] / 2, y * part.size[1] / 2
                corners.append((part.center[0] + cos * dx - sin * dy, part.center[1] + sin * dx + cos * dy))
        self.corners = np.array(corners)
        self.middle = (self.corners.min(axis=0) + self.corners.max(axis=0)) / 2
        frame = np.array([road.along_across(float(x), float(y)) for x, y in corners])
        self.along, self.across = (frame.min(axis=0) + frame.max(axis=0)) / 2
        self.low, self.high = frame.min(axis=0), frame.max(axis=0)
        self.heading = self.yaw - road.at(self.along, self.across)[2]
        self.size = tuple(
            max(part.center[axis] + part.size[axis] / 2 for part in parts) if axis == 2 else body.size[axis]
            for axis in range(3)
        )
        base = min(parts, key=lambda part: part.center[2] - part.size[2] / 2)
        self.foot = road.along_across(*base.center[:2])[1]  # across, of what stands on the ground
        standing = [part for part in parts if part.center[2] - part.size[2] / 2 < 0.6]
        foot = [across for part in standing for across in _reach(part, road)] or [self.foot]
        self.foot_low, self.foot_high = min(foot), max(foot)
        self.height = max(part.center[2] + part.size[2] / 2 for part in parts) - base.center[2] + base.size[2] / 2

    def gap(self, other: "Placed") -> float:
        """Metres between the two boxes along the axes of the road."""
        apart = np.maximum(np.maximum(self.low - other.high, other.low - self.high), 0.0)
        return float(np.hypot(*apart))


def _reach(part, road: Road) -> list[float]:
    """How far a part reaches across the road."""
    along, across = road.along_across(*part.center[:2])
    heading = part.yaw - road.at(along, across)[2]
    half = (abs(math.sin(heading)) * part.size[0] + abs(math.cos(heading)) * part.size[1]) / 2
    return [across - half, across + half]


def road_of(layout: Layout) -> Road:
    """The road of a layout made from a spec."""
    assert layout.roads is not None
    assert layout.roads.street is not None
    return layout.roads.street.road


def broken(spec: SceneSpec, layout: Layout) -> list[str]:
    """The relations that do not hold, in words."""
    road, parts = road_of(layout), objects(layout)
    placed: dict[int, list[Placed]] = {number: [] for number in range(len(spec.groups))}
    for name, number in layout.provenance["objects"].items():
        placed[number].append(Placed(parts[name], road))
    wrong = []
    if set(parts) != set(layout.provenance["objects"]):
        wrong.append("objects that nothing asked for")
    for number, group in enumerate(spec.groups):
        wrong += [f"{group.kind}: {text}" for text in _broken_of(group, placed[number], road)]
        if group.relation is not None:
            references = [placed[reference] for reference in group.references]
            wrong += [
                f"{group.kind}: not {group.relation} {[spec.groups[r].kind for r in group.references]}"
                for one in placed[number]
                if not _related(group, one, references)
            ]
    return wrong + _broken_road(spec, road)


def _broken_road(spec: SceneSpec, road: Road) -> list[str]:
    wanted, wrong = spec.road, []
    if wanted.lanes is not None and road.lanes != wanted.lanes:
        wrong.append(f"{road.lanes} lanes")
    if wanted.oncoming_lanes not in (None, road.oncoming):
        wrong.append(f"{road.oncoming} oncoming lanes")
    lanes = {"left": road.lanes - 1, "middle": road.lanes // 2, "right": 0}
    if wanted.ego_lane is not None and road.ego_lane != lanes[wanted.ego_lane]:
        wrong.append(f"ego in lane {road.ego_lane}")
    if wanted.one_way != road.one_way:
        wrong.append("one-way")
    if wanted.sidewalk is not None and wanted.sidewalk != (road.sidewalk > 0):
        wrong.append("sidewalk")
    if wanted.median and not road.median:
        wrong.append("median")
    bend = {"left-bend": road.curvature > 0, "right-bend": road.curvature < 0, "bend": road.curvature != 0}
    junction = {"crossroads": len(road.side_roads) == 2, "t-junction": len(road.side_roads) == 1}
    if not bend.get(wanted.kind, road.curvature == 0):
        wrong.append("bend")
    if wanted.kind in junction and not (road.junction is not None and junction[wanted.kind]):
        wrong.append("junction")
    if (wanted.kind == "roundabout") != (road.roundabout_radius is not None):
        wrong.append("roundabout")
    if (wanted.kind == "parking-lot") != bool(road.paved_areas):
        wrong.append("parking lot")
    return wrong


def _broken_of(group: ObjectGroup, placed: list[Placed], road: Road) -> list[str]:
    wrong = []
    places = group.places or ("",)
    low, high = _counts(group)
    times = len(places) * (len(_lanes(group, road)) if group.lane == "each" else 1)
    if not low * times <= len(placed) <= high * times:
        wrong.append(f"{len(placed)} objects")
    for place in places:
        if group.lane == "each":
            wrong += _broken_lanes(group, [one for one in placed if _is_at(one, place, road)], road)
        there = sum(_is_at(one, place, road) and _at_distance(one, group, place, road) for one in placed)
        if there < low:
            wrong.append(f"{there} at place {place!r}, distance {group.distance}")
    for one in placed:
        wrong += [f"at {place}" for place in group.not_places if _is_at(one, place, road)]
        wrong += _broken_heading(group, one, road)
        for axis, said in enumerate(group.size or ()):
            if said is not None and abs((one.height if axis == 2 else one.size[axis]) - said) > 0.05:
                wrong.append(f"size {one.size}, {one.height}")
        if group.lane is not None and not _in_lane(group, one, road):
            wrong.append(f"not in the {group.lane} lane")
        wrong += _broken_set_back(group, one, road)
        beside = abs(one.foot) > road.edge
        if group.surface == "sidewalk" and road.sidewalk > 0.9 and not road.edge < abs(one.foot) < road.verge:
            wrong.append("not on the sidewalk")
        if group.surface == "median" and abs(one.foot) > road.median / 2:
            wrong.append("not in the median")
        if group.surface == "road" and beside:
            wrong.append("not on the road")
        if not group.on_road and not beside:
            wrong.append("on the road")
        if group.at_junction and road.junction is not None:
            reach = (road.roundabout_radius or road.edge) + 40.0
            if math.hypot(one.along - road.junction, one.across) > reach + 20.0:
                wrong.append("not at the junction")
    if group.spacing is not None and len(placed) > 2 and group.relation is None:
        along = sorted({round(one.along, 1) for one in placed})
        steps = np.diff(along)
        lengths = [one.high[0] - one.low[0] for one in placed]
        gaps = steps - np.mean(lengths)  # a spacing shorter than the objects is between their ends
        apart = min([abs(step - group.spacing) for step in (*steps, *gaps)], default=0.0)
        least = min(steps.min(), gaps.min()) if road.junction is None and steps.size else group.spacing
        if apart > 0.4 or (abs(least - group.spacing) > 0.4 and abs(steps.min() - group.spacing) > 0.4):
            wrong.append(f"spacing {steps}")
    return wrong


def _lanes(group: ObjectGroup, road: Road) -> list[float]:
    """`across` of the middle of each lane that the heading of a group allows, from the kerbs inwards."""
    first = road.edge - road.parking - road.lane_width / 2
    this_way = [-first + number * road.lane_width for number in range(road.lanes)]
    oncoming = [first - number * road.lane_width for number in range(road.oncoming)]
    return (this_way if group.heading != "against" else []) + (oncoming if group.heading != "with" else [])


def _broken_lanes(group: ObjectGroup, placed: list[Placed], road: Road) -> list[str]:
    low, high = _counts(group)
    wrong = []
    for lane in _lanes(group, road):
        number = sum(abs(one.across - lane) < road.lane_width / 2 for one in placed)
        if not low <= number <= high:
            wrong.append(f"{number} in the lane at {lane:.1f} m")
    return wrong


def _broken_set_back(group: ObjectGroup, one: Placed, road: Road) -> list[str]:
    said = group.from_road or group.from_sidewalk
    if said is None:
        return []
    if group.record.drives or group.surface == "road":
        off = road.edge - max(abs(one.low[1]), abs(one.high[1]))
    else:
        near = min(abs(one.foot_low), abs(one.foot_high))
        paved = [abs(a) for area in road.paved_areas for a in area.across if a * one.across > 0]
        off = near - max([road.edge if group.from_road else road.verge, *paved])
    return [] if said[0] - 0.1 <= off <= said[1] + 0.1 else [f"{off:.2f} m from the road, not {said}"]


def _counts(group: ObjectGroup) -> tuple[int, float]:
    if isinstance(group.count, int):
        return group.count, group.count
    if isinstance(group.count, tuple):
        return group.count
    return 1, math.inf


def _is_at(one: Placed, place: str, road: Road) -> bool:
    fore, side = split_place(place)
    ego = road.lane(road.ego_lane)
    along = {"front": one.along > 0, "behind": one.along < 0, "beside": abs(one.along) < 5.5, "": True}[fore]
    return along and {"left": one.across > ego, "right": one.across < ego, "": True}[side]


def _at_distance(one: Placed, group: ObjectGroup, place: str, road: Road) -> bool:
    """Whether the distance is that of its middle, its near end or side, or its gap to the bumper."""
    if group.distance is None or group.relation is not None:
        return True
    near, far = group.distance
    fore, _ = split_place(place)
    lateral = fore == "beside" or (not fore and not group.on_road)
    if lateral:
        off, half = abs(one.across - road.lane(road.ego_lane)), (one.high[1] - one.low[1]) / 2
        return near - 0.6 <= off - half <= far + 0.6 or near - 0.6 <= off <= far + 0.6  # of a tree its trunk
    off, half = abs(one.along), (one.high[0] - one.low[0]) / 2
    if group.count != 1 and near == far:
        return off >= near - 1.0
    return off - half - EGO_HALF - 1.0 <= far and off >= near - 0.6


def _broken_heading(group: ObjectGroup, one: Placed, road: Road) -> list[str]:
    if group.heading in (None, "parked"):
        return []
    cos, sin = math.cos(one.heading), math.sin(one.heading)
    if group.heading.startswith("turning") and road.junction is not None:
        return [] if abs(cos) < 0.995 or road.roundabout_radius else ["not turning"]
    if group.heading.startswith("across") and (group.record.walks or road.junction is not None):
        way = {"across-left": sin > 0.6, "across-right": sin < -0.6}.get(group.heading, abs(sin) > 0.6)
        return [] if way else ["not crossing"]
    if group.record.walks and group.heading not in ("with", "against"):
        return []
    placed = group.places or group.lane or group.relation or group.not_places
    if group.heading == "against" and not placed and one.along < 0:
        return ["oncoming, but behind"]
    if group.heading in ("with", "against"):
        return [] if (cos > 0.9) == (group.heading == "with") else [f"heading {one.heading}"]
    return []


def _in_lane(group: ObjectGroup, one: Placed, road: Road) -> bool:
    ego = road.lane(road.ego_lane)
    off = one.across - ego
    half = road.lane_width / 2
    return {
        "own": abs(off) < half,
        "left": off > half or road.ego_lane == road.lanes - 1,
        "right": off < -half or road.ego_lane == 0,
        "middle": abs(one.across) < road.edge,
        "each": True,
        "opposite": road.one_way or one.across > (road.lanes - road.oncoming) * half,
    }[str(group.lane)]


def _related(group: ObjectGroup, one: Placed, references: list[list[Placed]]) -> bool:
    everyone = [reference for of_group in references for reference in of_group]
    number = min(_counts(group)[1], 12)  # those of a word too
    row = (number - 1) * (one.size[0] + 8.0)  # several stand in a row
    roadside = 0.0 if group.on_road else 25.0  # to the side of a wide road
    reach = 18.0 + row + roadside + (group.distance or (0.0, 0.0))[1]
    if group.relation == "between":
        aside = 8.0 if group.record.drives == (max(o.size[2] for o in everyone) < 3.2) else 25.0
        return any(_is_between(one, a, b, aside) for a in everyone for b in everyone if a is not b) or len(everyone) < 2
    for other in everyone:
        if group.relation == "near" and group.distance is not None:
            if group.distance[0] - 0.6 <= one.gap(other) <= group.distance[1] + 0.6:
                return True
            continue
        if one.gap(other) > reach and group.relation != "opposite":
            continue
        cos = math.cos(other.heading)
        ahead, left = one.along - other.along, one.across - other.across
        holds = {
            "behind": min(abs(ahead), 99) > 0.2 or abs(left) > 0.2,
            "in-front-of": min(abs(ahead), 99) > 0.2 or abs(left) > 0.2,
            "beside": True,
            "near": True,
            "left-of": left > 0,
            "right-of": left < 0,
            "opposite": one.across * other.across < 0 and abs(ahead) < 6.0 + row,
        }[str(group.relation)]
        drives = abs(cos) > 0.9 and max(other.size[0], 0) > 1.0
        if group.relation in ("behind", "in-front-of") and group.record.is_vehicle and drives and abs(left) < 1.0:
            way = -1 if group.relation == "behind" else 1
            holds = ahead * way * cos > 0 or other.size[1] < 1.0
        if holds:
            return True
    return False


def _is_between(one: Placed, a: Placed, b: Placed, aside: float) -> bool:
    """Whether its middle projects on the way from one to the other."""
    way, off = b.middle - a.middle, one.middle - a.middle
    share = float(way @ off) / max(float(way @ way), 1e-9)
    return 0.0 < share < 1.0 and float(np.hypot(*(off - share * way))) < aside
