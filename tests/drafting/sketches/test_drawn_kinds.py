import numpy as np
import pytest

from lidardraft.drafting.sketches.drawn_kinds import kind_of, named_kind
from lidardraft.drafting.sketches.drawn_shapes import Blob
from lidardraft.semantics import CLASSES, GROUND


def blob(label: str, length: float, width: float, *names: str) -> Blob:
    return Blob(label, names, "", np.zeros(2), length, width, 0.0)


@pytest.mark.parametrize("label", [row.name for row in CLASSES[1:] if row.name not in GROUND])
def test_every_class_that_stands_on_the_ground_has_a_kind(label: str) -> None:
    assert kind_of(blob(label, 4.0, 2.0)).sizes is not None


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        (blob("building", 11, 9), "house"),
        (blob("building", 20, 14), "building"),
        (blob("building", 20, 14, "villa"), "house"),
        (blob("building", 8, 8, "office tower"), "building"),
        (blob("vegetation", 4, 4), "tree"),
        (blob("vegetation", 1.5, 1.5), "bush"),
        (blob("vegetation", 1.5, 1.5, "trees"), "tree"),
        (blob("car", 4.3, 1.8), "car"),
        (blob("car", 5.4, 2.0), "van"),
        (blob("car", 5.0, 1.8, "car-3"), "car"),
        (blob("car", 4.3, 1.8, "deliveryVan_2"), "van"),
        (blob("pole", 0.5, 0.5, "street lamp"), "street-light"),
        (blob("other", 0.5, 0.5, "traffic cone"), "cone"),
        (blob("other", 0.5, 0.5), "bin"),
    ],
)
def test_names_come_before_sizes(shape: Blob, kind: str) -> None:
    assert kind_of(shape).name == kind


def test_a_word_for_another_class_says_nothing() -> None:
    assert named_kind("wall", ("house wall",)) is None


def test_a_long_row_of_cars_is_no_van() -> None:
    assert [kind_of(blob("car", length, 1.8)).name for length in (4.2, 5.5, 17.0)] == ["car", "van", "car"]
