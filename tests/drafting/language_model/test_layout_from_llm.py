"""A text becomes a layout through a language model: as relations, or as a Blender script."""

import dataclasses
import json
import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import lidardraft
from lidardraft import Layout, layout_from_blender
from lidardraft.drafting.language_model.conversation import Prompt
from lidardraft.drafting.language_model.layout import (
    _spec_of,
    blender_prompt,
    code_of,
    json_of,
    layout_from_llm,
    scene_spec_schema,
    spec_prompt,
)
from lidardraft.drafting.solver.road_from_spec import MAX_DISTANCE
from lidardraft.drafting.solver.scene_spec import (
    ACTIVITIES,
    DISTRICTS,
    ROADS,
    SURFACES,
    ObjectGroup,
    RoadSpec,
    SceneSpec,
)
from lidardraft.drafting.text.layout import spec_from_text
from lidardraft.drafting.text.meaning import held_by, omissions
from lidardraft.errors import LanguageModelError, LayoutError, TextError
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.scene.check import check
from lidardraft.scene.weather import WEATHERS
from lidardraft.semantics import CLASSES
from replay_server import DIALECTS, Answer, ReplayServer, openai
from spec_checker import broken

TEXT = "Ein Bus steckt hinter zwei Lieferwagen fest, es regnet"
SPEC: dict[str, Any] = {
    "road": {"kind": "straight", "lanes": None, "sidewalk": None, "one_way": False},
    "groups": [
        {"words": "zwei Lieferwagen", "kind": "van", "count": 2, "places": ["front"], "heading": "with"},
        {"words": "Ein Bus steckt hinter", "kind": "bus", "relation": "behind", "references": [0]},
    ],
    "absent": [],
    "not_understood": ["es regnet"],
}
SCRIPT = (
    "import bpy\nbpy.ops.mesh.primitive_cube_add(size=4, location=({x}, 0, 2))\nbpy.context.object.name = 'bus_1'\n"
)
SECRET = "sk-0123456789abcdef"


def draft(server: ReplayServer, text: str = TEXT, seed: int = 0, **options: Any) -> Layout:
    return layout_from_llm(text, seed=seed, url=server.url, model="small", **options)


def replied(spec: dict[str, Any]) -> Answer:
    return openai(json.dumps(spec))


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_text_in_any_language_becomes_a_layout(server: ReplayServer, dialect: str) -> None:
    server.answers = [DIALECTS[dialect](json.dumps(SPEC))]
    layout = draft(server)
    spec = SceneSpec.from_dict(layout.provenance["spec"])
    assert spec == SceneSpec.from_dict(SPEC)
    assert broken(spec, layout) == []
    assert check(layout) == []
    told = layout.provenance
    assert (told["source"], told["sentence"], told["seed"]) == ("llm", TEXT, 0)
    assert told["understood"] == ["road: straight", "van: 2, in front, in the ego's direction", "bus: 1, behind van"]
    assert layout.notes == ("not understood: es regnet",)
    assert layout.intent.sentence == TEXT
    assert {name: asked.group for name, asked in layout.intent.objects.items()} == {"van_1": 0, "van_2": 0, "bus_1": 1}
    assert [group["words"] for group in told["spec"]["groups"]] == ["zwei Lieferwagen", "Ein Bus steckt hinter"]


def test_the_reply_in_the_docs_is_read_as_they_say(server: ReplayServer) -> None:
    page = (Path(__file__).parents[3] / "docs" / "how-to" / "language-models.md").read_text()
    text, reply = page.split('For the text "')[1].split('"')[0], page.split("```json")[1].split("```")[0]
    server.answers = [openai(reply)]
    names = {"layout": draft(server, text)}
    lines = [line.split("  # ") for line in page.splitlines() if line.startswith("layout.") and "  # " in line]
    *lines, (llm, keys) = lines
    assert len(lines) == 3
    for expression, said in lines:
        assert eval(expression, names) == eval(said)
    assert ", ".join(eval(llm, names)) == keys


def test_what_is_asked_and_what_is_told_of_it(server: ReplayServer) -> None:
    server.answers = [openai("No."), replied(SPEC)]
    told = draft(server).provenance["llm"]
    asked = server.requests[0].body
    assert asked["response_format"]["json_schema"]["strict"] is True
    assert asked["messages"][0] == {"role": "system", "content": spec_prompt().text}
    assert asked["messages"][1] == {"role": "user", "content": TEXT}
    assert told["model"] == "small"
    assert told["answered_by"] == "gpt-4.1-2025-04-14"
    assert told["prompt"] == spec_prompt().version
    assert len(told["request_sha256"]) == 64
    assert [attempt["error"] for attempt in told["attempts"]] == [
        "spec: not JSON: Expecting value: line 1 column 1 (char 0); it begins with 'No.'",
        None,
    ]
    assert json.loads(told["reply"]) == SPEC


def test_the_same_request_gives_the_same_bytes_without_a_server(server: ReplayServer, tmp_path: Path) -> None:
    server.answers = [openai("{}"), replied(SPEC)]
    first, folder = draft(server, cache=tmp_path / "kept"), tmp_path / "kept"
    server.__exit__()
    assert draft(server, cache=folder).to_json() == first.to_json()
    others = [draft(server, seed=seed, cache=folder) for seed in range(1, 5)]
    assert len({layout.to_json() for layout in [first, *others]}) == 5
    assert {json.dumps(layout.provenance["spec"]) for layout in others} == {json.dumps(first.provenance["spec"])}
    with pytest.raises(LanguageModelError, match="Connection refused"):
        draft(server, "another text", cache=folder)


@pytest.mark.parametrize("blender", [False, True])
def test_the_key_is_in_no_file_and_the_url_neither(
    server: ReplayServer, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, blender: bool
) -> None:
    monkeypatch.setenv("LIDARDRAFT_LLM_KEY", SECRET)
    monkeypatch.setenv("LIDARDRAFT_LLM_URL", server.url)
    monkeypatch.setenv("LIDARDRAFT_LLM_MODEL", "small")
    good = f"# {SECRET}\n" + SCRIPT.format(x=20) if blender else json.dumps(SPEC)
    server.answers = [openai(f"Your key is {SECRET}."), openai(good)]
    layout = lidardraft.layout_from_llm(TEXT, blender=blender, cache=tmp_path)
    layout.save(tmp_path / "layout.json")
    assert server.requests[0].headers["authorization"] == f"Bearer {SECRET}"
    files = [path.read_text() for path in tmp_path.rglob("*.json")]
    assert len(files) == 2
    assert not [text for text in files if SECRET in text]
    assert server.host not in layout.to_json()


def changed(**fields: Any) -> dict[str, Any]:
    return {**SPEC, "groups": [{**SPEC["groups"][0], **fields}, *SPEC["groups"][1:]]}


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ({}, "'groups' is missing"),
        ({**SPEC, "colour": "red"}, "unknown field 'colour'"),
        ({**SPEC, "road": {"kind": "street"}}, "road: kind is 'street'; it must be one of straight"),
        ({**SPEC, "groups": None}, "groups is None; it must be a list"),
        ({**SPEC, "groups": [{"kind": "car"}] * 51}, "the spec has 51 groups; it may have 50"),
        ({**SPEC, "not_understood": [5]}, "not_understood: part is 5; it must be text"),
        ({**SPEC, "not_understood": ["Schnee"]}, "'Schnee' is no part of the text, as 'Schnee' is not in it"),
        (changed(words="zwei rote Lieferwagen"), "is no part of the text, as 'rote' is not in it"),
        (changed(kind="Van"), "did you mean 'van'?"),
        (changed(distance=[500, 600]), "distance is 600 m; it must be 200 m or less"),
        (changed(relation="behind", references=[1]), "references go in a circle: "),
        (changed(size=[30, None, None]), "van: length is 30 m; a car has 2.4 to 6.5 m"),
        (changed(count=40, distance=[0, 10]), "of 40 vans fit in front, 0 to 10 m away, in the ego's direction"),
    ],
)
def test_what_is_wrong_with_a_reply_goes_back_to_the_model(
    server: ReplayServer, spec: dict[str, Any], said: str
) -> None:
    server.answers = [replied(spec), replied(SPEC)]
    layout = draft(server)
    first, second = layout.provenance["llm"]["attempts"]
    assert said in first["error"]
    assert second["error"] is None
    assert said in server.requests[1].body["messages"][3]["content"]


def test_a_text_of_which_nothing_was_understood(server: ReplayServer) -> None:
    server.answers = [replied({"road": {"kind": "straight"}, "groups": [], "not_understood": ["es regnet"]})]
    with pytest.raises(TextError, match=r"nothing of 'Ein Bus .* was understood by small"):
        draft(server)
    server.answers = [replied({"road": {"kind": "straight"}, "groups": []})]
    assert draft(server, "an empty road").boxes() == []


@pytest.mark.parametrize(("text", "length"), [("", 0), (" \n", 2), ("x" * 10_001, 10_001)])
def test_texts_that_are_not_sent(server: ReplayServer, text: str, length: int) -> None:
    with pytest.raises(TextError, match=f"the text has {length} characters; it must have 1 to 10000"):
        draft(server, text)
    assert server.requests == []


def test_what_else_is_refused_before_anything_is_sent(server: ReplayServer) -> None:
    for seed in (-1, 0.5, True):
        with pytest.raises(LayoutError, match="it must be an integer of 0 to"):
            draft(server, seed=seed)  # type: ignore[arg-type]
    with pytest.raises(LanguageModelError, match="the time limit is -1"):
        draft(server, timeout=-1)
    with pytest.raises(LanguageModelError, match="no language model is named"):
        layout_from_llm(TEXT, model="small")
    with pytest.raises(LanguageModelError, match="--llm-model names it"):
        layout_from_llm(TEXT, url=server.url)
    assert server.requests == []


def test_a_script_becomes_a_layout(server: ReplayServer) -> None:
    script = SCRIPT.format(x=20)
    server.answers = [
        openai("```python\nimport os\nos.mkdir(1)\n```"),
        openai("```python\nimport bpy\nbpy.ops.mesh.primitive_cube_add()\n```"),
        openai(f"Here it is:\n```python\n{script}```\n"),
    ]
    layout = draft(server, seed=3, blender=True)
    assert [box.label for box in layout.boxes()] == ["bus"]
    told = layout.provenance
    assert (told["source"], told["sentence"], told["seed"]) == ("llm", TEXT, 3)
    assert layout.notes[-2:] == (
        "bus_1 has length 4.00 m; a bus has 5.5 to 25 m",
        "bus_1 has width 4.00 m; a bus has 1.9 to 2.8 m",
    )
    assert told["llm"]["prompt"] == blender_prompt().version
    assert code_of(told["llm"]["reply"]) == script
    first, second, third = [attempt["error"] for attempt in told["llm"]["attempts"]]
    assert "line 2: os.mkdir is not supported" in first
    assert "no class for Cube" in second
    assert third is None
    assert {tuple(sorted(request.body)) for request in server.requests} == {("messages", "model", "seed")}
    assert server.requests[0].body["seed"] == 3


def test_another_seed_is_another_script(server: ReplayServer) -> None:
    server.answers = [openai(SCRIPT.format(x=20)), Answer({"error": "unknown field seed"}, 400)]
    server.answers += [openai(SCRIPT.format(x=30))]
    assert draft(server, blender=True) == draft(server, blender=True)
    assert draft(server, seed=1, blender=True).boxes()[0].center[0] == 30
    assert draft(server, seed=1, blender=True).boxes()[0].center[0] == 30
    assert len(server.requests) == 3


def test_a_reply_is_never_taken_for_the_path_of_a_file(server: ReplayServer, tmp_path: Path) -> None:
    (tmp_path / "scene.py").write_text(SCRIPT.format(x=20))
    server.answers = [openai(str(tmp_path / "scene.py"))] * 3
    with pytest.raises(LanguageModelError, match="none of 3 replies can be used"):
        draft(server, blender=True)


def examples(prompt: str) -> list[tuple[str, str]]:
    """The texts in a prompt and the replies to them."""
    return [tuple(part.split("\n", 1)) for part in prompt.split("\nText: ")[1:]]  # type: ignore[misc]


def test_the_examples_in_the_prompts_can_be_used() -> None:
    specs = examples(spec_prompt().text)
    assert len(specs) == 2
    for text, reply in specs:
        assert _spec_of(reply, text).groups
        for group in json.loads(reply)["groups"]:
            assert group.keys() == ObjectGroup.__dataclass_fields__.keys()
    ((_, script),) = examples(blender_prompt().text)
    layout = layout_from_blender(code_of(script))
    assert check(layout) == []
    assert layout.notes == ()
    assert sorted({primitive.label for primitive in layout}) == sorted(
        ["road", "sidewalk", "terrain", "car", "trunk", "vegetation"]
    )


def enumerations(schema: Any) -> Iterator[list[str]]:
    if isinstance(schema, dict):
        if "enum" in schema:
            yield schema["enum"]
        for each in schema.values():
            yield from enumerations(each)
    elif isinstance(schema, list):
        for each in schema:
            yield from enumerations(each)


def test_the_prompts_name_all_that_can_be_said_and_are_short() -> None:
    """A server with a context of 4,096 tokens has room for a prompt and a reply; a token is some four characters."""
    text = spec_prompt().text
    lists = {tuple(names) for names in enumerations(scene_spec_schema())}
    assert {tuple(ROADS), tuple(SENTENCE_KINDS), tuple(DISTRICTS), tuple(ACTIVITIES), tuple(WEATHERS)} <= lists
    assert len(lists) == 14
    for names in lists - {tuple(SURFACES)}:
        assert ", ".join(names) in text, names
    assert all(f'"{surface}"' in text for surface in SURFACES)
    assert f"up to {MAX_DISTANCE:g};" in text
    assert ", ".join(each.name for each in CLASSES[1:]) in blender_prompt().text
    for prompt in (spec_prompt(), blender_prompt(), Prompt.from_file("retry", error="it is no JSON")):
        instructions = prompt.text.partition("\nText: ")[0]  # an example may have an f-string
        assert not re.search(r"\$|\{\w+\}", instructions)  # neither $name nor {name} is left
        assert len(prompt.text) < 7000


NAMED = "two buses ahead, a man with a dog on the left, no trucks or vans"
MAN: dict[str, Any] = {"kind": "person", "words": "a man", "places": ["left"]}
DOG: dict[str, Any] = {"kind": "animal", "words": "a dog", "relation": "near", "references": [0]}


@pytest.mark.parametrize(
    ("groups", "notes"),
    [
        ([MAN, DOG, {"kind": "bus", "count": 2}], []),
        ([MAN, DOG, {"kind": "bus"}, {"kind": "bus"}], []),
        ([MAN, DOG, {"kind": "bus", "count": [1, 3]}], []),
        ([MAN, DOG, {"kind": "vehicle", "count": 2}], []),
        ([MAN, DOG], ["'two buses'; the reply has no bus"]),
        ([MAN, DOG, {"kind": "bus"}], ["'two buses'; the reply has bus: 1"]),
        ([MAN, DOG, {"kind": "bus", "count": 5}], ["'two buses'; the reply has bus: 5"]),
        ([MAN, DOG, {"kind": "bus", "count": "some"}], ["'two buses'; the reply has bus: some"]),
        ([MAN, {"kind": "bus", "count": 2}], ["'a dog'; the reply has no animal"]),
        ([{"kind": "car"}], [f"{name}; the reply has no {kind}" for name, kind in
                             (("'two buses'", "bus"), ("'a man'", "person"), ("'a dog'", "animal"))]),
    ],
)  # fmt: skip
def test_what_a_reply_leaves_out_of_the_text_is_a_note(
    server: ReplayServer, groups: list[dict[str, Any]], notes: list[str]
) -> None:
    server.answers = [replied({"road": {"kind": "straight"}, "groups": groups, "absent": ["truck", "van"]})] * 2
    assert list(draft(server, NAMED).notes) == [f"the sentence names {note}" for note in notes]


def test_a_model_is_asked_once_more_for_what_it_left_out(server: ReplayServer) -> None:
    buses = [{"kind": "bus", "count": count} for count in (1, 2)]
    server.answers = [
        replied({"road": {"kind": "straight"}, "groups": [MAN, DOG, bus], "absent": ["truck", "van"]}) for bus in buses
    ]
    layout = draft(server, NAMED)
    assert layout.notes == ()
    first, last = layout.provenance["llm"]["attempts"]
    assert first["error"] == "the sentence names 'two buses'; the reply has bus: 1; add the missing parts"
    assert last["error"] is None
    assert len(server.answers) == 0 or len(server.requests) == 2
    assert draft(server, NAMED) == layout  # from the cache, in which are both replies


def test_what_a_script_leaves_out_of_the_text_is_a_note(server: ReplayServer) -> None:
    text = "a bus 20 m ahead, three trees and a cyclist, no cars"
    tree = "bpy.ops.mesh.primitive_cube_add(size=2, location=(20, {}, 1))\nbpy.context.object.name = 'Tree_{}'\n"
    script = SCRIPT.format(x=20) + tree.format(9, 1) + tree.format(-9, 2)
    server.answers = [openai(script)] * 2
    found = [note for note in draft(server, text, blender=True).notes if note.startswith("the sentence")]
    names = [("'three trees'", "tree: 2"), ("'a cyclist'", "no bicycle")]
    assert found == [f"the sentence names {words}; the reply has {has}" for words, has in names]


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        ("a car ahead and a car behind", ["'a car'; the reply has car: 1"]),
        ("our car follows a bus", ["'a bus'; the reply has no bus"]),  # the ego vehicle is no object
        ("a car ahead, the car is red, the two cars brake", ["'the two cars'; the reply has car: 1"]),
        ("buses, no trucks and trees", ["'buses'; the reply has no bus"]),
        ("a trcuk ahead", ["'a truck'; the reply has no truck"]),
        (
            "two parked cars, a bus stop",
            ["'two parked cars'; the reply has car: 1", "'a bus stop'; the reply has no shelter"],
        ),
        ("a car in front of each house", ["'each house'; the reply has no house"]),
        ("Un car derrière deux camionnettes, car il pleut", []),  # the lexicon is English
        ("", []),
    ],
)
def test_omissions_of_a_text(text: str, notes: list[str]) -> None:
    spec = SceneSpec(groups=(ObjectGroup(kind="car"),))
    assert omissions(text, partial(held_by, spec)) == [f"the sentence names {note}" for note in notes]


def test_the_specs_of_sentences_leave_nothing_out_and_without_a_kind_it_is_missed() -> None:
    lines = [line for line in SENTENCES.read_text().splitlines() if line and not line.startswith(("    ", "#"))]
    loads = ("carrying logs", "loaded with four cars")  # which the grammar knows as no objects of their own
    missed = total = 0
    for line in lines[::16]:
        try:
            spec = spec_from_text(line, strict=True)
        except TextError:
            continue
        assert any(load in line for load in loads) or omissions(line, partial(held_by, spec)) == [], line
        for kind in {group.kind for group in spec.groups}:
            free = (dataclasses.replace(group, relation=None, references=()) for group in spec.groups)
            fewer = dataclasses.replace(spec, groups=tuple(group for group in free if group.kind != kind))
            missed += any(note.endswith(f"no {kind}") for note in omissions(line, partial(held_by, fewer)))
            total += 1
    assert total > 20
    assert missed > 0.9 * total


OBJECT = '{"road": {"kind": "bend"}, "groups": []}'
CUBE = "import bpy\n\nbpy.ops.mesh.primitive_cube_add()\n"


@pytest.mark.parametrize(
    "reply",
    [
        OBJECT,
        f"\n\n{OBJECT}\n",
        f"```json\n{OBJECT}\n```",
        f"```\n{OBJECT}\n```\nLet me know if you need more.",
        f"Here is the scene:\n\n~~~json\n{OBJECT}\n~~~",
        f"```json {OBJECT} ```",
        f"<think>A road {{with}} a bend...\n</think>\n\n{OBJECT}",
        f"Sure! {OBJECT}",
    ],
)
def test_an_object_among_other_words(reply: str) -> None:
    assert json_of(reply) == OBJECT


def test_where_there_is_no_object_all_of_it_is_given_back() -> None:
    assert json_of("I cannot } do { that") == "I cannot } do { that"
    assert json_of("") == ""


def test_an_object_that_is_cut_off_is_not_taken_for_a_smaller_one() -> None:
    assert json_of('```json\n{"road": {"kind": "bend"}, "groups": [{"kind"') == '{"road": {"kind": "bend"}'


@pytest.mark.parametrize(
    "reply",
    [
        CUBE,
        f"```python\n{CUBE}```",
        f"Install it:\n```sh\npip install bpy\n```\nThen:\n\n```python\n{CUBE}\n```\nEnjoy!",
        f"<think>\n```python\nx = 1\n```\n</think>\n~~~py\n{CUBE}~~~",
        f"  ```python\n{CUBE}  ```  ",
        f"```python\n{CUBE}",
    ],
)
def test_a_script_among_other_words(reply: str) -> None:
    assert code_of(reply) == CUBE


def test_fences_that_are_never_closed_are_read_in_one_pass() -> None:
    """A pattern that looks for the end of each would take minutes."""
    reply = "\n".join("`" * n for n in range(2000, 2, -1)) + "\n~~~\n" + "x\n" * 1_000_000
    assert code_of(reply).endswith("x\n")


def test_braces_after_the_object_are_words() -> None:
    assert json_of(f"Here: {OBJECT} and enjoy {{it}}.") == OBJECT


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
    lines = [line for line in SENTENCES.read_text().splitlines() if line and not line.startswith(("    ", "#"))]
    for line in lines[::16]:
        try:
            spec = spec_from_text(line)
        except TextError:
            continue
        fields = whole(spec)
        assert allows(schema, fields), line
        assert SceneSpec.from_dict(fields) == spec
        seen += 1
    assert seen > 25


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
