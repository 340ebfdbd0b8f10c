"""Sentences of many forms, with the relations that each is understood as and the words that are not."""

import dataclasses
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from lidardraft.drafting.solver.relation_text import relations
from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.drafting.text.layout import layout_from_text, spec_from_text
from lidardraft.errors import LayoutError, TextError
from lidardraft.scene.check import check
from spec_checker import broken


class Sentence(NamedTuple):
    """A sentence with what it says, what is unknown of it, and the refusal that it meets, if any."""

    text: str
    relations: list[str]
    unknown: list[str]
    refusal: str


def read_sentences() -> list[Sentence]:
    """Those of sentences.txt: a line each, and indented under it its relations, "? unknown words", "! a refusal"."""
    found: list[Sentence] = []
    for line in Path(__file__).with_name("sentences.txt").read_text(encoding="utf-8").splitlines():
        if not line.startswith("    "):
            found.append(Sentence(line, [], [], ""))
        elif line.startswith("    ? "):
            found[-1].unknown.append(line[6:])
        elif line.startswith("    ! "):
            found[-1] = found[-1]._replace(refusal=line[6:])
        else:
            found[-1].relations.append(line[4:])
    return found


SENTENCES = read_sentences()
UNKNOWN_CLAUSES = [
    *(
        "{}, a llama 12 m ahead",
        "{} and a griffin on the left",
        "{}. A dragon hovers above.",
        "{}, unicorns everywhere",
    ),
    *("{}; a UFO parked behind us", "{}, two wombats crossing", "{} and a zeppelin in the left lane", "{}, no yetis"),
    *(
        "{}, with a wizard on the roof",
        "{} and three goblins oncoming",
        "{}. On the left a yeti.",
        "{}, a flumph every 5 m",
    ),
    *("{}, a blorp behind the snark", "{} and an ogre next to a troll", "{}, a basilisk turning left"),
    *(
        "a llama on the left, {}",
        "There is a dragon 20 m behind. {}",
        "On the left a yeti, {}",
        "Two wombats crossing and {}",
    ),
]


@cache
def spec_of(text: str) -> SceneSpec:
    """The spec of a sentence without what is unknown."""
    return dataclasses.replace(spec_from_text(text), not_understood=())


def test_there_are_many() -> None:
    assert len(SENTENCES) >= 200
    assert len({sentence.text for sentence in SENTENCES}) == len(SENTENCES)


@pytest.mark.parametrize("sentence", SENTENCES, ids=[sentence.text for sentence in SENTENCES])
def test_what_is_understood_and_what_is_not(sentence: Sentence) -> None:
    spec = spec_from_text(sentence.text)
    assert [text for text in relations(spec) if text != "road: straight"] == sentence.relations
    assert list(spec.not_understood) == sentence.unknown
    if sentence.unknown:
        with pytest.raises(TextError, match="not understood: "):
            spec_from_text(sentence.text, strict=True)
    else:
        assert spec_from_text(sentence.text, strict=True) == spec


@pytest.mark.parametrize("sentence", SENTENCES, ids=[sentence.text for sentence in SENTENCES])
def test_every_relation_holds_for_three_seeds(sentence: Sentence) -> None:
    if sentence.refusal:
        with pytest.raises(LayoutError, match=sentence.refusal):
            layout_from_text(sentence.text, seed=0)
        return
    spec = spec_from_text(sentence.text)
    layouts = [layout_from_text(sentence.text, seed=seed) for seed in range(3)]
    for layout in layouts:
        assert broken(spec, layout) == []
        assert check(layout) == []
        groups = layout.provenance["spec"].get("groups", [])
        assert all(groups[number]["kind"] for number in layout.provenance["objects"].values())
    assert layout_from_text(sentence.text, seed=2).to_json() == layouts[2].to_json()
    assert len({tuple((primitive.center, primitive.size) for primitive in layout) for layout in layouts}) == 3


@pytest.mark.parametrize("clause", UNKNOWN_CLAUSES)
def test_an_unknown_clause_changes_nothing_of_the_rest(clause: str) -> None:
    for number, sentence in enumerate(SENTENCES):
        text = clause.format(sentence.text.rstrip(".!"))
        assert spec_of(text) == spec_of(sentence.text), text
        if number % 40 == 0:
            assert layout_from_text(text).primitives == layout_from_text(sentence.text).primitives


def test_no_word_is_lost() -> None:
    """Each unknown word is reported, and each group has the words that asked for it."""
    spec = spec_from_text("three flurbed cars grok on the left, a snark and two vans")
    assert spec.not_understood == ("flurbed", "grok", "snark")
    assert [group.words for group in spec.groups] == ["three flurbed cars grok on the left", "two vans"]
