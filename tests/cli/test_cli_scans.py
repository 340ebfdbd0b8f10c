"""`lidardraft simulate`, `generate` with the packaged weights, `observe`, and the folders of scans that they write."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft import (
    Layout,
    Primitive,
    RangeImage,
    Scan,
    Sensor,
    layout_from_text,
    observe_cast,
    pipeline,
    simulate,
    surround,
)
from lidardraft.arranging.district import DISTRICTS
from lidardraft.cli import main as cli
from lidardraft.files import locked_folder
from lidardraft.formats import kitti, semantickitti
from lidardraft.formats.boxes import read_boxes
from lidardraft.formats.carla import carla_sensor
from lidardraft.scan import SCAN_ENDINGS
from lidardraft.scene.scenario import Scenario, Straight
from lidardraft.semantics import BY_NAME, CLASSES
from lidardraft.streets import StreetConfig, StreetMix, street_scan

SMALL = ["--sensor", "small.json", "--carrier", "none"]
BARE = [*SMALL, "--surroundings", "bare"]
QUICK = ["--weights", "paper-small", "--sensor", "small.json", "--steps", "2"]
SIMULATE = ["simulate", "--text", "a car ahead", "-o", "out", "--sensor", "small.json"]


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
        fences = np.where(expected.labels() == BY_NAME["wall"].id, BY_NAME["fence"].id, expected.labels())
        np.testing.assert_array_equal(label, fences)  # SemanticKITTI has no walls
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


def test_bad_input_of_simulate_is_one_line(refused: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    command = ["simulate", "--text", "a car ahead", "-o", "out", *SMALL]
    assert "did you mean 'snow'?" in refused(*command, "--weather", "snwo:2mm")
    assert "it must be rain and an amount, as in rain:0.5mm" in refused(*command, "--weather", "rain:10m")
    assert "it must be fog and an amount" in refused(*command, "--weather", "fog")
    assert "--weather has rain twice" in refused(*command, "--weather", "rain:1mm", "--weather", "rain:2mm")
    assert "wetness is 7.0; it must be 0 to 1" in refused(*command, "--weather", "wet:7")
    assert "visibility is 0.0" in refused(*command, "--weather", "fog:0m")
    with pytest.raises(SystemExit):
        cli.main([*command, "--speed", "nan"])
    assert "'nan' is not a number" in capsys.readouterr().err


def test_a_layout_without_ground_is_said_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    Layout().save("empty.json")
    assert cli.main(["simulate", "--layout", "empty.json", "-n", "2", "-o", "out", *SMALL]) == 0
    err = capsys.readouterr().err
    assert err == "lidardraft: the layout has no ground (road, sidewalk or terrain): nothing returns from it\n"


DRIVES = ["simulate", "--street", "residential", "--seed", "7", *SMALL]
STREET = [*DRIVES, "--poses", "2"]


def test_streets_are_scanned(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*STREET, "-n", "5", "--pictures", "2", "-o", "out"]) == 0
    assert "each with .label and .boxes.json; the first 2 with .png" in capsys.readouterr().out
    pictured = {f"00000{k}{end}" for k in range(5) for end in SCAN_ENDINGS if end != ".png" or k < 2}
    assert names("out") == pictured
    shares = {name: float(name == "residential") for name in DISTRICTS}
    config = StreetConfig(sensor=Sensor.load("small.json"), poses_per_street=2, mix=StreetMix(**shares))
    for number in (0, 3):
        scan, layout = street_scan(number, seed=7, config=config), Layout.load(f"out/00000{number}.layout.json")
        points, _ = kitti.read_bin(f"out/00000{number}.bin")
        np.testing.assert_array_equal(points, scan.points())
        assert layout == scan.layout
        assert layout.intent.district == "residential"
        label, instance = semantickitti.read_label(f"out/00000{number}.label", len(points))
        boxes, counts = read_boxes(f"out/00000{number}.boxes.json")
        assert counts == [np.count_nonzero(instance == box.instance) for box in boxes]
        assert sum(counts) > 0.9 * np.isin(label, [row.id for row in CLASSES if row.is_thing]).sum() > 0


def test_drives_come_in_folders_and_become_one_data_set(refused: Callable[..., str]) -> None:
    Path("lines.txt").write_text("a car ahead\na van behind\n")
    lines = ["simulate", "--text-file", "lines.txt", *BARE]
    for name, command in {"street": DRIVES, "lines": lines}.items():
        more = ["--frames", "2", "--pictures", "1"]
        assert cli.main([*command, *more, "-n", "2", "--jobs", "2", "-o", name]) == 0
        files = [path.relative_to(name) for path in sorted(Path(name).rglob("*")) if path.is_file()]
        assert {path.parent.name for path in files} == {"000000", "000001"}
        assert [path.name for path in files if path.suffix == ".png"] == ["000000.png"]
        assert cli.main([*command, *more, "-n", "1", "-o", f"{name}-again"]) == 0
        for path in files:
            if path.parent.name == "000000":
                assert Path(name, path).read_bytes() == Path(f"{name}-again", path).read_bytes()
    assert cli.main(["export", "lines", "--format", "nuscenes", "-o", "set"]) == 0
    scenes = json.loads(Path("set/v1.0-trainval/scene.json").read_text())
    assert [row["nbr_samples"] for row in scenes] == [2, 2]
    assert "is not empty" in refused(*lines, "--frames", "2", "-n", "2", "-o", "lines")
    assert cli.main([*lines, "--frames", "2", "-n", "1", "-o", "lines", "--overwrite"]) == 0
    assert {path.name for path in Path("lines").iterdir() if path.is_dir()} == {"000000"}


def test_a_word_that_sentences_know_names_a_district() -> None:
    assert cli.main(["simulate", "--street", "downtown", *SMALL, "--no-picture", "-o", "out"]) == 0
    assert Layout.load("out/000000.layout.json").intent.district == "urban"


def test_scans_do_not_depend_on_the_number_of_processes_or_of_scans(capsys: pytest.CaptureFixture[str]) -> None:
    Path("lines.txt").write_text("a car ahead\n\ntwo cars behind and a wibble\n")
    commands = {"street": STREET, "lines": ["simulate", "--text-file", "lines.txt", *BARE]}
    for name, command in commands.items():
        for options in (["-n", "3", "--jobs", "2"], ["-n", "2", "--jobs", "1"]):
            assert cli.main([*command, *options, "--no-picture", "-o", f"{name}-{options[1]}"]) == 0
        few, many = Path(f"{name}-2"), Path(f"{name}-3")
        assert names(str(many)) == {f"00000{k}{end}" for k in range(3) for end in SCAN_ENDINGS if end != ".png"}
        for path in few.iterdir():
            assert path.read_bytes() == (many / path.name).read_bytes()
    err = capsys.readouterr().err
    assert err.count("lidardraft: lines.txt, line 3: not understood: wibble") == 2  # once a call


def test_every_sentence_of_a_file_becomes_a_scan(refused: Callable[..., str]) -> None:
    Path("lines.txt").write_text("a car ahead\ntwo cars behind\n")
    assert cli.main(["simulate", "--text-file", "lines.txt", "--seed", "4", "-o", "out", *SMALL]) == 0
    layouts = [Layout.load(f"out/00000{k}.layout.json") for k in range(2)]
    bare = [layout_from_text("a car ahead", seed=4), layout_from_text("two cars behind", seed=5)]
    for seed, (scanned, layout) in enumerate(zip(layouts, bare, strict=True), start=4):
        assert {part.id for part in surround(layout, seed=seed)} <= {part.id for part in scanned}
    assert not Path("out/000002.bin").exists()
    Path("bad.txt").write_text("\nxyzzy\n")
    assert "bad.txt, line 2: " in refused("simulate", "--text-file", "bad.txt", "-o", "new", *SMALL)
    Path("empty.txt").write_text(" \n")
    assert "empty.txt holds no sentence" in refused("generate", "--text-file", "empty.txt", "-o", "new", *SMALL[:2])


def test_bad_input_of_streets_is_one_line(refused: Callable[..., str]) -> None:
    assert "--speed goes with a layout" in refused(*STREET, "-o", "out", "--speed", "3")
    assert "--surroundings goes with a layout" in refused(*STREET, "-o", "out", "--surroundings", "bare")
    assert "--poses goes with --street" in refused(*SIMULATE, "--poses", "3")
    assert "--labels goes with --points" in refused(*STREET, "-o", "out", "--labels", "a.label")
    assert "did you mean 'residential'?" in refused("simulate", "--street", "residental", "-o", "out")
    assert "--scenario goes with a layout" in refused(*DRIVES, "-o", "out", "--frames", "2", "--scenario", "a.json")
    assert "--poses does not go with --frames" in refused(*STREET, "-o", "out", "--frames", "2", "--poses", "2")
    for command in ("draft", "generate"):
        with pytest.raises(SystemExit):
            cli.main([command, "--street", "any", "-o", "out"])


def test_it_rains_on_streets_too() -> None:
    for name, options in {"dry": [], "rain": ["--weather", "fog:20m"]}.items():
        assert cli.main([*STREET, "-o", name, "--no-picture", *options]) == 0
    far = [np.linalg.norm(kitti.read_bin(f"{name}/000000.bin")[0], axis=1).max() for name in ("dry", "rain")]
    assert far[1] < far[0]


def names(folder: str) -> set[str]:
    return {path.name for path in Path(folder).iterdir()}


def test_generate_from_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["generate", "--text", "a car ahead", "--seed", "3", "-n", "2", "-o", "out", *QUICK]) == 0
    assert names("out") == {f"{number}{end}" for number in ("000000", "000001") for end in SCAN_ENDINGS}
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


def test_generate_from_a_labelled_scan() -> None:
    cli.main(["generate", "--text", "a car ahead and houses on both sides", "-o", "out", *QUICK])
    source = ["--points", "out/000000.bin", "--labels", "out/000000.label"]
    assert cli.main(["generate", *source, "-o", "again", *QUICK]) == 0
    layout = Layout.load("again/000000.layout.json")
    assert "road" in {primitive.label for primitive in layout}
    assert len(kitti.read_bin("again/000000.bin")[0]) > 200


def test_generate_stands_in_a_street_unless_it_is_bare() -> None:
    command = ["generate", "--text", "a car ahead", *QUICK]
    assert cli.main([*command, "-o", "street"]) == 0
    street = {part.id for part in surround(layout_from_text("a car ahead"))}
    assert street <= {part.id for part in Layout.load("street/000000.layout.json")}
    assert cli.main([*command, "--surroundings", "bare", "-o", "bare"]) == 0
    assert Layout.load("bare/000000.layout.json") == layout_from_text("a car ahead")


def test_bad_weights_and_devices_are_one_line(refused: Callable[..., str]) -> None:
    generate = ["generate", "--text", "a car ahead", "-o", "out"]
    assert "did you mean 'paper'?" in refused(*generate, "--weights", "papers")
    Path("not.safetensors").write_bytes(b"not weights at all")
    assert "not.safetensors" in refused(*generate, "--weights", "not.safetensors")
    weights = Path("cut.safetensors")
    weights.write_bytes((Path(pipeline.__file__).parent / "weights/paper-small.safetensors").read_bytes()[:-100])
    assert "cut.safetensors" in refused(*generate, "--weights", str(weights))
    assert "abacus" in refused(*generate, "--device", "abacus")


def test_one_scan_shows_its_progress(shown_on_a_terminal: Callable[..., str]) -> None:
    shown = shown_on_a_terminal("generate", "--text", "a car ahead", "-o", "out", *QUICK)
    assert "1 scan: " in shown
    assert "1/2" in shown
    assert "2/2" in shown
    assert "\rlidardraft: these weights" in shown  # on a line of its own


def test_the_speed_of_the_sensor_is_that_of_the_scan() -> None:
    text = "houses along both sides"
    assert cli.main(["generate", "--text", text, "--speed", "20", "-o", "out", *QUICK]) == 0
    small = pipeline.Pipeline.from_pretrained("paper-small", steps=2)
    with pytest.warns(UserWarning, match="its scans may be poor"):
        expected = small(text, sensor=Sensor.load("small.json"), speed=20.0)
    np.testing.assert_array_equal(kitti.read_bin("out/000000.bin")[0], expected.points())


def test_guidance_is_that_of_the_pipeline() -> None:
    options = ["--guidance", "3", "-o", "out", *QUICK]
    assert cli.main(["generate", "--text", "a car ahead", *options]) == 0
    paper = pipeline.Pipeline.from_pretrained("paper-small", steps=2, guidance=3.0)
    with pytest.warns(UserWarning, match="its scans may be poor"):
        expected = paper("a car ahead", sensor=Sensor.load("small.json"))
    np.testing.assert_array_equal(kitti.read_bin("out/000000.bin")[0], expected.points())


def test_generate_from_a_semantic_map(capsys: pytest.CaptureFixture[str], refused: Callable[..., str]) -> None:
    label = simulate(layout_from_text("a car ahead"), Sensor.load("small.json")).image.label
    np.save("map.npy", label)
    argv = ["generate", "--map", "map.npy", "-n", "2", "-o", "out", *QUICK]
    assert cli.main(argv) == 0
    assert "out: 2 scans, 000000.bin to 000001.bin, each with .label and .png" in capsys.readouterr().out
    with pytest.warns(UserWarning, match="its scans may be poor"):
        expected = pipeline.Pipeline.from_pretrained("paper-small", steps=2).from_map(
            label, sensor=Sensor.load("small.json"), seed=1
        )
    np.testing.assert_array_equal(kitti.read_bin("out/000001.bin")[0], expected.points())
    paper = [*argv, "--overwrite"]
    assert "--speed and --surroundings go with a layout; a semantic map has none" in refused(*paper, "--speed", "3")
    np.save("map.npy", label[:8])
    assert "map.npy: the map is uint32 (8, 128); small needs whole numbers (16, 128)" in refused(*paper)
    assert "--labels goes with --points" in refused(*paper, "--labels", "map.label")


@pytest.fixture
def cast() -> RangeImage:
    """A cast of ours, in cast.npz."""
    cli.main(["raycast", "--text", "a car ahead", "--sensor", "small.json", "-o", "cast.npz"])
    return RangeImage.load("cast.npz")


def test_casts_are_observed_in_their_order(cast: RangeImage, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--material", "car=dark-paint", "--weather", "wet:1", "--seed", "5"]
    assert cli.main(["observe", "cast.npz", "cast.npz", "-o", "out", *options]) == 0
    names = {f"00000{k}{end}" for k in range(2) for end in SCAN_ENDINGS}
    assert {path.name for path in Path("out").iterdir()} == {*names, "casts.json"}
    said = "out: 2 scans, 000000.bin to 000001.bin, each with .label, .boxes.json and .png; casts.json"
    assert said in capsys.readouterr().out
    points, intensity = kitti.read_bin("out/000000.bin")
    label, instance = semantickitti.read_label("out/000000.label", len(points))
    assert 0 < len(points) <= cast.valid.sum()
    assert len(np.unique(intensity)) > 3
    assert set(label) <= set(np.unique(cast.label))
    assert set(instance) <= set(np.unique(cast.instance))
    assert Path("out/000001.bin").read_bytes() != Path("out/000000.bin").read_bytes()
    assert cli.main(["observe", "cast.npz", "-o", "out", "--overwrite"]) == 0
    names = {f"000000{end}" for end in SCAN_ENDINGS}
    assert {path.name for path in Path("out").iterdir()} == {*names, "casts.json"}


@pytest.mark.usefixtures("cast")
def test_objects_of_a_cast_that_comes_without_any_are_found_by_their_classes(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("cast.layout.json").unlink()
    assert cli.main(["observe", "cast.npz", "-o", "out"]) == 0
    assert "each with .label and .png; casts.json" in capsys.readouterr().out
    assert cli.main(["edit", "out/000000.bin"]) == 0
    assert "car_1: car at " in capsys.readouterr().out


def test_a_cast_without_a_sensor_is_of_the_one_given(cast: RangeImage, refused: Callable[..., str]) -> None:
    np.savez("bare.npz", depth=cast.depth, label=cast.label.astype(np.int64))
    assert "bare.npz: it does not name its sensor" in refused("observe", "bare.npz", "-o", "out")
    assert cli.main(["observe", "bare.npz", "--sensor", "small.json", "-o", "out"]) == 0
    expected = observe_cast(cast.depth, cast.label, Sensor.load("small.json"))
    np.testing.assert_array_equal(kitti.read_bin("out/000000.bin")[0], expected.points())


def test_clouds_of_carla_are_observed(refused: Callable[..., str]) -> None:
    Path("carla.json").write_text(carla_sensor(channels=4, points_per_second=14400, max_range=50.0).to_json())
    fields = ("float32 x", "float32 y", "float32 z", "float32 CosAngle", "uint32 ObjIdx", "uint32 ObjTag")
    head = ["ply", "format ascii 1.0", "element vertex 2", *(f"property {field}" for field in fields), "end_header"]
    rows = ["9.8481 0.0000 1.7365 0.9000 31 14", "8.6603 0.0000 -5.0000 0.5000 0 1"]
    Path("a.ply").write_text("\n".join([*head, *rows, ""]))
    assert "a.ply does not name its sensor; give its --sensor" in refused("observe", "a.ply", "-o", "out")
    assert cli.main(["observe", "a.ply", "--sensor", "carla.json", "-o", "out"]) == 0
    points, _ = kitti.read_bin("out/000000.bin")
    np.testing.assert_allclose(points, [[9.85, 0, 1.74], [8.66, 0, -5.0]], atol=0.2)
    label, instance = semantickitti.read_label("out/000000.label", 2)
    assert label.tolist() == [13, 1]
    assert instance.tolist() == [31, 0]


def test_bad_input_of_observe_is_one_line(cast: RangeImage, refused: Callable[..., str]) -> None:
    command = ["observe", "cast.npz", "-o", "out"]
    assert "--material is 'car'; it must be CLASS=MATERIAL" in refused(*command, "--material", "car")
    assert "the material of car is 'cheese'" in refused(*command, "--material", "car=cheese")
    assert "did you mean 'rain'?" in refused(*command, "--weather", "rian:1mm")
    np.savez("many.npz", depth=cast.depth, label=cast.label, instance=np.full(cast.depth.shape, 70_000))
    message = refused("observe", "many.npz", "--sensor", "small.json", "-o", "out")
    assert "out/000000.label: point 0 has instance 70000; it must be 0 to 65535" in message
    depth = cast.depth.copy()
    depth[2, 3] = np.nan
    np.savez("nan.npz", depth=depth, label=cast.label)
    message = refused("observe", "nan.npz", "--sensor", "small.json", "-o", "out")
    assert "nan.npz: depth is nan in row 2, column 3" in message
    assert "none.npz: No such file" in refused("observe", "none.npz", "-o", "out")


def test_scans_are_replaced_only_where_that_is_said(refused: Callable[..., str]) -> None:
    assert cli.main([*SIMULATE, "-n", "2"]) == 0
    Path("out/notes.txt").write_text("mine")
    Path("out/000007.bin").write_bytes(b"a scan that no layout lies beside")
    before = Path("out/000000.bin").read_bytes()
    message = refused(*SIMULATE, "--seed", "9")
    assert "out is not empty (000000.bin and" in message
    assert "--overwrite" in message
    assert cli.main([*SIMULATE, "--seed", "9", "--overwrite"]) == 0
    names = {path.name for path in Path("out").iterdir()}
    assert names == {*(f"000000{end}" for end in SCAN_ENDINGS), "notes.txt", "000007.bin"}
    assert Path("out/000000.bin").read_bytes() != before


def test_a_folder_has_one_writer(refused: Callable[..., str]) -> None:
    Path("out").mkdir()
    with locked_folder(Path("out")):
        assert "out is being written by process" in refused(*SIMULATE)
        assert "out is being written by process" in refused(*SIMULATE, "--overwrite")


@pytest.mark.parametrize("command", ["simulate", "generate"])
def test_what_fails_replaces_nothing(refused: Callable[..., str], command: str) -> None:
    assert cli.main(SIMULATE) == 0
    assert "xyzzy" in refused(command, "--text", "xyzzy", "-o", "out", "--overwrite")
    again = [command, "--text", "a car ahead", "-o", "out", "--overwrite"]
    assert "smal.json: No such file" in refused(*again, "--sensor", "smal.json")
    Path("file").write_text("")
    assert "file is a file; it must be a folder" in refused(command, "--text", "a car ahead", "-o", "file")


def test_a_sequence_is_a_folder_of_frames_with_tracks_and_a_film(capsys: pytest.CaptureFixture[str]) -> None:
    road = Primitive(shape="plane", center=(0, 0, 0), size=(200, 8, 0), label="road", id="road")
    car = Primitive(shape="box", center=(14, 0, 0.76), size=(4, 1.8, 1.5), label="car", id="car_1", instance=1)
    Layout((road, car)).save("layout.json")
    Scenario(None, {"car_1": Straight(9.0)}).save("scenario.json")
    asked = ["simulate", "--layout", "layout.json", "--sensor", "small.json", "--scenario", "scenario.json"]
    asked += ["--frames", "4", "--hz", "5", "--speed", "6", "--no-picture"]
    assert cli.main([*asked, "-o", "one"]) == 0
    assert cli.main([*asked, "-o", "two", "--jobs", "2"]) == 0
    assert "one: 4 scans, 000000.bin to 000003.bin" in capsys.readouterr().out
    names = sorted(path.name for path in Path("one").iterdir())
    assert {"poses.txt", "times.txt", "tracks.json", "000003.boxes.json"} < set(names)
    for name in names:
        if not name.endswith(".npz"):
            assert Path("one", name).read_bytes() == Path("two", name).read_bytes(), name
    scans = [Scan.load(f"one/{number:06d}") for number in range(4)]
    assert [scan.pose[0, 3] for scan in scans] == pytest.approx([0.3, 1.5, 2.7, 3.9], abs=0.01)
    assert [box.center[0] for box in scans[3].boxes()] == pytest.approx([14 + 3 * 0.65], abs=0.02)
    assert cli.main(["view", "one"]) == 0
    with Image.open("one/view.gif") as film:
        assert (film.n_frames, film.info["duration"]) == (4, 200)
        above_and_seat = np.asarray(film.convert("RGB"), np.float32)
    av = pytest.importorskip("av")
    assert cli.main(["view", "one", "-o", "film.mp4"]) == 0
    with av.open("film.mp4") as film:
        assert film.streams.video[0].average_rate == 5
        shown = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(shown) == 4
    assert np.abs(shown[0] - above_and_seat).mean() < 8  # of 255
    assert cli.main(["export", "one", "--format", "semantickitti", "-o", "kitti"]) == 0
    assert np.loadtxt("kitti/sequences/00/times.txt") == pytest.approx([0.0, 0.2, 0.4, 0.6])
    one_scan = ["simulate", "--layout", "layout.json", "--sensor", "small.json", "--no-picture", "-o", "one"]
    assert cli.main([*one_scan, "--overwrite"]) == 0  # and nothing is left of the four
    of_others = {"view.gif"}
    assert {path.name for path in Path("one").iterdir()} - of_others == {n for n in names if n.startswith("000000.")}


def test_a_sequence_in_which_nothing_moves_is_said_to_be_one(capsys: pytest.CaptureFixture[str]) -> None:
    Layout((Primitive(shape="plane", center=(0, 0, 0), size=(60, 60, 0), label="terrain", id="land"),)).save(
        "land.json"
    )
    asked = ["simulate", "--layout", "land.json", *SMALL, "--frames", "2", "--no-picture", "-o", "out"]
    assert cli.main(asked) == 0
    assert "nothing moves: the layout has no road with known lanes" in capsys.readouterr().err


def test_a_sequence_says_that_its_lanes_are_guessed(capsys: pytest.CaptureFixture[str]) -> None:
    road = Primitive(shape="plane", center=(0, 1.75, 0), size=(120, 7, 0), label="road", id="asphalt")
    Layout((road,)).save("road.json")
    asked = ["simulate", "--layout", "road.json", *SMALL, "--frames", "2", "--no-picture", "-o", "out"]
    assert cli.main(asked) == 0
    told = capsys.readouterr().err
    assert told.count("the lanes of its road are guessed from its shapes") == 1
    assert "nothing moves" not in told
    assert Layout.load("out/000001.layout.json").notes == ("the lanes of its road are guessed from its shapes",)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--hz", "5"], "--hz is for a sequence; give its length with --frames"),
        (["--frames", "3", "--hz", "20"], "hz is 20; a sweep of small takes 0.1 s"),
        (["--frames", "3", "--scenario", "wrong.json"], "wrong.json: the layout has no object 'car_9'"),
        (["--frames", "3", "--scenario", "none.json"], "none.json: No such file"),
    ],
)
def test_sequences_that_cannot_be_are_one_line(more: list[str], said: str, refused: Callable[..., str]) -> None:
    road = Primitive(shape="plane", center=(0, 0, 0), size=(200, 8, 0), label="road", id="road")
    Layout((road,)).save("layout.json")
    Scenario(None, {"car_9": Straight(9.0)}).save("wrong.json")
    assert said in refused("simulate", "--layout", "layout.json", "--sensor", "small.json", *more, "-o", "out")
    assert not Path("out").exists()
