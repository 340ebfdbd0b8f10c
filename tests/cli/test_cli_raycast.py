from collections.abc import Callable
from pathlib import Path

import numpy as np

from lidardraft import RangeImage, Sensor
from lidardraft.cli import main as cli
from lidardraft.semantics import BY_NAME


def test_layouts_and_sentences_are_cast() -> None:
    assert cli.main(["draft", "--text", "a car ahead", "--seed", "3", "-o", "layout.json"]) == 0
    assert cli.main(["raycast", "--layout", "layout.json", "-o", "layout.npz"]) == 0
    assert cli.main(["raycast", "--text", "a car ahead", "--seed", "3", "-o", "sentence.npz"]) == 0
    image, same = RangeImage.load("layout.npz"), RangeImage.load("sentence.npz")
    assert image.sensor == Sensor.preset("hdl64e")
    assert BY_NAME["car"].id in image.label
    np.testing.assert_array_equal(image.depth, same.depth)


def test_bad_input_is_one_line(refused: Callable[..., str]) -> None:
    assert "nowhere.json" in refused("raycast", "--layout", "nowhere.json", "-o", "a.npz")
    Path("broken.json").write_text('{"schema": ')
    assert "broken.json: not JSON" in refused("raycast", "--layout", "broken.json", "-o", "a.npz")
    sensor = refused("raycast", "--text", "a car ahead", "--sensor", "hdl65e", "-o", "a.npz")
    assert "did you mean 'hdl64e'?" in sensor
