"""`lidardraft streets` and `pairs`: folders that train, and streets to look at."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, simulate
from lidardraft.cli import main as cli
from lidardraft.cli import pairs as module
from lidardraft.formats import kitti, semantickitti
from lidardraft.formats.datasets import RecordedFile
from lidardraft.training.sources import PairFolder

STREETS = ["streets", "--sensor", "small.json", "--workers", "1"]
Refused = Callable[..., str]
RECORDED = ["pairs", "00", "--sensor", "small.json", "-o", "out"]


def test_pairs_on_disk_go_on_where_they_stopped(capsys: pytest.CaptureFixture[str]) -> None:
    argv = [*STREETS, "--seed", "3", "--output", "pairs"]
    assert cli.main([*argv, "--num", "2"]) == 0
    assert capsys.readouterr().out == "pairs: 2 pairs, 2 of them new\n"
    first = PairFolder("pairs")
    assert cli.main([*argv, "--num", "5"]) == 0
    captured = capsys.readouterr()
    assert captured.err == "lidardraft: pairs: continues after 2 pairs\n"
    assert captured.out == "pairs: 5 pairs, 3 of them new\n"
    pairs = PairFolder("pairs")
    assert [note["index"] for note in pairs.notes] == [0, 1, 2, 3, 4]
    assert {note["style"]["source"] for note in pairs.notes} <= {"text", "cloud", "picture", "boxes"}
    np.testing.assert_array_equal(pairs[1].scan.depth, first[1].scan.depth)
    assert cli.main([*argv, "--num", "3"]) == 0
    assert capsys.readouterr().out == "pairs: 5 pairs are there already; nothing to do\n"
    assert len(PairFolder("pairs")) == 5


def test_pairs_of_another_seed_are_refused(refused: Callable[..., str]) -> None:
    assert cli.main([*STREETS, "--seed", "3", "--output", "pairs", "--num", "1"]) == 0
    assert "seed 3" in refused(*STREETS, "--output", "pairs", "--num", "9")


def test_pairs_are_not_mixed_with_other_files(refused: Callable[..., str]) -> None:
    Path("mine").mkdir()
    Path("mine/notes.txt").write_text("")
    assert "mine is not empty (notes.txt); use another folder" in refused(*STREETS, "--output", "mine")
    assert "small.json is a file; it must be a folder" in refused(*STREETS, "--output", "small.json")
    Path("killed").mkdir()
    for name in ("00000.npz", "00000.npz.1.partial"):  # before there was an index
        Path("killed", name).write_text("")
    assert cli.main([*STREETS, "--output", "killed", "-n", "1"]) == 0
    assert len(PairFolder("killed")) == 1


@pytest.fixture
def recordings(folder: Path) -> Path:
    """Three scans of a car on a road, in the files of SemanticKITTI."""
    road = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")
    for number in range(3):
        car = Primitive(
            shape="box", center=(10 + number, 3, 0.8), size=(4.5, 1.8, 1.6), label="car", id="car", instance=1
        )
        scan = simulate(Layout(primitives=(road, car)), Sensor.load("small.json"), seed=number)
        for name in ("velodyne", "labels"):
            (folder / "00" / name).mkdir(parents=True, exist_ok=True)
        kitti.write_bin(folder / f"00/velodyne/{number:06d}.bin", scan.points(), scan.intensities())
        semantickitti.write_label(folder / f"00/labels/{number:06d}.label", scan.labels(), scan.instances())
    return folder / "00"


def test_a_sequence_becomes_pairs_and_a_second_call_adds_what_is_new(
    recordings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    held = recordings / "velodyne" / "000002.bin"
    held.rename("later.bin")
    assert cli.main(RECORDED) == 0
    first, summary = capsys.readouterr().out.splitlines()
    assert first == "out: 2 pairs, 2 of them new"
    road, near, other = map(float, re.search(r"road (\d+)%.* (\d+)% explained.* (\S+)% of them", summary).groups())
    assert road > 80
    assert near > 80
    assert other < 5
    Path("later.bin").rename(held)
    assert cli.main(RECORDED) == 0
    assert "out: 3 pairs, 1 of them new" in capsys.readouterr().out
    folder = PairFolder("out")
    assert folder.sensor == Sensor.load("small.json")
    assert [Path(note["scan"]).name for note in folder.notes] == ["000000.bin", "000001.bin", "000002.bin"]
    for pair in (folder[i] for i in range(3)):
        both = pair.scan.valid & pair.condition_image.valid
        assert both.sum() > 0.7 * pair.scan.valid.sum()
        assert np.median(np.abs(pair.scan.depth - pair.condition_image.depth)[both]) < 0.3


def test_several_processes_make_the_same_pairs(recordings: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (recordings / "labels" / "000001.label").write_bytes(b"1234")
    assert cli.main(RECORDED) == 0
    assert cli.main([*RECORDED[:-1], "many", "--jobs", "2"]) == 0
    captured = capsys.readouterr()
    one, many = captured.out.replace("many:", "out:").split("out: 2 pairs, 2 of them new, 1 scan skipped\n")[1:]
    assert one == many
    assert captured.err.count("000001.label has 4 bytes") == 2
    first, second = PairFolder("out"), PairFolder("many")
    order = [[note["scan"] for note in second.notes].index(note["scan"]) for note in first.notes]
    for number, other in enumerate(order):
        for image, same in zip(first[number], second[other], strict=True):
            np.testing.assert_array_equal(image.depth, same.depth)


def test_a_data_set_becomes_pairs(recordings: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("set/sequences").mkdir(parents=True)
    recordings.rename("set/sequences/08")
    argv = ["pairs", "--dataset", "semantickitti", "set", "--sensor", "small.json", "-o", "out"]
    assert cli.main([*argv, "--split", "val"]) == 0
    assert capsys.readouterr().out.startswith("out: 3 pairs, 3 of them new\n")
    assert cli.main([*argv, "--split", "train"]) == 2
    assert "set: there is no sequences/NN/velodyne/*.bin of semantickitti, split train" in capsys.readouterr().err
    assert cli.main([*argv, "--split", "vall"]) == 2
    assert "split is 'vall'; of semantickitti it must be one of train, val, all" in capsys.readouterr().err
    assert cli.main(["pairs", "--dataset", "kitti", "set", "set", "-o", "out"]) == 2
    assert "--dataset takes one folder, that of kitti; there are 2" in capsys.readouterr().err


@pytest.mark.usefixtures("recordings")
def test_an_interrupted_call_goes_on(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from lidardraft.formats import pairs as disk

    whole = module._pair

    def interrupted(arguments: object, file: RecordedFile, *rest: object, **named: object) -> object:
        if file.scan.stem == "000002":
            raise KeyboardInterrupt
        return whole(arguments, file, *rest, **named)  # type: ignore[arg-type]

    with monkeypatch.context() as once:
        once.setattr(module, "_pair", interrupted)
        once.setattr(disk, "SHARD", 1)
        assert cli.main(RECORDED) == 130
    assert len(PairFolder("out")) == 2
    capsys.readouterr()
    assert cli.main(RECORDED) == 0
    captured = capsys.readouterr()
    assert "out: continues after 2 pairs" in captured.err
    assert captured.out.startswith("out: 3 pairs, 1 of them new\n")


def test_what_does_not_fit_is_skipped_in_a_line_each(recordings: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points, intensity = kitti.read_bin(recordings / "velodyne" / "000000.bin")
    points[5] = np.nan
    rows = np.column_stack([points, intensity]).astype("<f4")
    (recordings / "velodyne" / "000000.bin").write_bytes(rows.tobytes())
    (recordings / "labels" / "000001.label").write_bytes(b"1234")
    np.savez(recordings / "velodyne" / "bare.npz", xyz=np.nan_to_num(points), label=np.ones(len(points), np.uint8))
    assert cli.main(RECORDED) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("out: 1 pairs, 1 of them new, 3 scans skipped\n")
    said = [line for line in captured.err.splitlines() if line.startswith("lidardraft: skipped: ")]
    assert len(said) == 3
    for line, (file, why) in zip(
        said,
        (("000000.bin", "finite"), ("000001.label", "4 bytes"), ("bare.npz", "no intensities")),
        strict=True,
    ):
        assert file in line
        assert why in line


def test_npz_with_gaps_and_labels_of_a_folder(recordings: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points, intensity = kitti.read_bin(recordings / "velodyne" / "000000.bin")
    label, _ = semantickitti.read_label(recordings / "labels" / "000000.label", len(points))
    points[3] = np.nan  # no return, as organised clouds say
    np.savez("one.npz", xyz=points, intensity=255 * intensity, label=label)
    assert cli.main(["pairs", "one.npz", "--sensor", "small.json", "-o", "npz", "--intensity-scale", "255"]) == 0
    scan = recordings / "velodyne" / "000000.bin"
    scan.rename("alone.bin")
    (recordings / "labels" / "000000.label").rename(recordings / "labels" / "alone.label")
    assert cli.main(["pairs", "alone.bin", "--labels", "00/labels", "--sensor", "small.json", "-o", "bin"]) == 0
    npz, bin_ = PairFolder("npz")[0].scan, PairFolder("bin")[0].scan
    assert (npz.valid != bin_.valid).sum() <= 1
    assert npz.intensity is not None
    assert npz.intensity.max() <= 1
    capsys.readouterr()


@pytest.mark.usefixtures("recordings")
def test_what_cannot_be_is_refused(refused: Refused) -> None:
    assert "--sensor is needed" in refused("pairs", "00", "-o", "out")
    Path("empty").mkdir()
    assert "there is no .bin, .pcd, .ply, .npz, .las, .pkl.gz, .pcap, .osf, .mcap or .db3 file" in refused(
        "pairs", "empty", "--sensor", "small.json", "-o", "out"
    )
    assert "nothing.safetensors" in refused(*RECORDED, "--segmenter", "nothing.safetensors")
    Path("full").mkdir()
    Path("full/notes.txt").write_text("mine")
    assert "full is not empty (notes.txt)" in refused(*RECORDED[:-1], "full")


@pytest.mark.usefixtures("recordings")
def test_a_folder_of_another_sensor_is_refused(refused: Refused) -> None:
    assert cli.main(RECORDED) == 0
    small = Sensor.load("small.json")
    Path("small.json").write_text(Sensor(name="small", elevations=small.elevations, columns=64).to_json())
    assert "out holds pairs of another small; use another folder" in refused(*RECORDED)
    assert "out holds pairs of 'recordings, small'" in refused(*RECORDED[:3], "hdl32e", *RECORDED[4:])


@pytest.mark.usefixtures("recordings")
def test_a_sensor_that_did_not_record_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    elevations = tuple(np.deg2rad(np.linspace(2.5, -24, 21)).tolist())
    Path("finer.json").write_text(Sensor(name="finer", elevations=elevations, columns=128).to_json())
    assert cli.main(["pairs", "00", "--sensor", "finer.json", "-o", "other"]) == 0
    told = "the points are between the beams of finer as often as on them; `lidardraft fit` makes a sensor of the scans"
    assert capsys.readouterr().err.count(told) == 1
    assert cli.main(["pairs", "00", "--sensor", "vlp16", "-o", "none"]) == 2
    assert "none: none of 3 scans became a pair" in capsys.readouterr().err
