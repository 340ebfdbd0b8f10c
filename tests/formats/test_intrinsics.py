"""Intrinsics of a camera, from the files that say them."""

import json
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.intrinsics import read_intrinsics

K = [[721.5, 0, 609.5], [0, 720.5, 172.8], [0, 0, 1]]
FOUR = [721.5, 720.5, 609.5, 172.8]


@pytest.mark.parametrize(
    "content",
    [
        K,
        FOUR,
        {"K": K},
        {"intrinsics": FOUR},
        dict(zip(("fx", "fy", "cx", "cy"), FOUR, strict=True)),
        {"camera_matrix": {"rows": 3, "cols": 3, "data": [value for row in K for value in row]}},
    ],
)
def test_json(tmp_path: Path, content: object) -> None:
    (tmp_path / "camera.json").write_text(json.dumps(content))
    np.testing.assert_array_equal(read_intrinsics(tmp_path / "camera.json"), FOUR)


@pytest.mark.parametrize(
    "text",
    [
        "P0: 1 0 2 0 0 1 2 0 0 0 1 0\nP2: 721.5 0 609.5 44.9 0 720.5 172.8 0.2 0 0 1 0.003\nTr_velo_to_cam: 0\n",
        "calib_time: 09-Jan\nK_02: 1 0 1 0 1 1 0 0 1\nP_rect_02: 721.5 0 609.5 0 0 720.5 172.8 0 0 0 1 0\n",
    ],
)
def test_calibrations_of_kitti(tmp_path: Path, text: str) -> None:
    (tmp_path / "calib.txt").write_text(text)
    np.testing.assert_array_equal(read_intrinsics(tmp_path / "calib.txt"), FOUR)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.json", "{", "not JSON"),
        ("a.json", "[" * 100_000, "not JSON"),
        ("a.json", '{"fx": 3}', "it holds no intrinsics"),
        ("a.json", "[1, 2, 3]", "it holds no intrinsics"),
        ("a.json", '["a", 1, 1, 1]', "it holds no intrinsics"),
        ("a.json", "[NaN, 1, 1, 1]", "it holds no intrinsics"),
        ("a.txt", "nothing", "no calibration of KITTI"),
        ("a.txt", "P2: 1 2 x", "P2 must hold 9 or 12 finite numbers"),
        ("a.txt", "P2: 1 2 3", "P2 must hold 9 or 12 finite numbers"),
        ("a.txt", "x" * 2**20 + "x", "intrinsics of up to"),
    ],
)
def test_files_that_say_none(tmp_path: Path, name: str, text: str, said: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(FormatError, match=rf"{name}: .*{said}"):
        read_intrinsics(tmp_path / name)
