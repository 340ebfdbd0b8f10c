"""A text becomes a layout by a language model on a server that the user names."""

from __future__ import annotations

import dataclasses
import json
import os
import re
from functools import partial
from typing import Any

from platformdirs import user_cache_path

from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.drafting.blender.script.reading import fenced
from lidardraft.drafting.language_model.chat_server import MODEL, URL, ChatServer, TimeLimit
from lidardraft.drafting.language_model.conversation import (
    Conversation,
    Prompt,
    ReplyCache,
    Request,
    converse,
    once_more,
)
from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.road_from_spec import MAX_DISTANCE
from lidardraft.drafting.solver.scene_spec import (
    DISTRICTS,
    EGO_LANES,
    LANES,
    PLACES,
    RELATIONS,
    ROADS,
    SURFACES,
    SceneSpec,
    relations,
)
from lidardraft.drafting.text.meaning import held_by, omissions
from lidardraft.drafting.text.tree import NounPhrase
from lidardraft.errors import LayoutError, TextError, check_seed, check_type
from lidardraft.files import named
from lidardraft.json_fields import check_fields, parse_object
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.sentence_kind import COUNTS
from lidardraft.scene.check import check, objects
from lidardraft.scene.intent import ACTIVITIES, HEADINGS, MOTIONS, PAINTS
from lidardraft.scene.layout import Layout
from lidardraft.scene.weather import WEATHERS
from lidardraft.semantics import CLASSES

Schema = dict[str, Any]
MAX_LENGTH = 10_000  # characters of a text
MAX_GROUPS = 50  # of a spec; the solver takes minutes if many find no room


def layout_from_llm(
    text: str,
    *,
    seed: int = 0,
    url: str | None = None,
    model: str | None = None,
    blender: bool = False,
    cache: str | os.PathLike[str] | None = None,
    timeout: float = 120.0,
) -> Layout:
    """The layout of a text, as a language model understands it.

    `url` is the API of any server compatible with OpenAI's, by default the environment variable LIDARDRAFT_LLM_URL, and
    `model` its model, by default LIDARDRAFT_LLM_MODEL. A key is read from LIDARDRAFT_LLM_KEY. The model writes a
    `SceneSpec`, which the seed turns into metres as for a sentence. With `blender` it writes a Blender script for the
    seed, which is read as data. An unusable reply goes back to it with the reason, twice; a reply that omits nouns or
    numbers of the text goes back once, and what it omits again is a note.

    Replies are kept in the folder `cache`, by default in the user's cache folder: the same text, seed, model and server
    give the same layout again, without the server. `timeout` is the time limit for all replies together [s].

    `layout.provenance` holds the text, the seed, and in "llm" the model, the version of the prompt, the hashes of the
    request and of each reply, their errors, and the last reply; also the entries of `layout_from_text` ("spec",
    "understood", "objects"). With `blender` the findings of `scene.check` are in `layout.notes`.

    Raises `TextError` on a text that is empty or too long, `LanguageModelError` without a server, key or usable reply,
    `LayoutError` if a relation cannot hold for the seed.
    """
    check_type("text", text, str)
    seed = check_seed(seed)
    if not text.strip() or len(text) > MAX_LENGTH:
        raise TextError(f"the text has {len(text)} characters; it must have 1 to {MAX_LENGTH}, and not blanks alone")
    server = ChatServer(url or os.environ.get(URL, ""), model or os.environ.get(MODEL, ""))
    kept = user_cache_path("lidardraft", appauthor=False, opinion=False) / "replies" if cache is None else cache
    replies, limit = ReplyCache(kept), TimeLimit(timeout)
    if blender:
        script = Request(server, blender_prompt(), text, {"seed": seed})
        read = once_more(
            lambda reply: layout_from_blender(code_of(reply), strict=True),
            lambda layout: omissions(text, partial(_drawn, layout)),
        )
        drawn = converse(script, read, replies, limit)
        findings, layout = check(drawn.result), _with_provenance(drawn.result, drawn, {"seed": seed})
        return layout.noted(*omissions(text, partial(_drawn, drawn.result)), *(finding.message for finding in findings))
    schema = {"name": "scene_spec", "strict": True, "schema": scene_spec_schema()}
    asked = Request(server, spec_prompt(), text, {"response_format": {"type": "json_schema", "json_schema": schema}})
    read_spec = once_more(lambda reply: _spec_of(reply, text), lambda spec: omissions(text, partial(held_by, spec)))
    described = converse(asked, read_spec, replies, limit)
    spec = described.result
    if spec.not_understood and spec == SceneSpec(not_understood=spec.not_understood):
        raise TextError(f"nothing of {text!r} was understood by {server.model}")
    layout = _with_provenance(layout_from_spec(spec, seed=seed), described, {"understood": relations(spec)})
    unknown = [f"not understood: {', '.join(spec.not_understood)}"] * bool(spec.not_understood)
    return layout.noted(*unknown, *omissions(text, partial(held_by, spec)))


def spec_prompt() -> Prompt:
    """The instructions for a spec; the names that its fields allow come from the code that reads them."""
    names = {"roads": ROADS, "kinds": SENTENCE_KINDS, "counts": COUNTS, "places": PLACES, "lanes": LANES}
    names |= {"ego_lanes": EGO_LANES, "headings": HEADINGS, "motions": MOTIONS, "relations": RELATIONS}
    names |= {"districts": DISTRICTS, "activities": ACTIVITIES}
    names |= {"paints": PAINTS, "weathers": WEATHERS}
    texts = {name: ", ".join(values) for name, values in names.items()}
    return Prompt.from_file("scene_spec", farthest=f"{MAX_DISTANCE:g}", **texts)


def blender_prompt() -> Prompt:
    """The instructions for a Blender script."""
    return Prompt.from_file("blender_script", classes=", ".join(each.name for each in CLASSES[1:]))


def _spec_of(reply: str, text: str) -> SceneSpec:
    """The spec in a reply; it can be arranged, and quotes only words of the text."""
    with named("spec"):
        fields = parse_object(json_of(reply))
        check_fields(
            fields, ("road", "groups"), ("absent", "not_around", "district", "activity", "weather", "not_understood")
        )
        spec = SceneSpec.from_dict(fields)
    if len(spec.groups) > MAX_GROUPS:
        raise LayoutError(f"the spec has {len(spec.groups)} groups; it may have {MAX_GROUPS}")
    for said in (*(group.words for group in spec.groups), *spec.not_understood):
        if foreign := [word for word in re.findall(r"\w+", said) if word.casefold() not in text.casefold()]:
            raise LayoutError(f"{said!r} is no part of the text, as {foreign[0]!r} is not in it; copy words of it")
    layout_from_spec(spec)
    return spec


def _drawn(layout: Layout, phrase: NounPhrase) -> list[tuple[float, float]]:
    """From 1 up to all objects of a layout with the class of a phrase, as one object may be drawn as several; [] if
    none."""
    kind = SENTENCE_KINDS[str(phrase.kind)]
    kinds = [one for one in SENTENCE_KINDS.values() if one == kind or (kind.name == "vehicle" and one.is_vehicle)]
    labels = {one.label for one in kinds} | ({"rider"} if kind.name == "person" else set())
    count = sum(any(part.label in labels for part in parts) for parts in objects(layout).values())
    return [(1, count)] if count else []


def _with_provenance(layout: Layout, conversation: Conversation, said: dict[str, Any]) -> Layout:
    source = {"source": "llm", "sentence": conversation.request.text, "llm": conversation.provenance()}
    intent = dataclasses.replace(layout.intent, sentence=conversation.request.text)
    return dataclasses.replace(layout, provenance=layout.provenance | source | said, intent=intent)


def json_of(reply: str) -> str:
    """The JSON object at the first brace; if it is broken, the text from there to the last brace; without braces, all
    of it."""
    text = _answer_of(reply)
    start, end = text.find("{"), text.rfind("}")
    if not 0 <= start < end:
        return text
    try:
        return text[start : json.JSONDecoder().raw_decode(text, start)[1]]
    except (ValueError, RecursionError):  # the reader of the JSON reports the error
        return text[start : end + 1]


def code_of(reply: str) -> str:
    """The longest fenced block, closed or not, or the whole text if there is none.

    It ends in a line break, so it is never mistaken for the path of a file.
    """
    text = _answer_of(reply)
    return (fenced(text) or text).strip("\n") + "\n"


def _answer_of(reply: str) -> str:
    """The answer after the thoughts that models write, which some servers do not remove."""
    return reply.rpartition("</think>")[2].strip()


def scene_spec_schema() -> Schema:
    """The JSON Schema of the input of `SceneSpec.from_dict`, in the part of the language that every server supports.

    Each field is required, null if it says nothing; there are no patterns, limits of numbers or references.
    """
    numbers = _list_of({"type": "number"})
    road = {
        "kind": _one_of(ROADS),
        "lanes": _or_null({"type": "integer"}),
        "oncoming_lanes": _or_null({"type": "integer"}),
        "sidewalk": _or_null({"type": "boolean"}),
        "median": {"type": "boolean"},
        "one_way": {"type": "boolean"},
        "ego_lane": _or_null(_one_of(EGO_LANES)),
        "ego_motion": _or_null(_one_of(MOTIONS)),
        "ego_speed": _or_null({"type": "number"}),
        "junction": _or_null(numbers),
    }
    count = [{"type": "integer"}, _one_of(COUNTS), _list_of({"type": "integer"})]
    group = {
        "words": {"type": "string"},
        "kind": _one_of(SENTENCE_KINDS),
        "count": {"anyOf": count},
        "places": _list_of(_one_of(PLACES)),
        "not_places": _list_of(_one_of(PLACES)),
        "surface": _or_null(_one_of(SURFACES)),
        "lane": _or_null(_one_of(LANES)),
        "at_junction": {"type": "boolean"},
        "heading": _or_null(_one_of(HEADINGS)),
        "motion": _or_null(_one_of(MOTIONS)),
        "speed": _or_null({"type": "number"}),
        "distance": _or_null(numbers),
        "spacing": _or_null({"type": "number"}),
        "from_road": _or_null(numbers),
        "from_sidewalk": _or_null(numbers),
        "size": _or_null(_list_of(_or_null({"type": "number"}))),
        "scale": _or_null(numbers),
        "paint": _or_null(_one_of(PAINTS)),
        "relation": _or_null(_one_of(RELATIONS)),
        "references": _list_of({"type": "integer"}),
    }
    kinds = _list_of(_one_of(SENTENCE_KINDS))
    spec = {"road": _object(road), "groups": _list_of(_object(group)), "absent": kinds, "not_around": kinds}
    spec |= {"district": _or_null(_one_of(DISTRICTS)), "activity": _or_null(_one_of(ACTIVITIES))}
    spec |= {"weather": _or_null(_one_of(WEATHERS))}
    return _object(spec | {"not_understood": _list_of({"type": "string"})})


def _object(fields: dict[str, Schema]) -> Schema:
    return {"type": "object", "properties": fields, "required": list(fields), "additionalProperties": False}


def _list_of(item: Schema) -> Schema:
    return {"type": "array", "items": item}


def _one_of(names: Any) -> Schema:
    return {"type": "string", "enum": list(names)}


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}
