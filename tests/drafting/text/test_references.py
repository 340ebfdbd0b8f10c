"""Which object a position is relative to."""

import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("sentence", "related"),
    [
        ("a person beside the wall", [("person", "beside", ("wall",)), ("wall", None, ())]),
        ("a wall, a person beside the wall", [("wall", None, ()), ("person", "beside", ("wall",))]),
        ("a bus ahead and a car behind it", [("bus", None, ()), ("car", "behind", ("bus",))]),
        ("behind the bus there is a car", [("bus", None, ()), ("car", "behind", ("bus",))]),
        ("a car in front and a truck behind", [("car", None, ()), ("truck", None, ())]),
        ("a bus followed by a car", [("bus", None, ()), ("car", "behind", ("bus",))]),
        (
            "a bin between a bench and a tree",
            [("bin", "between", ("bench", "tree")), ("bench", None, ()), ("tree", None, ())],
        ),
        ("we are behind a bus", [("bus", None, ())]),
    ],
)
def test_relations(sentence: str, related: list[tuple[str, str | None, tuple[str, ...]]]) -> None:
    groups = spec_from_text(sentence, strict=True).groups
    assert [(g.kind, g.relation, tuple(groups[r].kind for r in g.references)) for g in groups] == related
