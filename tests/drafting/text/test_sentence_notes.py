"""Notes on a sentence become a spec."""

from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.drafting.text.mention import Mention
from lidardraft.drafting.text.sentence_notes import SentenceNotes


def test_settings_imply_what_the_sentence_does_not_say():
    notes = SentenceNotes(settings={"RESIDENTIAL", "BUSY"})
    assert {group.kind for group in notes.spec().groups} == {"house", "vehicle"}
    notes = SentenceNotes(mentions=[Mention("building", 2)], settings={"RESIDENTIAL"})
    assert [group.kind for group in notes.spec().groups] == ["building"]


def test_what_is_denied_is_absent_and_not_implied():
    spec = SentenceNotes(mentions=[Mention("house", 0)], settings={"RESIDENTIAL"}).spec()
    assert spec.absent == ("house",)
    assert spec.groups == ()


def test_lanes_are_counted_on_both_sides_but_on_motorways():
    assert SentenceNotes(lanes=4).spec().road.lanes == 2
    assert SentenceNotes(lanes=4, each_way=True).spec().road.lanes == 4
    assert SentenceNotes(road="motorway", lanes=3).spec().road.lanes == 3


def test_nothing_noted_is_empty():
    notes = SentenceNotes("a llama, red", unclear=[(9, 12), (2, 7)])
    assert notes.empty
    assert notes.not_understood == ["llama", "red"]
    assert not SentenceNotes(sidewalk=False).empty
    assert Mention("car", 1).group() == ObjectGroup(kind="car", count=1)
