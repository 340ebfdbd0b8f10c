"""Masks of objects, from whatever file they come in."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft.errors import FormatError
from lidardraft.formats.masks import read_masks

MASKS = np.zeros((2, 4, 5), dtype=bool)
MASKS[0, :2], MASKS[1, 2:, 3:] = True, True
NUMBERS = MASKS[0] * 7 + MASKS[1] * 300


def test_masks_are_read_from_arrays(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "a.npz", masks=MASKS, scores=np.ones(2))
    np.save(tmp_path / "a.npy", MASKS.astype(np.uint8))
    for name in ("a.npz", "a.npy"):
        found = read_masks(tmp_path / name)
        assert found.dtype == bool
        np.testing.assert_array_equal(found, MASKS)


@pytest.mark.parametrize("mode", ["I;16", "L"])
def test_numbers_are_read_from_pictures(tmp_path: Path, mode: str) -> None:
    numbers = NUMBERS.astype(np.uint16) if mode == "I;16" else (NUMBERS % 255).astype(np.uint8)
    Image.fromarray(numbers).save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_masks(tmp_path / "a.png"), numbers)


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.ones((2, 3, 4), np.float32), r"it holds float32 \[2, 3, 4\]; masks are bool"),
        (np.ones(4, bool), r"it holds bool \[4\]; masks are bool"),
        (np.full((2, 3, 4), 2), r"it holds 2 to 2; masks \[M, H, W\] are true or false"),
        (np.full((3, 4), -1), r"it holds -1 to -1; numbers of objects are 0 to"),
    ],
)
def test_arrays_that_are_no_masks(tmp_path: Path, array: np.ndarray, said: str) -> None:
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(FormatError, match=rf"a\.npy: {said}"):
        read_masks(tmp_path / "a.npy")


def test_files_that_hold_no_masks(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", segments=MASKS)
    with pytest.raises(FormatError, match=r"a\.npz: 'masks' is missing"):
        read_masks(tmp_path / "a.npz")
    Image.new("RGB", (5, 4)).save(tmp_path / "a.png")
    with pytest.raises(FormatError, match=r"a\.png: it has pixels of mode RGB"):
        read_masks(tmp_path / "a.png")
