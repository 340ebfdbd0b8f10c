"""The commands as a user types them, with the packaged weights."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, RangeImage, Sensor, pipeline
from lidardraft.cli import main as cli
from lidardraft.formats import kitti, semantickitti
from lidardraft.semantics import BY_NAME
from lidardraft.training.pairs import PairFolder

QUICK = ["--sensor", "small.json", "--steps", "2"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory with a small sensor."""
    monkeypatch.chdir(tmp_path)
    sensor = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)
    Path("small.json").write_text(sensor.to_json())
    return tmp_path


def refused(capsys: pytest.CaptureFixture[str], *argv: str) -> str:
    """The one line that bad input gets; nothing new may be on the disk."""
    before = sorted(Path().rglob("*"))
    assert cli.main(argv) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("lidardraft: ")
    assert captured.err.count("\n") == 1
    assert sorted(path for path in Path().rglob("*") if not path.is_dir()) == [p for p in before if not p.is_dir()]
    return captured.err


def test_draft_raycast_view(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead", "--seed", "0", "-o", "layout.json"]) == 0
    assert cli.main(["raycast", "layout.json", "--sensor", "hdl64e", "-o", "drawing.npz"]) == 0
    assert cli.main(["view", "drawing.npz"]) == 0
    assert "not understood" not in capsys.readouterr().err
    layout, condition_image = Layout.load("layout.json"), RangeImage.load("drawing.npz")
    assert [box.label for box in layout.boxes()] == ["car"]
    assert condition_image.sensor == Sensor.preset("hdl64e")
    assert BY_NAME["car"].id in condition_image.label
    assert Path("drawing.view.png").stat().st_size > 1000


def test_generate_from_text() -> None:
    assert cli.main(["generate", "--text", "a car ahead", "--seed", "3", "-n", "2", "-o", "out", *QUICK]) == 0
    names = {
        f"{number}{end}"
        for number in ("000000", "000001")
        for end in (".bin", ".label", ".boxes.json", ".layout.json", ".png")
    }
    assert {path.name for path in Path("out").iterdir()} == names
    points, intensity = kitti.read_bin("out/000000.bin")
    label, _ = semantickitti.read_label("out/000000.label", len(points))
    assert len(points) > 200
    assert 0 <= intensity.min() <= intensity.max() <= 1
    assert (label == BY_NAME["road"].id).any()
    first, second = (Layout.load(f"out/00000{k}.layout.json") for k in range(2))
    assert first != second  # another seed, another layout
    fields = json.loads(Path("out/000000.layout.json").read_text())["primitives"][0]
    assert {"shape", "center", "size", "yaw", "label", "id", "instance"} <= set(fields)


def test_generate_again_gives_the_same_scan() -> None:
    cli.main(["draft", "--text", "two cars behind", "-o", "layout.json"])
    for out in ("a", "b"):
        assert cli.main(["generate", "--layout", "layout.json", "-o", out, *QUICK]) == 0
    assert Path("a/000000.bin").read_bytes() == Path("b/000000.bin").read_bytes()
    assert cli.main(["generate", "--layout", "layout.json", "--seed", "1", "-o", "c", *QUICK]) == 0
    assert Path("a/000000.bin").read_bytes() != Path("c/000000.bin").read_bytes()


def test_generate_from_a_labelled_scan() -> None:
    cli.main(["generate", "--text", "a car ahead and houses on both sides", "-o", "out", *QUICK])
    source = ["--points", "out/000000.bin", "--labels", "out/000000.label"]
    assert cli.main(["generate", *source, "-o", "again", *QUICK]) == 0
    layout = Layout.load("again/000000.layout.json")
    assert "road" in {primitive.label for primitive in layout}
    assert len(kitti.read_bin("again/000000.bin")[0]) > 200
    assert cli.main(["view", "again/000000.bin", "--sensor", "small.json"]) == 0


def test_words_not_understood_are_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead and a purple dinosaur", "-o", "layout.json"]) == 0
    assert "dinosaur" in capsys.readouterr().err


def test_bad_input_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert "xyzzy" in refused(capsys, "draft", "--text", "xyzzy", "-o", "layout.json")
    assert "nowhere.json" in refused(capsys, "raycast", "nowhere.json", "-o", "a.npz")
    Path("broken.json").write_text('{"schema": ')
    assert "broken.json: not JSON" in refused(capsys, "raycast", "broken.json", "-o", "a.npz")
    assert "hdl65" in refused(capsys, "generate", "--text", "a car ahead", "--sensor", "hdl65", "-o", "out")
    Path("short.bin").write_bytes(b"12345")
    Path("short.label").write_bytes(b"1234")
    short = ["--points", "short.bin", "--labels", "short.label", "-o", "out"]
    assert "short.bin" in refused(capsys, "generate", *short)
    assert "--labels" in refused(capsys, "generate", "--points", "short.bin", "-o", "out")
    assert "weights" in refused(capsys, "generate", "--text", "a car ahead", "--weights", "none", "-o", "out")
    Path("not.safetensors").write_bytes(b"not weights at all")
    strange = refused(capsys, "generate", "--text", "a car ahead", "--weights", "not.safetensors", "-o", "out")
    assert "not.safetensors" in strange
    assert "cannot draw" in refused(capsys, "view", "small.txt")
    device = ["--text", "a car ahead", "--device", "abacus", "-o", "out"]
    assert "abacus" in refused(capsys, "generate", *device)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"size": [4, 2, 0]}, "every extent must be > 0"),
        ({"size": [4, 2]}, "size"),
        ({"center": [0, 0, float("nan")]}, "center"),
        ({"yaw": float("inf")}, "yaw"),
        ({"label": "unicorn"}, "unicorn"),
        ({"shape": "blob"}, "blob"),
        ({"colour": "red"}, "colour"),
        ({"shape": "mesh", "vertices": [[0, 0, float("nan")]] * 3, "faces": [[0, 1, 2]]}, "vertex 0"),
        ({"shape": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 7]]}, "face 0"),
    ],
)
def test_bad_layouts_are_one_line(capsys: pytest.CaptureFixture[str], change: dict[str, object], said: str) -> None:
    car = {
        "shape": "box",
        "center": [9, 0, 1],
        "size": [4, 2, 2],
        "yaw": 0,
        "label": "car",
        "id": "car_1",
        "instance": 1,
    }
    document = {"schema": "lidardraft.layout/1", "primitives": [{**car, **change}]}
    Path("layout.json").write_text(json.dumps(document))
    for command in (["raycast", "layout.json", "-o", "a.npz"], ["generate", "--layout", "layout.json", "-o", "out"]):
        message = refused(capsys, *command)
        assert "layout.json" in message
        assert said in message


def test_truncated_files_are_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    cli.main(["generate", "--text", "a car ahead", "-o", "out", *QUICK])
    points, label = Path("out/000000.bin"), Path("out/000000.label")
    source = ["--points", str(points), "--labels", str(label), "-o", "again"]
    label.write_bytes(label.read_bytes()[:-4])
    assert "000000.label" in refused(capsys, "generate", *source)
    points.write_bytes(points.read_bytes()[:-3])
    assert "000000.bin" in refused(capsys, "generate", *source)
    weights = Path("cut.safetensors")
    weights.write_bytes((Path(pipeline.__file__).parent / "weights/street.safetensors").read_bytes()[:-100])
    assert "cut.safetensors" in refused(capsys, "generate", "--text", "a car", "--weights", str(weights), "-o", "b")


@pytest.mark.parametrize("argv", [["--help"], ["generate", "--help"]])
def test_help_loads_nothing_heavy(argv: list[str]) -> None:
    run = (
        "import sys; from lidardraft.cli.main import main\n"
        f"try: main({argv!r})\n"
        "except SystemExit: print(sorted({'torch', 'sklearn', 'lark', 'scipy', 'PIL'} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, "-c", run], capture_output=True, text=True, check=True)
    assert "usage: lidardraft" in result.stdout
    assert result.stdout.endswith("[]\n")


def test_streets_on_disk_go_on_where_they_stopped(capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["streets", "--sensor", "small.json", "--seed", "3", "--workers", "1", "--out", "pairs"]
    assert cli.main([*argv, "--num", "2"]) == 0
    first = PairFolder("pairs")
    assert cli.main([*argv, "--num", "5"]) == 0
    pairs = PairFolder("pairs")
    assert [note["index"] for note in pairs.notes] == [0, 1, 2, 3, 4]
    assert {note["style"]["source"] for note in pairs.notes} <= {"text", "cloud", "picture", "boxes"}
    np.testing.assert_array_equal(pairs[1][0].depth, first[1][0].depth)
    assert cli.main([*argv, "--num", "3"]) == 0  # enough are there
    assert len(PairFolder("pairs")) == 5
    assert cli.main(["streets", "--out", "pairs", "--sensor", "small.json", "--num", "9"]) == 2
    assert "seed 3" in capsys.readouterr().err


def test_streets_to_look_at(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["streets", "--sensor", "small.json", "--workers", "1", "-n", "2", "--look"]) == 0
    assert capsys.readouterr().out == "streets.png\n"
    assert Path("streets.png").stat().st_size > 1000
    assert "say --out FOLDER" in refused(capsys, "streets", "-n", "2")
