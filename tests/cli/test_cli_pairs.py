"""`lidardraft pairs`, from recorded files to a folder that trains."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, simulate
from lidardraft.cli import main as cli
from lidardraft.cli import pairs as module
from lidardraft.formats import kitti, semantickitti
from lidardraft.training.pairs import PairFolder

Refused = Callable[..., str]


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


PAIRS = ["pairs", "00", "--sensor", "small.json", "-o", "out"]


def test_a_sequence_becomes_pairs_and_a_second_call_adds_what_is_new(
    recordings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    held = recordings / "velodyne" / "000002.bin"
    held.rename("later.bin")
    assert cli.main(PAIRS) == 0
    assert capsys.readouterr().out == "out: 2 pairs, 2 of them new\n"
    Path("later.bin").rename(held)
    assert cli.main(PAIRS) == 0
    assert "out: 3 pairs, 1 of them new" in capsys.readouterr().out
    folder = PairFolder("out")
    assert folder.sensor == Sensor.load("small.json")
    assert [Path(note["scan"]).name for note in folder.notes] == ["000000.bin", "000001.bin", "000002.bin"]
    for pair in (folder[i] for i in range(3)):
        both = pair.scan.valid & pair.simulated.valid
        assert both.sum() > 0.7 * pair.scan.valid.sum()
        assert np.median(np.abs(pair.scan.depth - pair.simulated.depth)[both]) < 0.3


@pytest.mark.usefixtures("recordings")
def test_an_interrupted_call_goes_on(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from lidardraft.training import pairs as disk

    whole = module._pair

    def interrupted(arguments: object, file: Path, *rest: object, **named: object) -> object:
        if file.stem == "000002":
            raise KeyboardInterrupt
        return whole(arguments, file, *rest, **named)  # type: ignore[arg-type]

    with monkeypatch.context() as once:
        once.setattr(module, "_pair", interrupted)
        once.setattr(disk, "SHARD", 1)
        assert cli.main(PAIRS) == 130
    assert len(PairFolder("out")) == 2
    capsys.readouterr()
    assert cli.main(PAIRS) == 0
    assert capsys.readouterr().out.splitlines() == [
        "out: goes on after the 2 pairs that are there",
        "out: 3 pairs, 1 of them new",
    ]


def test_what_does_not_fit_is_skipped_in_a_line_each(recordings: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points, intensity = kitti.read_bin(recordings / "velodyne" / "000000.bin")
    points[5] = np.nan
    rows = np.column_stack([points, intensity]).astype("<f4")
    (recordings / "velodyne" / "000000.bin").write_bytes(rows.tobytes())
    (recordings / "labels" / "000001.label").write_bytes(b"1234")
    np.savez(recordings / "velodyne" / "bare.npz", xyz=np.nan_to_num(points), label=np.ones(len(points), np.uint8))
    assert cli.main(PAIRS) == 0
    captured = capsys.readouterr()
    assert captured.out == "out: 1 pairs, 1 of them new, 3 scans skipped\n"
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
    assert cli.main(["pairs", "one.npz", "--sensor", "small.json", "-o", "npz"]) == 0
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
    assert "there is no .bin, .pcd or .npz file" in refused("pairs", "empty", "--sensor", "small.json", "-o", "out")
    assert "nothing.safetensors" in refused(*PAIRS, "--segmenter", "nothing.safetensors")
    Path("full").mkdir()
    Path("full/notes.txt").write_text("mine")
    assert "full is not empty (notes.txt)" in refused(*PAIRS[:-1], "full")


@pytest.mark.usefixtures("recordings")
def test_a_folder_of_another_sensor_is_refused(refused: Refused) -> None:
    assert cli.main(PAIRS) == 0
    small = Sensor.load("small.json")
    Path("small.json").write_text(Sensor(name="small", elevations=small.elevations, columns=64).to_json())
    assert "out holds pairs of another small; use another folder" in refused(*PAIRS)
    assert "out holds pairs of 'recordings, small'" in refused(*PAIRS[:3], "hdl32e", *PAIRS[4:])


@pytest.mark.usefixtures("recordings")
def test_a_sensor_that_did_not_record_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    elevations = tuple(np.deg2rad(np.linspace(2.5, -24, 21)).tolist())
    Path("finer.json").write_text(Sensor(name="finer", elevations=elevations, columns=128).to_json())
    assert cli.main(["pairs", "00", "--sensor", "finer.json", "-o", "other"]) == 0
    told = "the points lie between the beams of finer as often as on them; `lidardraft fit` makes a sensor of the scans"
    assert capsys.readouterr().err.count(told) == 1
    assert cli.main(["pairs", "00", "--sensor", "vlp16", "-o", "none"]) == 2
    assert "none: none of 3 scans became a pair" in capsys.readouterr().err
