from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, simulate
from lidardraft.cli import main as cli
from lidardraft.formats.boxes import read_boxes
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.nuscenes import write_pcd_bin
from lidardraft.formats.recording import read_points

ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(100, 100, 0), label="road", id="road")
CAR = Primitive(shape="box", center=(9, 0, 0.75), size=(4.2, 1.8, 1.5), label="car", id="car_1", instance=1)


@pytest.fixture(autouse=True)
def scan(folder: Path) -> Path:
    simulate(Layout((ROAD, CAR)), Sensor.preset("hdl32e")).save("scan")
    return folder / "scan.bin"


def test_without_edits_objects_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["edit", "scan.bin"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("car_1: car at 9.00,0.00 yaw 0 size 4.20,1.80,1.50, ")
    Path("scan.boxes.json").unlink()
    assert cli.main(["edit", "scan.bin", "--labels", "scan.label"]) == 0
    assert capsys.readouterr().out.startswith("car_1: car at ")  # a cluster
    Path("scan.label").unlink()
    assert cli.main(["edit", "scan.bin"]) == 0
    assert capsys.readouterr().out == "no objects: give --boxes or --labels to have some that can be removed\n"


def test_edits_are_done_in_their_order(capsys: pytest.CaptureFixture[str]) -> None:
    edits = ("--remove", "car_1", "--insert", "truck at 14,-3 yaw 90", "--insert", "A car at 9, 0 size 4, 1.7, 1.4")
    more = ("--move", "car_1", "8, 4, -30", "--replace", "truck_1", "person")
    assert cli.main(["edit", "scan.bin", *edits, *more, "-o", "edited.bin"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("edited.bin: ")
    assert out.endswith("with .label, .npz, .boxes.json and .sensor.json\n")
    boxes, counts = read_boxes("edited.boxes.json")
    assert [box.id for box in boxes] == ["car_1", "person_1"]
    assert boxes[0].yaw == pytest.approx(-np.pi / 6)
    assert min(counts) > 5
    points, fields = read_points("edited.npz")
    assert {1, 2} <= set(fields["made_up"].tolist())
    assert len(read_points("edited.bin")[0]) == len(points)
    first = Path("edited.bin").read_bytes()
    assert cli.main(["edit", "scan.bin", *edits, *more, "-o", "again", "--seed", "1"]) == 0
    assert cli.main(["edit", "scan.bin", *edits, *more, "-o", "edited"]) == 0
    assert Path("edited.bin").read_bytes() == first != Path("again.bin").read_bytes()


def test_kinds_of_two_words_and_sweeps_of_nuscenes(capsys: pytest.CaptureFixture[str]) -> None:
    points, intensity = read_bin("scan.bin")
    write_pcd_bin("bare.pcd.bin", points, intensity, np.zeros(len(points)))
    assert cli.main(["edit", "bare.pcd.bin", "--insert", "a street light at 6,-5", "-o", "lit"]) == 0
    assert [box.id for box in read_boxes("lit.boxes.json")[0]] == ["street-light_1"]
    assert Sensor.load("lit.sensor.json") == Sensor.preset("hdl32e")
    assert "taken for" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--remove", "car_7", "-o", "out"], "scan.bin: no object has the id 'car_7'; the scan has car_1"),
        (["--insert", "car at 9,0", "-o", "out"], "scan.bin: car_2 at 9, 0 would overlap car_1 by"),
        (["--insert", "zebra at 9,3", "-o", "out"], "'zebra' is no object that can be inserted; it must be"),
        (["--remove", "car_1"], "--output is missing: the file of the edited scan"),
        (["--remove", "car_1", "-o", "scan"], "scan.bin is the input too; write to another file"),
        (["--remove", "car_1", "-o", "out.pcd"], "out.pcd: an edited scan is a .bin and an .npz"),
        (["--remove", "car_1", "-o", "out.pcd.bin"], "out.pcd.bin: an edited scan is a .bin and an .npz"),
        (["--insert", "car at 9,3 size 0,1,1", "-o", "out"], "car_2: size is (0.0, 1.0, 1.0); it must be three"),
        (["-o", "out"], "scan.bin: no edit; give --insert, --remove, --move or --replace"),
        (["--remove", "car_1", "-o", "no/folder"], "no/folder cannot be written"),
        (["--remove", "car_1", "--boxes", "missing.txt", "-o", "out"], "missing.txt"),
    ],
)
def test_edits_that_cannot_be(refused: Callable[..., str], argv: list[str], message: str) -> None:
    assert message in refused("edit", "scan.bin", *argv)


@pytest.mark.parametrize(
    "argv", [["--insert", "a car in front"], ["--move", "car_1", "over there"], ["--insert", "car at 1e9,2"]]
)
def test_edits_that_are_not_understood(argv: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        cli.main(["edit", "scan.bin", *argv, "-o", "out"])
    error = capsys.readouterr().err
    assert f"argument {argv[0]}: {argv[-1]!r} is no" in error
    assert error.count("\n") == 1
