"""The schema allows what a spec can say, and stays within what servers know of schemas."""

import dataclasses
import json
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lidardraft.drafting.language_model.scene_spec_schema import scene_spec_schema
from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.text.layout import spec_from_text
from lidardraft.errors import LidarDraftError, TextError

SENTENCES = Path(__file__).parents[1] / "text" / "sentences.txt"


def allows(schema: dict[str, Any], value: Any) -> bool:
    """Whether a value is of a schema, of which only the words below are known."""
    assert schema.keys() <= {"type", "properties", "required", "additionalProperties", "items", "enum", "anyOf"}
    if "anyOf" in schema:
        return any(allows(each, value) for each in schema["anyOf"])
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": int | float}
    if schema["type"] == "null":
        return value is None
    if not isinstance(value, kinds[schema["type"]]) or (type(value) is bool) != (schema["type"] == "boolean"):
        return False
    if schema["type"] == "array":
        return all(allows(schema["items"], item) for item in value)
    if schema["type"] == "object":
        fields = schema["properties"]
        return value.keys() == fields.keys() and all(allows(fields[name], item) for name, item in value.items())
    return value in schema.get("enum", [value])


def whole(spec: SceneSpec) -> dict[str, Any]:
    """A spec as a model writes it that obeys the schema: with all fields."""

    def listed(value: Any) -> Any:
        if isinstance(value, dict):
            return {name: listed(item) for name, item in value.items()}
        return [listed(item) for item in value] if isinstance(value, list | tuple) else value

    fields: dict[str, Any] = listed(dataclasses.asdict(spec))
    return fields


def objects_of(schema: Any) -> Iterator[dict[str, Any]]:
    if isinstance(schema, dict):
        if schema.get("type") == "object":
            yield schema
        for each in schema.values():
            yield from objects_of(each)
    elif isinstance(schema, list):
        for each in schema:
            yield from objects_of(each)


def test_it_has_the_fields_of_a_spec_each_of_them_required() -> None:
    schema = scene_spec_schema()
    spec, road, group = objects_of(schema)
    for found, kind in ((spec, SceneSpec), (road, RoadSpec), (group, ObjectGroup)):
        assert found["properties"].keys() == {field.name for field in dataclasses.fields(kind)}
        assert found["required"] == list(found["properties"])
        assert found["additionalProperties"] is False


def test_it_allows_what_every_sentence_says_and_it_is_read_back() -> None:
    schema, seen = scene_spec_schema(), 0
    for line in SENTENCES.read_text().splitlines():
        if line.startswith(("    ", "#")) or not line:
            continue
        try:
            spec = spec_from_text(line)
        except TextError:
            continue
        fields = whole(spec)
        assert allows(schema, fields), line
        assert SceneSpec.from_dict(fields) == spec
        seen += 1
    assert seen > 200


def sample(schema: dict[str, Any], rng: random.Random) -> Any:
    """A value that the schema allows."""
    if "anyOf" in schema:
        return sample(rng.choice(schema["anyOf"]), rng)
    if "enum" in schema:
        return rng.choice(schema["enum"])
    if schema["type"] == "array":
        return [sample(schema["items"], rng) for _ in range(rng.choice((0, 0, 1, 2, 3)))]
    if schema["type"] == "object":
        return {name: sample(each, rng) for name, each in schema["properties"].items()}
    values = {"null": (None,), "boolean": (True, False), "integer": (-1, 0, 1, 2, 10**30), "string": ("", "a car")}
    return rng.choice(values.get(schema["type"], (-1.0, 0, 0.5, 2, 30, 1e308, float("inf"), float("nan"))))


def test_what_it_allows_is_read_or_refused() -> None:
    schema, read, refused = scene_spec_schema(), 0, 0
    for seed in range(1000):
        fields = sample(schema, random.Random(seed))
        assert allows(schema, fields)
        try:
            SceneSpec.from_json(json.dumps(fields))
            read += 1
        except LidarDraftError:
            refused += 1
    assert min(read, refused) > 100


def test_it_forbids_what_no_spec_says() -> None:
    schema = scene_spec_schema()
    fields = whole(SceneSpec(groups=(ObjectGroup(kind="car"),)))
    assert allows(schema, fields)
    changes = [{"kind": "llama"}, {"count": "lots"}, {"places": ["above"]}, {"lane": "fast"}, {"heading": "up"}]
    changes += [{"distance": "far"}, {"relation": "on"}, {"references": ["bus"]}, {"colour": "red"}, {"words": None}]
    for change in changes:
        assert not allows(schema, {**fields, "groups": [{**fields["groups"][0], **change}]}), change
    assert not allows(schema, {**fields, "road": {**fields["road"], "kind": "canal"}})
    assert not allows(schema, {name: fields[name] for name in ("road", "groups")})
