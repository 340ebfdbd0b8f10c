"""`lidardraft generate`, with the packaged weights."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from processes import shown_on_a_terminal

from lidardraft import Layout, Sensor, pipeline
from lidardraft.cli import main as cli
from lidardraft.formats import kitti, semantickitti
from lidardraft.semantics import BY_NAME

QUICK = ["--sensor", "small.json", "--steps", "2"]
ENDINGS = (".bin", ".label", ".boxes.json", ".layout.json", ".sensor.json", ".png")


def names(folder: str) -> set[str]:
    return {path.name for path in Path(folder).iterdir()}


def test_generate_from_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["generate", "--text", "a car ahead", "--seed", "3", "-n", "2", "-o", "out", *QUICK]) == 0
    assert names("out") == {f"{number}{end}" for number in ("000000", "000001") for end in ENDINGS}
    captured = capsys.readouterr()
    assert captured.out.startswith("out: 2 scans, 000000.bin to 000001.bin")
    # the weights were trained on another sensor: said once, in one line
    assert captured.err == (
        "lidardraft: these weights were trained on beams of 64, and small has 16; its scans may be poor\n"
    )
    points, intensity = kitti.read_bin("out/000000.bin")
    label, _ = semantickitti.read_label("out/000000.label", len(points))
    assert len(points) > 200
    assert 0 <= intensity.min() <= intensity.max() <= 1
    assert (label == BY_NAME["road"].id).any()
    first, second = (Layout.load(f"out/00000{k}.layout.json") for k in range(2))
    assert first != second  # another seed, another layout
    fields = json.loads(Path("out/000000.layout.json").read_text())["primitives"][0]
    assert {"shape", "center", "size", "yaw", "label", "id", "instance"} <= set(fields)
    assert Sensor.load("out/000000.sensor.json") == Sensor.load("small.json")


def test_generate_again_gives_the_same_scan() -> None:
    cli.main(["draft", "--text", "two cars behind", "-o", "layout.json"])
    for out in ("a", "b"):
        assert cli.main(["generate", "--layout", "layout.json", "-o", out, *QUICK]) == 0
    assert Path("a/000000.bin").read_bytes() == Path("b/000000.bin").read_bytes()
    assert cli.main(["generate", "--layout", "layout.json", "--seed", "1", "-o", "c", *QUICK]) == 0
    assert Path("a/000000.bin").read_bytes() != Path("c/000000.bin").read_bytes()


def test_generate_from_a_labelled_scan(capsys: pytest.CaptureFixture[str]) -> None:
    cli.main(["generate", "--text", "a car ahead and houses on both sides", "-o", "out", *QUICK])
    source = ["--points", "out/000000.bin", "--labels", "out/000000.label"]
    capsys.readouterr()
    assert cli.main(["generate", *source, "-o", "again", *QUICK]) == 0
    # a recorded scan says all there is
    assert capsys.readouterr().err == "lidardraft: the layout leaves nothing open: the scan is the simulated one\n"
    layout = Layout.load("again/000000.layout.json")
    assert "road" in {primitive.label for primitive in layout}
    assert len(kitti.read_bin("again/000000.bin")[0]) > 200


def test_weights_that_are_none_replace_nothing(refused: Callable[..., str]) -> None:
    generate = ["generate", "--text", "a car ahead", "-o", "out", *QUICK]
    assert cli.main(generate) == 0
    assert "weights" in refused(*generate, "--overwrite", "--weights", "none")


def test_bad_weights_and_devices_are_one_line(refused: Callable[..., str]) -> None:
    generate = ["generate", "--text", "a car ahead", "-o", "out"]
    assert "did you mean 'street'?" in refused(*generate, "--weights", "streets")
    Path("not.safetensors").write_bytes(b"not weights at all")
    assert "not.safetensors" in refused(*generate, "--weights", "not.safetensors")
    weights = Path("cut.safetensors")
    weights.write_bytes((Path(pipeline.__file__).parent / "weights/street.safetensors").read_bytes()[:-100])
    assert "cut.safetensors" in refused(*generate, "--weights", str(weights))
    assert "abacus" in refused(*generate, "--device", "abacus")


def test_truncated_scans_are_one_line(refused: Callable[..., str]) -> None:
    cli.main(["generate", "--text", "a car ahead", "-o", "out", *QUICK])
    points, label = Path("out/000000.bin"), Path("out/000000.label")
    source = ["--points", str(points), "--labels", str(label), "-o", "again"]
    label.write_bytes(label.read_bytes()[:-4])
    assert "000000.label" in refused("generate", *source)
    points.write_bytes(points.read_bytes()[:-3])
    assert "000000.bin" in refused("generate", *source)


def test_one_scan_shows_its_progress() -> None:
    shown = shown_on_a_terminal("generate", "--text", "a car ahead", "-o", "out", *QUICK)
    assert "scan 1 of 1" in shown
    assert "1/2" in shown
    assert "2/2" in shown
    assert "\rlidardraft: these weights" in shown  # on a line of its own


def test_the_speed_of_the_sensor_is_that_of_the_scan() -> None:
    text = "houses along both sides"
    assert cli.main(["generate", "--text", text, "--speed", "20", "-o", "out", *QUICK]) == 0
    with pytest.warns(UserWarning, match="its scans may be poor"):
        expected = pipeline.Pipeline.from_pretrained(steps=2)(text, sensor=Sensor.load("small.json"), speed=20.0)
    np.testing.assert_array_equal(kitti.read_bin("out/000000.bin")[0], expected.points())
