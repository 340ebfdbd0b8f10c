"""Specs at random, such as sentences could ask for."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lidardraft.drafting.solver.scene_spec import LANES, PLACES, RELATIONS, ROADS, ObjectGroup, RoadSpec, SceneSpec
from lidardraft.objects.kinds import SENTENCE_KINDS


def random_spec(rng: np.random.Generator) -> SceneSpec:
    """A spec that a sentence could ask for: some groups, some of them placed from others."""

    def chance(share: float) -> bool:
        return bool(rng.random() < share)

    def pick(values: Sequence[Any]) -> Any:
        return values[int(rng.integers(len(values)))]

    groups: list[ObjectGroup] = []
    road = RoadSpec(kind=pick(ROADS), one_way=chance(0.1), sidewalk=pick((None, None, True)))
    for number in range(int(rng.integers(1, 6))):
        kind = pick(list(SENTENCE_KINDS.values()))
        fields: dict[str, Any] = {"count": pick((1, 1, 2, 3, "some", (2, 4)))}
        relation = pick(RELATIONS) if number and chance(0.3) else None
        others = [n for n in range(number) if groups[n].kind != "vehicle"]
        if relation and others and kind.sizes is not None and not (kind.is_vehicle and relation == "opposite"):
            fields["relation"], fields["references"] = relation, (pick(others),)
            if relation == "between":
                fields["references"] = tuple(sorted({pick(others), pick(others)}))
                if len(fields["references"]) == 1 and groups[fields["references"][0]].count == 1:
                    fields["relation"] = "near"
            fields["count"] = pick((1, 1, "some"))
        elif chance(0.8):
            fields["places"] = (pick(PLACES),)
            if kind.is_vehicle and "beside" in fields["places"][0]:  # there is room for no more
                fields["count"] = 1
            fore = fields["places"][0].startswith(("front", "behind"))
            if fore and chance(0.4):
                near = float(rng.uniform(8.0, 60.0))
                fields["distance"] = (near, near + pick((0.0, 10.0)))
        if kind.drives and kind.is_vehicle and not fields.get("relation"):
            if not road.one_way and "right" not in str(fields.get("places")):
                fields["heading"] = pick((None, None, "with", "parked", "against"))
            if fields.get("places") in (("front",), ("behind",)) and chance(0.2):
                fields["heading"], fields["lane"] = None, pick(LANES)
            if not fields.get("places") and chance(0.3) and road.kind != "parking-lot":
                fields["heading"] = pick(("across", "turning-left", "turning-right"))
        groups.append(ObjectGroup(kind=kind.name, **fields))
    return SceneSpec(road=road, groups=tuple(groups))
