"""`lidardraft dataset`: a recipe becomes shards, by any processes and after any crash the same ones."""

import contextlib
import gc
import hashlib
import json
import math
import os
import random
import re
import signal
import tarfile
import time
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from processes import Command, wait_for

import lidardraft
from lidardraft import Scan, layout_from_text, surround
from lidardraft.cli import main as cli
from lidardraft.dataset import recipe as recipes
from lidardraft.dataset.recipe import Recipe
from lidardraft.dataset.table import Table, drawn, every
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.formats.frame import FORMATS
from lidardraft.networks.weight_header import PACKAGED

RECIPE = """
scans = 20
seed = 4
shard_size = 3
poses = 2

[[scene]]
share = 2
text = ["{count} cars ahead, a bus {distance} m behind", "{count} pedestrians on the sidewalk on the {side}"]
words.count = { from = 2, to = 4 }
words.distance = { from = 10.0, to = 30.0 }
words.side = ["left", "right"]
surroundings = "bare"
speed = [0, { from = 3.0, to = 14.0 }]
[[scene.edit]]
remove = "car_1"
chance = 0.5
[[scene.edit]]
move = "bus_*"
left = [-2.5, 2.5]

[[scene]]
street = ["urban", "country"]
traffic = { from = 0.5, to = 2.0 }

[[scene]]
layout = "*.layout.json"

[[sensor]]
name = "small.json"
mount_height = { from = 1.6, to = 2.2 }

[[weather]]
share = 3
[[weather]]
rain = { from = 5, to = 20 }
wetness = 1.0
"""


@cache
def truck() -> str:
    """A layout of a text."""
    return surround(layout_from_text("a truck ahead"), seed=0).to_json()


@pytest.fixture(autouse=True)
def recipe(folder: Path) -> Path:
    """recipe.toml, and a layout for it."""
    Path("a.layout.json").write_text(truck())
    path = folder / "recipe.toml"
    path.write_text(RECIPE)
    return path


@pytest.fixture
def start(folder: Path) -> Iterator[Callable[..., Command]]:
    commands: list[Command] = []

    def begin(*argv: str) -> Command:
        commands.append(Command("dataset", "recipe.toml", *argv, folder=folder))
        return commands[-1]

    yield begin
    for command in commands:
        command.stop()


def made(*argv: str) -> dict[str, str]:
    """The checksums of the files of the set that a call makes, but those of locks."""
    assert cli.main(["dataset", "recipe.toml", *argv]) == 0
    return files(argv[argv.index("-o") + 1])


def files(folder: str) -> dict[str, str]:
    paths = [path for path in Path(folder).rglob("*") if path.is_file() and not path.name.startswith(".lock")]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def test_a_scan_depends_on_the_seed_and_its_number_alone() -> None:
    one = Recipe.load("recipe.toml")
    again = Recipe.load("recipe.toml", 1000)  # as many as others want
    numbers = [17, 2, 9, 2, 16, 3]
    scans = {k: one.scan(k) for k in sorted(numbers)}
    for k in numbers:
        scan = again.scan(k)
        np.testing.assert_array_equal(scan.points(), scans[k].points())
        assert scan.layout == scans[k].layout
        assert scan.layout.provenance == scans[k].layout.provenance
    assert not np.array_equal(scans[2].points()[:50], scans[3].points()[:50])


def test_scenes_sensors_and_weather_come_as_often_as_their_shares_say(recipe: Path) -> None:
    """Of n draws with probability p, n * p come, within five deviations of sqrt(n * p * (1 - p))."""
    layout = '[[scene]]\nshare = {}\nlayout = "bare.json"\n'
    layout_from_text("a truck ahead").save("bare.json")
    sensor = '[[sensor]]\nshare = {}\nname = "small.json"\nmount_height = {}\n'
    shares, num = (1, 7, 0), 64
    text = "".join(layout.format(share) for share in shares)
    text += "".join(sensor.format(share, height) for share, height in zip(shares, (1.5, 2.0, 2.5), strict=True))
    recipe.write_text(f"seed = 3\n{text}[[weather]]\nshare = 1\n[[weather]]\nshare = 7\nwetness = 1.0\n")
    loaded = Recipe.load(recipe, num)
    found: Counter[str] = Counter()
    for scan in map(loaded.scan, range(num)):
        told = scan.layout.provenance["recipe"]
        found.update([f"scene {told['scene']}", f"sensor {scan.image.sensor.mount_height}", f"wet {told['weather']}"])
    bound = 5 * math.sqrt(num * (1 / 8) * (7 / 8))  # 13.2 around 8 and 56; of equal shares 21 or 32 come
    rare, usual = ["scene 1", "sensor 1.5", "wet {}"], ["scene 2", "sensor 2.0", "wet {'wetness': 1.0}"]
    assert found.keys() == {*rare, *usual}
    assert all(abs(found[name] - num / 8) < bound for name in rare), found


DRIVES = """
drives = 5
frames = 3
hz = 5
format = "{}"
[split]
train = 0.6
val = 0.2
test = 0.2
[[scene]]
street = ["downtown", "village"]
riders = 2.0
[[scene]]
share = 3
text = "a bus 20 m ahead, two cyclists behind it"
surroundings = "bare"
[[sensor]]
name = "small.json"
"""


def test_recipes_of_drives_are_split_by_drive(recipe: Path) -> None:
    recipe.write_text(DRIVES.format("nuscenes"))
    whole = made("-o", "set", "--jobs", "1")
    tables = {path.stem: json.loads(path.read_text()) for path in Path("set/nuscenes/v1.0-trainval").glob("*.json")}
    assert [(row["name"], row["nbr_samples"]) for row in tables["scene"]] == [
        (f"scene-{k:04d}", 3) for k in range(1, 6)
    ]
    assert sorted(scene for scenes in tables["splits"].values() for scene in scenes) == [
        f"scene-{k:04d}" for k in range(1, 6)
    ]
    # the devkit looks up other names than its own "train", "val" and "test"
    parts = {name.removeprefix("lidardraft_"): scenes for name, scenes in tables["splits"].items()}
    assert not parts.keys() & tables["splits"].keys()
    assert {name: len(scenes) for name, scenes in parts.items()} == {"train": 3, "val": 1, "test": 1}
    scans = json.loads(Path("set/splits.json").read_text())
    for name, scenes in parts.items():
        numbers = [3 * (int(scene[-4:]) - 1) + k for scene in scenes for k in range(3)]
        assert scans[name] == [f"{number:06d}" for number in numbers]
    times = [row["timestamp"] for row in tables["sample"][:3]]
    assert np.diff(times).tolist() == [200_000, 200_000]
    card = Path("set/README.md").read_text()
    assert "5 drives of 3 scans at 5 Hz" in card
    assert "| train | 9 |" in card
    # boxes are those of the files
    ridden = next(row["token"] for row in tables["attribute"] if row["name"] == "cycle.with_rider")
    seen = [row for row in tables["sample_annotation"] if row["num_lidar_pts"]]
    riders = sum(ridden in row["attribute_tokens"] for row in seen)
    assert riders
    boxes = dict(re.findall(r"^\| ([\w-]+) \| [\d.]+% \| (\d+) \|", card, re.M))
    assert int(boxes["rider"]) == riders
    assert sum(map(int, boxes.values())) == len(seen)
    assert made("-o", "set", "--jobs", "1", "-n", "6").items() > {"set/recipe.json"[4:]: whole["recipe.json"]}.items()


@pytest.mark.parametrize("format", ["kitti", "semantickitti", "mmdet3d", "webdataset"])
def test_splits_of_other_formats(format: str, recipe: Path) -> None:
    text = 'text = "a car ahead"\nsurroundings = "bare"'  # quick to draft
    recipe.write_text(DRIVES.format(format).replace('street = ["downtown", "village"]\nriders = 2.0', text))
    made("-o", "set", "--jobs", "1")
    scans = json.loads(Path("set/splits.json").read_text())
    if format in ("kitti", "mmdet3d"):
        sets = Path("set", format, "ImageSets")
        assert {name: (sets / f"{name}.txt").read_text().split() for name in scans} == scans
        assert (sets / "trainval.txt").read_text().split() == sorted(scans["train"] + scans["val"])
    if format == "mmdet3d":
        infos = {name: json.loads(Path(f"set/mmdet3d/lidardraft_infos_{name}.json").read_text()) for name in scans}
        assert {
            name: [f"{row['sample_idx']:06d}" for row in info["data_list"]] for name, info in infos.items()
        } == scans
    if format == "semantickitti":
        parts = json.loads(Path("set/semantickitti/splits.json").read_text())
        assert parts == {name: sorted({f"{int(k) // 3:02d}" for k in numbers}) for name, numbers in scans.items()}
    if format == "webdataset":
        with tarfile.open("set/000001.tar") as tar:
            file = tar.extractfile("000003.json")
            assert file is not None
            assert json.load(file)["split"] in next(name for name in scans if "000003" in scans[name])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("val = 0.2", "val = 0.3"), "split: 0.6 + 0.3 + 0.2 is 1.1; it must be 1"),
        (("drives = 5", "scans = 5"), "scans goes without frames, which make drives"),
        (("frames = 3\n", ""), "drives goes with frames, which make drives"),
        (("hz = 5", "hz = 0"), "hz is 0; it must be a number over 0"),
        (("hz = 5", "poses = 2"), "poses goes without frames"),
        (("hz = 5", "hz = 50"), "drive 0, scene 1: hz is 50; a sweep of small takes 0.1 s"),
    ],
)
def test_bad_recipes_of_drives(
    change: tuple[str, str], said: str, recipe: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recipe.write_text(DRIVES.format("webdataset").replace(*change))
    assert cli.main(["dataset", "recipe.toml", "-o", "set", "--jobs", "1"]) != 0
    assert said in capsys.readouterr().err


def test_any_processes_make_the_same_shards(capsys: pytest.CaptureFixture[str]) -> None:
    ten = ("-n", "10")
    whole = made(*ten, "-o", "one", "--jobs", "1")
    said = capsys.readouterr()
    assert said.out.endswith("one: 10 scans as webdataset\n")
    assert said.err.count("has no known vehicle: none is carried") == 1
    assert made(*ten, "-o", "two", "--jobs", "2") == whole
    for share in ("2/3", "0/3"):
        assert "summary.json" not in made(*ten, "-o", "shares", "--jobs", "1", "--shard", share)
    assert made(*ten, "-o", "shares", "--jobs", "1", "--shard", "1/3") == whole
    assert sorted(whole) == sorted(
        [f"{k:06d}.{ending}" for k in range(4) for ending in ("tar", "json")]
        + ["README.md", "recipe.json", "summary.json"]
    )


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # webdataset leaves its files open
def test_the_summary_counts_what_others_read() -> None:
    webdataset = pytest.importorskip("webdataset")
    made("-o", "set", "--jobs", "1")
    summary = json.loads(Path("set/summary.json").read_text())
    shards = [str(path) for path in sorted(Path("set").glob("*.tar"))]
    samples = list(webdataset.WebDataset(shards, shardshuffle=False, empty_check=False).decode())
    gc.collect()
    assert [sample["__key__"] for sample in samples] == [f"{k:06d}" for k in range(20)]
    told = [sample["json"]["provenance"]["recipe"] for sample in samples]
    assert [each["scan"] for each in told] == list(range(20))
    assert summary["scans"] == 20
    assert summary["bytes"] == sum(Path(shard).stat().st_size for shard in shards)
    assert summary["scenes"] == Counter(str(each["scene"]) for each in told)
    assert set(summary["scenes"]) == {"1", "2", "3"}
    assert sum(summary["points"].values()) == sum(len(sample["points.npy"]) for sample in samples)
    assert summary["points"]["road"] == sum(int((sample["label.npy"] == 1).sum()) for sample in samples)
    heights = {sample["json"]["sensor"]["mount_height"] for sample in samples}
    assert len(heights) > 5
    assert min(heights) >= 1.6
    assert max(heights) <= 2.2
    streets = [each["scan"] for each in told if each["scene"] == 2]
    assert streets
    assert {k ^ 1 for k in streets} == set(streets)  # two poses of each


@pytest.mark.parametrize("name", [*FORMATS, "scans"])
def test_every_format_is_a_shard_that_goes_on_after_a_crash(name: str, recipe: Path) -> None:
    scene = '[[scene]]\ntext = "a truck ahead"\nsurroundings = "bare"\n[[sensor]]\nname = "small.json"\n'
    recipe.write_text(f'format = "{name}"\nscans = 5\nshard_size = 3\n{scene}')
    whole = made("-o", "set", "--jobs", "1")
    assert len(whole) > 5
    # what a crash leaves: a shard whose count is missing, a half shard, a half count
    Path("set/000001.json").unlink()
    Path("set/summary.json").unlink()
    Path("set/.000001.0a1b2c3d.partial").mkdir()
    Path("set/.000001.0a1b2c3d.partial/half").write_text("half")
    Path("set/000001.tar.0a1b2c3d.partial").write_text("half")
    again = made("-o", "set", "--jobs", "1")
    assert again.keys() == whole.keys()
    assert again == whole
    if name == "scans":
        assert Scan.load("set/000001/000004").layout.provenance["recipe"]["scan"] == 4


@pytest.mark.timeout(900)
@pytest.mark.parametrize("kills", [1, pytest.param(20, marks=pytest.mark.slow)])
def test_kills_lose_and_double_nothing(start: Callable[..., Command], kills: int) -> None:
    argv, chance, killed = ("-n", "12", "--jobs", "2", "-o"), random.Random(kills), 0
    while killed < kills:
        command = start(*argv, "killed")
        begun = len(list(Path("killed").glob("*.json")))
        while len(list(Path("killed").glob("*.json"))) == begun and command.process.poll() is None:
            time.sleep(0.02)
        time.sleep(chance.uniform(0.0, 0.3))
        if command.process.poll() is None:
            os.kill(command.process.pid, signal.SIGKILL)
            killed += 1
        status, _, err = command.ended()
        assert status in (0, -signal.SIGKILL), err
        if status == 0:
            argv = ("-n", str(int(argv[1]) + 12), *argv[2:])
        wait_for(partial(no_longer, command), seconds=20)
    ended = start(*argv, "killed").ended()
    assert ended[0] == 0, ended
    found, whole = files("killed"), made(*argv[:2], "--jobs", "1", "-o", "whole")
    assert found.keys() == whole.keys()
    assert found == whole


def no_longer(command: Command) -> bool:
    return not command.members()


def test_a_larger_number_grows_the_set(capsys: pytest.CaptureFixture[str]) -> None:
    made("-n", "4", "-o", "set", "--jobs", "1")
    assert made("-n", "8", "-o", "set", "--jobs", "1") == made("-n", "8", "-o", "whole", "--jobs", "1")
    whole = files("set")
    for fewer in ("4", "7"):  # of two shards, and of as many shards
        assert cli.main(["dataset", "recipe.toml", "-n", fewer, "-o", "set"]) == 2
        assert "set holds 8 scans; ask for as many or more" in capsys.readouterr().err
    assert files("set") == whole


def test_a_shard_that_somebody_deletes_is_made_again() -> None:
    whole = made("-n", "5", "-o", "set", "--jobs", "1")
    Path("set/000000.tar").unlink()
    assert made("-n", "5", "-o", "set", "--jobs", "1") == whole


def test_a_set_goes_on_with_the_version_and_the_weights_that_began_it(
    refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch, recipe: Path
) -> None:
    scene = '[[scene]]\ntext = "a car ahead"\nweights = "mine.safetensors"\n'
    recipe.write_text(f'{scene}[[sensor]]\nname = "small.json"\n')
    small, mine = PACKAGED / "paper-small.safetensors", Path("mine.safetensors")
    mine.write_bytes(small.read_bytes())
    whole = made("-n", "1", "-o", "set", "--jobs", "1")
    assert made("-n", "1", "-o", "set", "--jobs", "1") == whole
    kept = json.loads(Path("set/recipe.json").read_text())
    assert kept["version"] == lidardraft.__version__
    assert kept["weights"] == [zlib.crc32(small.read_bytes())]

    mine.write_bytes((PACKAGED / "paper.safetensors").read_bytes())
    said = refused("dataset", "recipe.toml", "-n", "2", "-o", "set")
    now = "the folder holds scans of other weights than the recipe names now; give the former files back"
    assert said == f"lidardraft: set/recipe.json: {now}, or use another folder\n"
    mine.unlink()
    assert "weights are 'mine.safetensors'; they must be a file or one of" in refused(
        "dataset", "recipe.toml", "-o", "x"
    )
    mine.write_bytes(small.read_bytes())

    with monkeypatch.context() as later:
        later.setattr(lidardraft, "__version__", "9.9")
        said = refused("dataset", "recipe.toml", "-n", "2", "-o", "set")
        was = lidardraft.__version__
    assert (
        f"set/recipe.json: the folder holds scans of lidardraft {lidardraft.__version__}, and this is {was}; go" in said
    )
    del kept["version"], kept["weights"]
    Path("set/recipe.json").write_text(json.dumps(kept, sort_keys=True))
    said = refused("dataset", "recipe.toml", "-n", "2", "-o", "set")
    assert "set/recipe.json: an earlier lidardraft wrote it without a version, so scans of" in said


def test_files_of_a_recipe_lie_beside_it_or_at_their_whole_path() -> None:
    Path("a[1]").mkdir()
    inside = Path("a[1]/recipe.toml")
    Path("a[1]/a.layout.json").write_text(Path("a.layout.json").read_text())
    Path("small.json").rename("a[1]/small.json")
    Path("a[1]/mine.safetensors").touch()
    for layout in ("*.layout.json", str(Path("a.layout.json").resolve())):
        text = RECIPE[: RECIPE.index("[[weather]]")].replace("*.layout.json", layout)
        inside.write_text(text.replace("speed = [0,", 'weights = "mine.safetensors"\nspeed = [0,'))
        loaded = Recipe.load(inside)
        assert [Path(file).name for file in loaded.scenes[2].of.values] == ["a.layout.json"]
        assert loaded.scenes[0].of.weights == "a[1]/mine.safetensors"


def test_two_writers_of_one_folder(
    start: Callable[..., Command], recipe: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = start("-n", "100000", "--jobs", "1", "-o", "set")
    wait_for(Path("set/000000.json").exists)
    for share in ("0/1", "1/2"):
        assert cli.main(["dataset", "recipe.toml", "-n", "100000", "--shard", share, "-o", "set"]) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        assert f"set is being written by process {first.process.pid} on " in err
    first.stop()
    argv = ("-n", "6", "--jobs", "1", "-o", "shares", "--shard")
    Path("shares").mkdir()
    Path("shares/.lock-0-of-1").touch()  # that all of them look at
    together = [start(*argv, f"{share}/2") for share in range(2)]
    assert [command.ended()[0] for command in together] == [0, 0]
    assert Path("shares/summary.json").exists()
    recipe.write_text(RECIPE.replace("seed = 4", "seed = 5"))
    assert cli.main(["dataset", "recipe.toml", "-o", "set"]) == 2
    assert "holds scans of another recipe" in capsys.readouterr().err


def test_a_set_that_does_not_fit_is_refused_and_keeps_its_shards(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["dataset", "recipe.toml", "-n", str(10**12), "-o", "set", "--jobs", "1"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "scans are left and take" in err
    assert Path("set/000000.tar").exists()


BAD = [
    ("scans = 20", "scans = 0", "scans is 0; it must be a whole number from 1"),
    ("scans = 20", "scans = 20\nscan = 3", "scan is not a key here; did you mean 'scans'?"),
    ("scans = 20", "", "scans is missing"),
    ("scans = 20", 'scans = 20\nformat = "kity"', "format is 'kity'; it must be one of kitti, "),
    ("scans = 20", "scans = ", "not TOML: "),
    ("seed = 4", "seed = -1", "seed is -1; it must be a whole number from 0"),
    ("seed = 4", "seed = true", "seed is True; it must be a whole number"),
    ("share = 2", "share = -2", "scene 1, share is -2; it must be a number of 0 or more"),
    ("share = 2", 'share = "2"', "scene 1, share is '2'"),
    ('street = ["urban", "country"]', "", "scene 2, one of text, text_file, layout and street is needed; there are 0"),
    ('"urban", ', '"urbn", ', "scene 2, street is ['urbn', 'country']; it must be one of "),
    ('["urban", "country"]', "[]", "scene 2, street is []; it must be a text, or a list of texts"),
    ("traffic", "trafic", "scene 2, trafic is not a key here; did you mean 'traffic'?"),
    ("traffic = {", "speed = 3.0\ntraffic = {", "scene 2, speed is not a key here"),
    ("from = 0.5, to = 2.0", "from = 2.0, to = 0.5", "scene 2, traffic is {'from': 2.0, 'to': 0.5}; it must be a"),
    ("from = 0.5, to = 2.0", "from = 0.5", "scene 2, traffic is {'from': 0.5}; it must be a number"),
    ('"*.layout.json"', '"*.lay.json"', "scene 3, layout is '*.lay.json'; it must be files"),
    ("words.side = ", "words.sides = ", "scene 1, {side} has no words"),
    ("words.side = ", "words.more = 3\nwords.side = ", "scene 1, words, more is in no sentence"),
    ("words.side = ", "words.side = []\n#", "scene 1, words, side is []"),
    ('["left", "right"]', '["left", "qwxy"]', "not understood: "),
    ("chance = 0.5", "chance = 1.5", "scene 1, edit 1, chance is 1.5; it must be a number from 0 to 1"),
    ('remove = "car_1"', "", "scene 1, edit 1, one of remove, move and replace is needed; there are 0"),
    ('remove = "car_1"', 'replace = "car_1"\nlabel = "cra"', "scene 1, edit 1, label is 'cra'; it must be one of "),
    ("left = [-2.5, 2.5]", 'left = ["far"]', "scene 1, edit 2, left is ['far']; it must be a number"),
    ('"small.json"', '"hdl46e"', "sensor 1, name: sensor is 'hdl46e'; it must be one of "),
    ('"small.json"', '"none.json"', "none.json: No such file"),
    ("from = 1.6, to = 2.2", "from = -1.6, to = 2.2", "sensor 1, mount_height is {'from': -1.6"),
    ("wetness = 1.0", "wetness = 2.0", "weather 2, wetness is 2.0; it must be a number from 0 to 1"),
    ("[[weather]]\nshare = 3\n[[weather]]", "[[weather]]\nshare = 0", "weather: every share is 0; one must be more"),
    ("[[sensor]]", "[sensor]", "sensor is {'name': 'small.json'"),
    ('name = "small.json"', "", "sensor 1, name is missing; it must be a text"),
    ('"small.json"', '["small.json", "hdl64e"]', "sensor 1, name is ['small.json', 'hdl64e']; it must be a text"),
    ("speed = [0,", 'weights = ["paper", "mine"]\nspeed = [0,', "scene 1, weights is ['paper', 'mine']; it must"),
    ('layout = "*.layout.json"', 'text_file = ["a", "b"]', "scene 3, text_file is ['a', 'b']; it must be a text"),
    ('layout = "*.layout.json"', 'text_file = "empty.txt"', "empty.txt holds no sentence; it must hold one a line"),
    ('remove = "car_1"', 'remove = ["a", "b"]', "scene 1, edit 1, remove is ['a', 'b']; it must be a text"),
    ("speed = [0,", 'weights = "paper"\nspeed = [0,', "weather goes without scenes with weights"),
]


@pytest.mark.parametrize(("old", "new", "said"), BAD, ids=lambda row: str(row)[:30])
def test_bad_recipes_are_one_line(old: str, new: str, said: str, recipe: Path, refused: Callable[..., str]) -> None:
    assert old in RECIPE
    Path("empty.txt").touch()
    recipe.write_text(RECIPE.replace(old, new, 1))
    err = refused("dataset", "recipe.toml", "-o", "set")
    assert err.startswith("lidardraft: recipe.toml: ")
    assert said in err


def test_bad_places_and_options_are_one_line(refused: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    assert "none.toml: No such file" in refused("dataset", "none.toml", "-o", "set")
    Path("full").mkdir()
    Path("full/notes.txt").write_text("mine")
    assert "full is not empty (notes.txt)" in refused_but_locks("full", capsys)
    assert "small.json" in refused("dataset", "recipe.toml", "-o", "small.json")
    for share in ("3/3", "1", "a/b", "-1/2"):
        with pytest.raises(SystemExit):
            cli.main(["dataset", "recipe.toml", "-o", "set", f"--shard={share}"])
        assert "is not I/K" in capsys.readouterr().err


def refused_but_locks(folder: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.main(["dataset", "recipe.toml", "-o", folder]) == 2
    assert [path.name for path in Path(folder).iterdir() if not path.name.startswith(".lock")] == ["notes.txt"]
    return capsys.readouterr().err


VALUES = st.recursive(
    st.integers(-5, 5) | st.floats(-5, 5) | st.text(max_size=3) | st.none() | st.booleans(),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["from", "to", "x"]), inner, max_size=3)
    ),
    max_leaves=6,
)


@settings(max_examples=100, deadline=None)
@given(VALUES)
@example({"from": 0, "to": {"from": 0, "to": 0}})
@example({"from": [0], "to": 0})
def test_what_is_taken_for_a_number_is_drawn_within_its_limits(value: object) -> None:
    table = Table({"v": value})
    with contextlib.suppress(FormatError):
        values = table.numbers("v", 0.0, -3.0, 3.0)
        assert {type(each) for each in every(values)} <= {int, float}
        for seed in range(5):
            assert -3.0 <= drawn(values, np.random.default_rng(seed)) <= 3.0


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 99), VALUES), min_size=1, max_size=2))
def test_any_value_is_taken_or_refused(changes: list[tuple[int, object]]) -> None:
    fields = recipes.tomllib.loads(RECIPE)
    for number, value in changes:
        table = [fields, *fields["scene"], *fields["sensor"], *fields["weather"]][number % 7]
        if table:
            table[sorted(table)[number % len(table)]] = value
    with contextlib.suppress(LidarDraftError):
        recipe = recipes._recipe(Path("recipe.toml"), fields)
        for k in range(3):
            recipe._draws(k)


@pytest.mark.parametrize("scene", ['text = "a car ahead"\nsurroundings = "bare"', 'street = "country"'])
def test_the_car_of_a_preset_is_in_the_way_unless_the_recipe_says_none(scene: str, recipe: Path) -> None:
    hidden = lidardraft.with_vehicle(lidardraft.Sensor.preset("hdl32e")).blocked_pixels
    for carrier, returns in (("", False), ('carrier = "car"', False), ('carrier = "none"', True)):
        recipe.write_text(f'scans = 1\n[[scene]]\n{scene}\n[[sensor]]\nname = "hdl32e"\n{carrier}\n')
        assert Recipe.load(recipe).scan(0).image.valid[hidden].any() == returns
    recipe.write_text(f'scans = 1\n[[scene]]\n{scene}\n[[sensor]]\nname = "hdl32e"\ncarrier = "van"\n')
    with pytest.raises(FormatError, match=r"sensor 1, carrier is 'van'; it must be one of car, none"):
        Recipe.load(recipe)
