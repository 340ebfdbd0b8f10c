"""The files of a picture's depth, classes, masks and camera: the one that does not fit is named."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image


@pytest.fixture
def options() -> dict[str, str]:
    """A picture of 4 x 6 pixels with all that can be said of it; nothing is to be seen in it."""
    Image.fromarray(np.arange(72, dtype=np.uint8).reshape(4, 6, 3)).save("a.png")
    np.save("depth.npy", np.full((4, 6), 9.0))
    np.save("classes.npy", np.full((4, 6), 2))
    np.save("masks.npy", np.ones((4, 6), np.uint8))
    Path("camera.json").write_text("[5, 5, 3, 2]")
    files = {"semantics": "classes.npy", "depth": "depth.npy", "masks": "masks.npy", "intrinsics": "camera.json"}
    return {"image": "a.png", **files}


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("depth", np.ones((5, 6))),
        ("depth", np.zeros((4, 6))),
        ("depth", np.full((4, 6), 1e308)),
        ("semantics", np.full((4, 7), 2)),
        ("masks", np.ones((3, 6), np.uint8)),
        ("masks", np.ones((2, 3, 6), bool)),
        ("intrinsics", "[-5, 5, 3, 2]"),
        ("intrinsics", "[1e308, 5, 3, 2]"),
        ("intrinsics", "[5, 5, 30, 2]"),
    ],
)
def test_the_file_that_does_not_fit_is_named(
    name: str, content: object, options: dict[str, str], refused: Callable[..., str]
) -> None:
    if isinstance(content, str):
        Path(options[name]).write_text(content)
    else:
        np.save(options[name], content)
    words = [word for option, file in options.items() for word in (f"--{option}", file)]
    assert f"--{name} {options[name]}" in refused("draft", *words, "-o", "layout.json")
