import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("sentence", "kind", "relation", "references"),
    [
        ("a car behind a bus", "car", "behind", ["bus"]),
        ("a bin between a bench and a tree", "bin", "between", ["bench", "tree"]),
        ("a man between the trees on the right and the road", "person", "in-front-of", ["tree"]),
        ("two cars, a bus and a motorcycle between them", "motorcycle", "between", ["car", "bus"]),
        ("a hedge on the left; behind it a house", "house", "behind", ["hedge"]),
        ("a wall, two people on a bench and a tree behind it", "tree", "behind", ["bench"]),
        ("four trees; under the third one there is a bench", "bench", "near", ["tree"]),
    ],
)
def test_what_is_placed_from_what(sentence: str, kind: str, relation: str, references: list[str]) -> None:
    spec = spec_from_text(sentence)
    (group,) = (group for group in spec.groups if group.kind == kind)
    assert group.relation == relation
    assert [spec.groups[number].kind for number in group.references] == references
