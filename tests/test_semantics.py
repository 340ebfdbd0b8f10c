"""The class table, and what every class needs elsewhere: a class that is forgotten somewhere fails here."""

import numpy as np
import pytest

from lidardraft import CLASSES, Layout, Primitive, Sensor, raycast
from lidardraft.diffusion.codec import decode_scan, encode_scan
from lidardraft.formats.semantickitti import RAW_FROM_CLASS
from lidardraft.scene.surfaces import Surfaces
from lidardraft.semantics import BY_NAME, GROUND, NUM_CLASSES, SemanticClass

ONE_BEAM = Sensor(name="one-beam", elevations=(0.0,), columns=8)


def box_of(label: str) -> Primitive:
    return Primitive(shape="box", center=(5.0, 0.0, 1.7), size=(1.0, 4.0, 1.0), label=label, id="it")


def test_ids_count_up_and_names_and_colours_are_distinct():
    assert [row.id for row in CLASSES] == list(range(NUM_CLASSES))
    assert len({row.name for row in CLASSES}) == len({row.colour for row in CLASSES}) == NUM_CLASSES
    assert set(GROUND) <= set(BY_NAME)


def test_what_is_counted_has_a_typical_size():
    for row in CLASSES:
        assert row.is_thing == (row.size is not None), row.name


@pytest.mark.parametrize("row", CLASSES[1:], ids=lambda row: row.name)
def test_every_class_is_cast_encoded_written_and_reflects(row: SemanticClass):
    box = box_of(row.name)
    scan = raycast(Layout((box,)), ONE_BEAM)
    assert set(scan.label[scan.valid].tolist()) == {row.id}
    np.testing.assert_array_equal(decode_scan(encode_scan(scan), ONE_BEAM).label, scan.label)
    assert row.name in RAW_FROM_CLASS
    assert Surfaces.from_layout(Layout((box,))).table[1:].max() > 0
