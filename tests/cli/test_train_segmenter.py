"""`lidardraft-train segmenter`, from a folder of pairs to a weight file."""

from pathlib import Path

import numpy as np
import pytest

from lidardraft.cli import train
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.training.pairs import Pair, write_pairs


def test_pairs_become_a_segmenter(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sensor = Sensor(name="small", elevations=tuple(np.linspace(0.03, -0.4, 16).tolist()), columns=64)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(60, 60, 0), label="road", id="road")
    image = raycast(Layout(primitives=(road,)), sensor)
    list(write_pairs(tmp_path / "pairs", [(Pair(image, image, image), {})]))
    argv = ["segmenter", "--pairs", str(tmp_path / "pairs"), "--batch", "1", "-o", str(tmp_path / "run")]
    assert train.main([*argv, "--steps", "2", "--minutes", "1e-9"]) == 0
    assert train.main([*argv, "--steps", "2"]) == 0
    assert "2/2" in capsys.readouterr().err
    label = weight_file.load(tmp_path / "run" / "weights.safetensors", Segmenter).label(image)
    np.testing.assert_array_equal(label > 0, image.valid)
    assert train.main([*argv, "--steps", "2", "--seed", "1"]) == 2
    assert "another config: its seed is 0, not 1" in capsys.readouterr().err


@pytest.mark.parametrize("run", ["m.obj", "m.obj/run"])
def test_a_file_in_the_place_of_the_run_is_refused_before_the_pairs_are_read(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("m.obj").touch()
    assert train.main(["segmenter", "--pairs", "none", "-o", run]) == 2
    assert capsys.readouterr().err == "lidardraft-train: m.obj is a file; it must be a folder\n"
