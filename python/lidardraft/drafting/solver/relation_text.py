"""The relations of a spec in words: what a sentence was understood as, and what a refusal is about."""

from __future__ import annotations

from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec, split_place

_FORE = {"front": "in front", "behind": "behind", "beside": "beside the ego vehicle"}
_HEADINGS = {
    "with": "in the ego's direction",
    "against": "oncoming",
    "parked": "parked",
    "across": "crossing",
    "across-left": "crossing to the left",
    "across-right": "crossing to the right",
    "turning": "turning",
    "turning-left": "turning left",
    "turning-right": "turning right",
}
_RELATIONS = {"left-of": "on the left of", "right-of": "on the right of", "in-front-of": "in front of"}


def relations(spec: SceneSpec) -> list[str]:
    """All relations of a spec, the road's first, a line each."""
    found = [f"road: {text}" for text in road_relations(spec.road)]
    for group in spec.groups:
        found += [
            f"{group.kind}: {', '.join([count_text(group), *group_relations(group, spec, place)])}"
            for place in group.places or ("",)
        ]
    return found + [f"{kind}: none" for kind in spec.absent]


def road_relations(road: RoadSpec) -> list[str]:
    """What is said of the road."""
    found = [road.kind]
    if road.lanes is not None:
        other = road.oncoming_lanes or road.lanes
        ways = " each way" if other == road.lanes else f" this way, {other} oncoming"
        ways = "" if road.one_way else ways
        found.append(f"{road.lanes} lane{'s' * (road.lanes > 1)}{ways}")
    if road.one_way:
        found.append("one-way")
    if road.sidewalk is not None:
        found.append("sidewalks" if road.sidewalk else "no sidewalks")
    if road.ego_lane is not None:
        found.append(f"the ego in the {road.ego_lane} lane")
    return found


def count_text(group: ObjectGroup) -> str:
    """How many objects a group has at each place."""
    return f"{group.count[0]} to {group.count[1]}" if isinstance(group.count, tuple) else str(group.count)


def group_relations(group: ObjectGroup, spec: SceneSpec, place: str) -> list[str]:
    """What is said of where the objects of a group are at one of its places, and how."""
    fore, side = split_place(place)
    found = ([_FORE[fore]] if fore else []) + ([f"on the {side}"] if side else [])
    found += [f"not {' '.join(split_place(place)).strip()}" for place in group.not_places]
    lane = {"own": "the ego", "each": "each"}.get(str(group.lane), f"the {group.lane}")
    found += [f"in {lane} lane"] * (group.lane is not None)
    found += ["at the junction"] * group.at_junction
    found += [f"on the {group.surface}"] * (group.surface is not None)
    if group.relation is not None:
        kinds = " and ".join(spec.groups[reference].kind for reference in group.references)
        found.append(f"{_RELATIONS.get(group.relation, group.relation)} {kinds}")
    lengths = ((group.distance, "away"), (group.from_road, "from the road"), (group.from_sidewalk, "from the sidewalk"))
    for length, said in lengths:
        if length is not None:
            near, far = length
            found.append(f"{near:g} m {said}" if near == far else f"{near:g} to {far:g} m {said}")
    if group.spacing is not None:
        found.append(f"every {group.spacing:g} m")
    found += [_HEADINGS[group.heading]] if group.heading is not None else []
    sizes = zip(("long", "wide", "high"), group.size or (None,) * 3, group.scale or (None,) * 3, strict=True)
    for name, metres, scale in sizes:
        if metres is not None:
            found.append(f"{metres:g} m {name}")
        if scale not in (None, 1.0):
            found.append(f"{scale:g} times as {name}")
    return found
