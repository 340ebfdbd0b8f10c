from pathlib import Path

import numpy as np
from PIL import Image

from lidardraft.view import save_png
from picture_inputs import pictures

DOCS = Path(__file__).parents[2] / "docs"


def test_the_pictures_of_the_docs_show_what_is_read_now(tmp_path: Path) -> None:
    """Where they are out of date, `python benches/picture_inputs.py docs` writes them anew."""
    for name, picture in pictures():
        save_png(tmp_path / f"{name}.png", picture)
        with Image.open(DOCS / f"{name}.png") as image:
            shown = np.asarray(image)
        assert shown.shape == picture.shape, tmp_path
        assert (np.abs(shown.astype(int) - picture) > 2).any(axis=2).mean() < 0.001, tmp_path
        assert f"({name}.png)" in (DOCS / f"{name}.md").read_text()
