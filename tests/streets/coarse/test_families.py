"""The words that sentences have."""

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.objects.kinds import KINDS
from lidardraft.streets.coarse.families import ALWAYS_NAMED, FAMILIES, FAMILY_OF


def test_every_word_of_a_kind_is_of_one_family_or_always_named():
    named = [*ALWAYS_NAMED, *(word for _, words in FAMILIES.values() for word in words)]
    assert len(named) == len(set(named))
    assert set(named) == {kind.word for kind in KINDS.values()} - {None}
    assert set(named) <= set(SENTENCE_KINDS)
    assert set(SENTENCE_KINDS) - set(named) <= {
        "vehicle",
        "garden",
        "cone",
        "barrier",
    }  # a word for others, one for several, one left out, one that streets call a fence
    assert set(FAMILY_OF) == {*named, None}
