"""`lidardraft simulate`."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from processes import shown_on_a_terminal

from lidardraft import Layout, Sensor, simulate
from lidardraft.cli import main as cli
from lidardraft.formats import kitti, semantickitti
from lidardraft.scan import SCAN_ENDINGS

SMALL = ["--sensor", "small.json"]


def test_simulate_from_text(capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["simulate", "--text", "a car ahead", "--seed", "3", "-n", "2", "--speed", "8", "-o", "out", *SMALL]
    assert cli.main(argv) == 0
    written = {path.name for path in Path("out").iterdir()}
    assert written == {f"{number}{end}" for number in ("000000", "000001") for end in SCAN_ENDINGS}
    captured = capsys.readouterr()
    assert captured.out.startswith("out: 2 scans, 000000.bin to 000001.bin")
    assert captured.err == ""
    for number in range(2):
        points, _ = kitti.read_bin(f"out/00000{number}.bin")
        label, _ = semantickitti.read_label(f"out/00000{number}.label", len(points))
        expected = simulate("a car ahead", Sensor.load("small.json"), seed=3 + number, speed=8.0)
        np.testing.assert_array_equal(points, expected.points())
        np.testing.assert_array_equal(label, expected.labels())
        assert Layout.load(f"out/00000{number}.layout.json") == expected.layout


def test_a_scan_that_was_simulated_is_simulated_again() -> None:
    text = "a car ahead and houses on both sides"
    assert cli.main(["simulate", "--text", text, "-o", "out", *SMALL]) == 0
    assert cli.main(["simulate", "--points", "out/000000.bin", "-o", "again", *SMALL]) == 0
    assert len(kitti.read_bin("again/000000.bin")[0]) > 200
    layout = ["simulate", "--layout", "again/000000.layout.json", "-o", "third", *SMALL]
    assert cli.main(layout) == 0
    assert Path("third/000000.bin").read_bytes() == Path("again/000000.bin").read_bytes()
    assert cli.main([*layout, "--overwrite", "--weather", "fog:30m", "--weather", "wet:1"]) == 0
    assert Path("third/000000.bin").read_bytes() != Path("again/000000.bin").read_bytes()


def test_clutter_stands_beside_the_road() -> None:
    text = "a straight road with trees on both sides"
    assert cli.main(["simulate", "--text", text, "--clutter", "1", "-o", "out", *SMALL]) == 0
    points, _ = kitti.read_bin("out/000000.bin")
    np.testing.assert_array_equal(points, simulate(text, Sensor.load("small.json"), clutter=1.0).points())
    assert points.tobytes() != simulate(text, Sensor.load("small.json")).points().tobytes()


def test_bad_input_is_one_line(refused: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    command = ["simulate", "--text", "a car ahead", "-o", "out", *SMALL]
    assert "did you mean 'snow'?" in refused(*command, "--weather", "snwo:2mm")
    assert "it must be rain and an amount, as in rain:0.5mm" in refused(*command, "--weather", "rain:10m")
    assert "it must be fog and an amount" in refused(*command, "--weather", "fog")
    assert "--weather has rain twice" in refused(*command, "--weather", "rain:1mm", "--weather", "rain:2mm")
    assert "wetness is 7.0; it must be 0 to 1" in refused(*command, "--weather", "wet:7")
    assert "visibility is 0.0" in refused(*command, "--weather", "fog:0m")
    assert "clutter is 2.0; it must be a number from 0 to 1" in refused(*command, "--clutter", "2")
    with pytest.raises(SystemExit):
        cli.main([*command, "--speed", "nan"])
    assert "'nan' is not a number" in capsys.readouterr().err


def test_a_layout_without_ground_is_said_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    Layout().save("empty.json")
    assert cli.main(["simulate", "--layout", "empty.json", "-n", "2", "-o", "out", *SMALL]) == 0
    err = capsys.readouterr().err
    assert err == "lidardraft: the layout has no ground (road, sidewalk or terrain): nothing returns from it\n"


def test_progress_is_shown() -> None:
    assert "2/2" in shown_on_a_terminal("simulate", "--text", "a car ahead", "-n", "2", "-o", "out", *SMALL)
