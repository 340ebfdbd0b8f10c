import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.semantickitti import CLASS_FROM_RAW, RAW_FROM_CLASS, read_label, write_label
from lidardraft.semantics import BY_NAME, CLASSES, NUM_CLASSES

# All ids of semantic-kitti.yaml.
RAW_IDS = [0, 1, 10, 11, 13, 15, 16, 18, 20, 30, 31, 32, 40, 44, 48, 49, 50, 51, 52, 60, 70, 71, 72, 80, 81, 99]
RAW_IDS += range(252, 260)


def test_every_raw_id_has_a_class_and_every_class_a_raw_id():
    assert sorted(CLASS_FROM_RAW) == RAW_IDS
    assert set(CLASS_FROM_RAW.values()) <= set(BY_NAME)
    assert set(RAW_FROM_CLASS) == set(BY_NAME)
    assert set(RAW_FROM_CLASS.values()) <= set(RAW_IDS)


@pytest.mark.parametrize(
    ("raw", "name"),
    [
        (1, "none"),
        (44, "road"),
        (60, "road"),
        (49, "terrain"),
        (252, "car"),
        (254, "person"),
        (257, "bus"),
        (259, "truck"),
    ],
)
def test_lossy_ids(tmp_path, raw, name):
    (tmp_path / "a.label").write_bytes(np.array([raw | 7 << 16], dtype="<u4").tobytes())
    label, instance = read_label(tmp_path / "a.label", 1)
    assert (CLASSES[label[0]].name, instance[0]) == (name, 7)


def test_canonical_ids_are_written():
    expected = {"car": 10, "road": 40, "terrain": 72, "rider": 31, "truck": 18, "wall": 51, "other": 99, "none": 0}
    assert {name: RAW_FROM_CLASS[name] for name in expected} == expected


def test_round_trip_of_all_classes_but_the_two_that_are_lost(tmp_path):
    label = np.arange(NUM_CLASSES, dtype=np.uint8)
    instance = np.linspace(0, 65535, NUM_CLASSES).astype(np.uint32)
    write_label(tmp_path / "a.label", label, instance)
    read, numbers = read_label(tmp_path / "a.label", NUM_CLASSES)
    lost = {"wall": "fence", "traffic-light": "other"}
    assert [CLASSES[i].name for i in read] == [lost.get(row.name, row.name) for row in CLASSES]
    np.testing.assert_array_equal(numbers, instance)


def test_a_file_of_another_length(tmp_path):
    write_label(tmp_path / "a.label", np.zeros(3, dtype=np.uint8), np.zeros(3, dtype=np.uint32))
    with pytest.raises(FormatError, match=r"a.label has 12 bytes, 3 labels; the scan has 4 points"):
        read_label(tmp_path / "a.label", 4)


def test_an_unknown_class_and_a_missing_file_are_named(tmp_path):
    (tmp_path / "a.label").write_bytes(np.array([40, 77 | 1 << 16], dtype="<u4").tobytes())
    with pytest.raises(FormatError, match=r"a.label: point 1 has class 77, which SemanticKITTI does not have"):
        read_label(tmp_path / "a.label", 2)
    with pytest.raises(FormatError, match=r"b.label: No such file or directory"):
        read_label(tmp_path / "b.label", 2)


@pytest.mark.parametrize(
    ("label", "instance", "message"),
    [
        ([1, NUM_CLASSES], [0, 0], rf"point 1 has class {NUM_CLASSES}; it must be 0 to {NUM_CLASSES - 1}"),
        ([1, 1], [0, 65536], r"point 1 has instance 65536; it must be 0 to 65535"),
        ([1, 1], [0], r"label \(2,\) and instance \(1,\) must both be \[N\]"),
    ],
)
def test_what_a_label_cannot_hold_is_not_written(tmp_path, label, instance, message):
    with pytest.raises(FormatError, match=message):
        write_label(tmp_path / "a.label", np.array(label, dtype=np.uint8), np.array(instance, dtype=np.uint32))
    assert not list(tmp_path.iterdir())
