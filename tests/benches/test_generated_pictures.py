"""The pictures of weights side by side, of unseen streets."""

from pathlib import Path

import pytest
from PIL import Image

import generated_pictures


def test_a_row_each_layout_and_a_column_each_weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = []
    for weights in (["paper-small"], ["paper-small", "paper-small"]):
        file = tmp_path / "look.png"
        argv = ["generated_pictures.py", *weights, "--steps", "1", "--rows", "2", "-o", str(file)]
        monkeypatch.setattr("sys.argv", argv)
        generated_pictures.main()
        with Image.open(file) as picture:
            sizes.append(picture.size)
    assert sizes[0][0] > 1000
    assert sizes[1] == sizes[0]  # the same weights once more are the same column
