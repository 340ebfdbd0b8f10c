"""The JSON Schema of a `SceneSpec`, in the part of the language that every server which obeys schemas knows.

Each field is required, null where it says nothing; there are no patterns, limits of numbers or references.
"""

from __future__ import annotations

from typing import Any

from lidardraft.drafting.solver.scene_spec import EGO_LANES, HEADINGS, LANES, PLACES, RELATIONS, ROADS, SURFACES
from lidardraft.drafting.solver.sentence_kinds import COUNTS, SENTENCE_KINDS

Schema = dict[str, Any]


def scene_spec_schema() -> Schema:
    """The schema of what `SceneSpec.from_dict` reads."""
    numbers = {"type": "array", "items": {"type": "number"}}
    road = {
        "kind": _one_of(ROADS),
        "lanes": _or_null({"type": "integer"}),
        "oncoming_lanes": _or_null({"type": "integer"}),
        "sidewalk": _or_null({"type": "boolean"}),
        "one_way": {"type": "boolean"},
        "ego_lane": _or_null(_one_of(EGO_LANES)),
    }
    count = ({"type": "integer"}, _one_of(COUNTS), {"type": "array", "items": {"type": "integer"}})
    group = {
        "words": {"type": "string"},
        "kind": _one_of(SENTENCE_KINDS),
        "count": {"anyOf": list(count)},
        "places": _list_of(_one_of(PLACES)),
        "not_places": _list_of(_one_of(PLACES)),
        "surface": _or_null(_one_of(SURFACES)),
        "lane": _or_null(_one_of(LANES)),
        "at_junction": {"type": "boolean"},
        "heading": _or_null(_one_of(HEADINGS)),
        "distance": _or_null(numbers),
        "spacing": _or_null({"type": "number"}),
        "from_road": _or_null(numbers),
        "from_sidewalk": _or_null(numbers),
        "size": _or_null(_list_of(_or_null({"type": "number"}))),
        "scale": _or_null(numbers),
        "relation": _or_null(_one_of(RELATIONS)),
        "references": _list_of({"type": "integer"}),
    }
    return _object(
        {
            "road": _object(road),
            "groups": _list_of(_object(group)),
            "absent": _list_of(_one_of(SENTENCE_KINDS)),
            "not_understood": _list_of({"type": "string"}),
        }
    )


def _object(fields: dict[str, Schema]) -> Schema:
    return {"type": "object", "properties": fields, "required": list(fields), "additionalProperties": False}


def _list_of(item: Schema) -> Schema:
    return {"type": "array", "items": item}


def _one_of(names: Any) -> Schema:
    return {"type": "string", "enum": list(names)}


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}
