"""The table says what was measured."""

import numpy as np
import pytest

from compare_table import COLUMNS, Results, agreement, markdown, three_digits


@pytest.mark.parametrize(
    ("value", "text"), [(0.012345, "0.0123"), (0.5, "0.500"), (12.34, "12.3"), (99.96, "100.0"), (1234.5, "1234")]
)
def test_three_digits(value: float, text: str) -> None:
    assert three_digits(value) == text


def test_agreement_counts_ranges_within_tolerance_and_instances() -> None:
    depth = np.array([[10.0, 10.0, 0.0, 100.0]])
    label = np.zeros((1, 4), np.uint8)
    expected = depth, label, np.array([[1, 2, -1, 4]])
    got = depth + np.array([0.0019, 0.0022, 1.0, 0.0029]), label, np.array([[1, 2, 7, 4]])
    assert agreement(expected, got) == (0.5, 0.75)


def test_rows_hold_medians_and_ratios() -> None:
    results = Results()
    for milliseconds in (2.0, 90.0, 1.0):  # one round was disturbed
        results.add("small", "open3d", 1, "cast", 10e-3 * milliseconds)
        results.add("small", "packets", 1, "cast", 4e-3 * milliseconds)
        results.add("small", "analytic", 1, "cast", 0.1e-3 * milliseconds)
    results.agreement["small", "analytic"] = (1.0, 0.99998)
    head, _, *rows = markdown(results, ["small", "street"], [1, 2]).splitlines()
    assert [cell.strip() for cell in head.split("|")[1:-1]] == list(COLUMNS)
    assert len(rows) == 1
    row = dict(zip(COLUMNS, (cell.strip() for cell in rows[0].split("|")[1:-1]), strict=True))
    assert row["measured"] == "bare cast"
    assert (row["Open3D"], row["packet Embree"], row["analytic"], row["triangles"]) == ("20.0", "8.00", "0.200", "")
    assert (row["analytic / Open3D"], row["analytic / packets"], row["triangles / Open3D"]) == ("100x", "40.0x", "")
    assert row["same analytic"] == "100.000%, 99.998%"


def test_packets_stand_beside_end_to_end_with_their_cast() -> None:
    results = Results()
    results.add("street", "analytic", 2, "batch", 1e-3)
    results.add("street", "open3d", 2, "scan", 9e-3)
    results.add("street", "open3d", 2, "cast", 7e-3)
    results.add("street", "packets", 2, "cast", 3e-3)
    rows = markdown(results, ["street"], [2]).splitlines()[2:]
    cells = {row.split("|")[2].strip(): [cell.strip() for cell in row.split("|")] for row in rows}
    assert set(cells) == {"bare cast", "end to end, `out=`", "batch, one scan of it"}
    assert cells["batch, one scan of it"][4:8] == ["9.00", "", "3.00", "1.00"]
    assert cells["batch, one scan of it"][9:11] == ["9.00x", "3.00x"]
