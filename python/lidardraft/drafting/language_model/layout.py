"""A text becomes a layout through a language model on a server that the user names."""

from __future__ import annotations

import dataclasses
import os
import re
from typing import Any

from lidardraft.drafting.blender import layout_from_blender
from lidardraft.drafting.language_model.chat_server import MODEL, URL, ChatServer
from lidardraft.drafting.language_model.conversation import Conversation, Prompt, Request, converse
from lidardraft.drafting.language_model.http_answer import TimeLimit
from lidardraft.drafting.language_model.reply_cache import ReplyCache, cache_folder
from lidardraft.drafting.language_model.reply_text import code_of, json_of
from lidardraft.drafting.language_model.scene_spec_schema import scene_spec_schema
from lidardraft.drafting.solver.layout import check_seed, layout_from_spec
from lidardraft.drafting.solver.road_from_spec import MAX_DISTANCE
from lidardraft.drafting.solver.scene_spec import (
    EGO_LANES,
    HEADINGS,
    LANES,
    PLACES,
    RELATIONS,
    ROADS,
    SceneSpec,
    relations,
)
from lidardraft.drafting.solver.sentence_kinds import COUNTS, SENTENCE_KINDS
from lidardraft.errors import LayoutError, TextError, check_type
from lidardraft.files import named
from lidardraft.json_fields import check_fields, parse_object
from lidardraft.scene.check import check
from lidardraft.scene.layout import Layout
from lidardraft.semantics import CLASSES

MAX_LENGTH = 10_000  # characters of a text
MAX_GROUPS = 50  # of a spec; the solver takes minutes for many that find no room


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
    """A layout of what a text describes, as a language model reads it.

    `url` is the API of any server that answers as OpenAI's does, by default the environment variable
    LIDARDRAFT_LLM_URL, and `model` its model, by default LIDARDRAFT_LLM_MODEL. A key is read from LIDARDRAFT_LLM_KEY.
    The model writes a `SceneSpec`, which the seed turns into metres as that of a sentence; with `blender` it writes a
    Blender script for the seed, which is read as data. What cannot be used goes back to it with the reason, twice.

    Replies are kept in the folder `cache`, by default in the user's cache folder: the same text, seed, model and server
    give the same layout again, without the server. `timeout` is how long all replies together may take [s].

    `layout.provenance` holds the text, the seed, and in "llm" the model, the version of the prompt, the hashes of the
    request and of each reply, what was wrong with them, and the last reply; besides, what `layout_from_text` has
    ("spec", "understood", "not_understood", "objects"), or with `blender` the "findings" of `scene.check`.

    Raises `TextError` on a text that is empty or too long, `LanguageModelError` where there is no server, key or reply
    that can be used, `LayoutError` where a relation cannot hold for the seed.
    """
    check_type("text", text, str)
    check_seed(seed)
    if not text.strip() or len(text) > MAX_LENGTH:
        raise TextError(f"the text has {len(text)} characters; it must have 1 to {MAX_LENGTH}, and not blanks alone")
    server = ChatServer(url or os.environ.get(URL, ""), model or os.environ.get(MODEL, ""))
    replies, limit = ReplyCache(cache_folder() if cache is None else cache), TimeLimit(timeout)
    if blender:
        script = Request(server, blender_prompt(), text, {"seed": seed})
        drawn = converse(script, _layout_of_script, replies, limit)
        said = {"seed": seed, "findings": [finding.message for finding in check(drawn.result)]}
        return _with_provenance(drawn.result, drawn, said)
    described = converse(
        Request(server, spec_prompt(), text, _SPEC_FORMAT), lambda r: _spec_of(r, text), replies, limit
    )
    spec = described.result
    if spec.not_understood and spec == SceneSpec(not_understood=spec.not_understood):
        raise TextError(f"nothing of {text!r} was understood by {server.model}")
    said = {"understood": relations(spec), "not_understood": list(spec.not_understood)}
    return _with_provenance(layout_from_spec(spec, seed=seed), described, said)


def spec_prompt() -> Prompt:
    """The instructions for a spec; what names a field can have is filled in from the code that reads them."""
    names = {"roads": ROADS, "kinds": SENTENCE_KINDS, "counts": COUNTS, "places": PLACES, "lanes": LANES}
    names |= {"ego_lanes": EGO_LANES, "headings": HEADINGS, "relations": RELATIONS}
    texts = {name: ", ".join(values) for name, values in names.items()}
    return Prompt.from_file("scene_spec", farthest=f"{MAX_DISTANCE:g}", **texts)


def blender_prompt() -> Prompt:
    """The instructions for a Blender script."""
    return Prompt.from_file("blender_script", classes=", ".join(each.name for each in CLASSES[1:]))


_SPEC_FORMAT: dict[str, Any] = {
    "response_format": {
        "type": "json_schema",
        "json_schema": {"name": "scene_spec", "strict": True, "schema": scene_spec_schema()},
    }
}


def _spec_of(reply: str, text: str) -> SceneSpec:
    """The spec that a reply holds; it can be arranged, and quotes nothing that is not in the text."""
    with named("spec"):
        fields = parse_object(json_of(reply))
        check_fields(fields, ("road", "groups"), ("absent", "not_understood"))
        spec = SceneSpec.from_dict(fields)
    if len(spec.groups) > MAX_GROUPS:
        raise LayoutError(f"the spec has {len(spec.groups)} groups; it may have {MAX_GROUPS}")
    for said in (*(group.words for group in spec.groups), *spec.not_understood):
        if foreign := [word for word in re.findall(r"\w+", said) if word.casefold() not in text.casefold()]:
            raise LayoutError(f"{said!r} is no part of the text, as {foreign[0]!r} is not in it; copy words of it")
    layout_from_spec(spec)
    return spec


def _layout_of_script(reply: str) -> Layout:
    return layout_from_blender(code_of(reply))


def _with_provenance(layout: Layout, conversation: Conversation, said: dict[str, Any]) -> Layout:
    source = {"source": "llm", "sentence": conversation.request.text, "llm": conversation.provenance()}
    return dataclasses.replace(layout, provenance=layout.provenance | source | said)
