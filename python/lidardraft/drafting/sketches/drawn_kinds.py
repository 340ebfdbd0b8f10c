"""Which kind of object a blob stands for: what its names say, or else its class and size."""

from __future__ import annotations

import math

from lidardraft.drafting.sketches.drawn_shapes import Blob
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS, SentenceKind
from lidardraft.scene.check import SIZE_RANGES
from lidardraft.scene.class_names import words_of

# Words of names, and the kind that they mean where that is of the shape's class.
_KIND_OF_WORD = {
    **dict.fromkeys(("car", "cars", "taxi", "suv", "hatchback", "sedan"), "car"),
    **dict.fromkeys(("van", "minivan", "minibus"), "van"),
    **dict.fromkeys(("bush", "bushes", "shrub", "shrubs"), "bush"),
    **dict.fromkeys(("tree", "trees"), "tree"),
    **dict.fromkeys(("hedge", "hedges"), "hedge"),
    **dict.fromkeys(("house", "houses", "villa", "cottage", "garage", "shed"), "house"),
    **dict.fromkeys(("tower", "towers", "skyscraper", "apartments", "office", "church"), "building"),
    **dict.fromkeys(("lamp", "lamps", "streetlight", "streetlamp", "lamppost", "light"), "street-light"),
    **dict.fromkeys(("bin", "bins"), "bin"),
    **dict.fromkeys(("bench", "benches"), "bench"),
    **dict.fromkeys(("cone", "cones"), "cone"),
}
_KIND_OF_CLASS = {
    "building": "house",
    "vegetation": "tree",
    "trunk": "tree",
    "person": "person",
    "rider": "bicycle",
    "car": "car",
    "truck": "truck",
    "bus": "bus",
    "train": "tram",
    "motorcycle": "motorcycle",
    "bicycle": "bicycle",
    "pole": "pole",
    "traffic-light": "traffic-light",
    "traffic-sign": "traffic-sign",
    "wall": "wall",
    "fence": "fence",
    "other": "bin",
}
_BUSH = 2.3  # m across, at most
_LONGEST_CAR = 4.7  # m; a longer one is a van, between the sizes of both, and a still longer one a row of cars


def named_kind(label: str, names: tuple[str, ...]) -> SentenceKind | None:
    """The kind of a class that names mean, the last word that means one; None where they do not say it."""
    for name in names:
        for word in reversed(words_of(name)):
            kind = SENTENCE_KINDS.get(_KIND_OF_WORD.get(word, ""))
            if kind is not None and kind.label == label:
                return kind
    return None


def kind_of(blob: Blob) -> SentenceKind:
    """The kind of object that a blob stands for."""
    if kind := named_kind(blob.label, blob.names):
        return kind
    across = math.sqrt(blob.length * blob.width)
    if blob.label == "vegetation" and across < _BUSH:
        return SENTENCE_KINDS["bush"]
    if blob.label == "car" and _LONGEST_CAR < blob.length <= SIZE_RANGES["car"][1][0]:
        return SENTENCE_KINDS["van"]
    if blob.label == "building" and not _fits(blob, SENTENCE_KINDS["house"]):
        return SENTENCE_KINDS["building"]
    return SENTENCE_KINDS[_KIND_OF_CLASS[blob.label]]


def _fits(blob: Blob, kind: SentenceKind) -> bool:
    """Whether the footprint is no larger than such objects can be."""
    assert kind.sizes is not None
    return blob.length * blob.width <= kind.sizes.largest[0] * kind.sizes.largest[1]
