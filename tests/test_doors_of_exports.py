"""Every way out: each format of `export`, of each kind of scan, as the readers of others find it."""

import gc
import json
import os
import re
import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import lidardraft
from foreign_readers import READERS
from lidardraft import Box, Layout, Primitive, Scan, Sensor, Simulator, raycast
from lidardraft.cli import main as cli
from lidardraft.errors import FormatError
from lidardraft.formats.boxes import write_boxes
from lidardraft.formats.frame import AS_SEEN, FORMATS, UNBOXED, Annotation, Frame, writer_of
from lidardraft.formats.nuscenes import CATEGORIES, read_lidarseg
from lidardraft.formats.semantickitti import RAW_FROM_CLASS, read_label
from lidardraft.scene.scenario import Scenario, Straight, Waypoints
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.motion.sequence import SequenceSimulator

SENSOR = Sensor(name="few", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=256)
TIMED = ("pcd", "ply", "las", "ros2", "webdataset")  # formats with a time for each point
KEEP_UNSEEN = ("nuscenes", "ros2", "webdataset")


def solid(label: str, id: str, instance: int, at: tuple[float, float], size: tuple, yaw: float = 0.0) -> Primitive:
    center = (*at, size[2] / 2 + 0.05)
    return Primitive(shape="box", center=center, size=size, yaw=yaw, label=label, id=id, instance=instance)


LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road"),
    solid("bus", "bus_1", 1, (14, 6), (10, 2.6, 3.1)),
    solid("car", "car_2", 2, (8, -6), (4.4, 1.9, 1.5), 0.5),
    solid("person", "person_3", 3, (6, 3), (0.6, 0.6, 1.8)),
    solid("bicycle", "rider_4.bicycle", 4, (9, -2), (1.8, 0.6, 1.1), 0.2),
    solid("rider", "rider_4.rider", 5, (9, -2), (0.6, 0.6, 1.9), 0.2),
    solid("car", "car_6", 6, (14, 11), (4.4, 1.9, 1.5)),  # behind the bus
), {"sentence": "a bus and a walker"})  # fmt: skip
ACTORS = {"bus_1": Straight(6.0), "person_3": Straight(1.5), "rider_4": Straight(4.0), "*": Straight(0.0)}
BEND = Waypoints(tuple((t, 8 * t, 1.5 * t * t, 0.375 * t) for t in (0.0, 0.25, 0.5, 0.75, 1.0)))


@cache
def sequence() -> list[Scan]:
    simulator = SequenceSimulator(LAYOUT, SENSOR, Scenario(BEND, ACTORS), frames=3, hz=5, detail=False)
    return list(simulator)


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Scan]]:
    """Of each kind, a drive."""
    folder, simulator = tmp_path_factory.mktemp("scans"), Simulator(LAYOUT, SENSOR, detail=False)
    for number, scan in enumerate(sequence()):
        scan.save(folder / f"{number}", picture=False)
    raycast(LAYOUT, SENSOR).save(folder / "bare.npz")
    for name, casts in (("observed", ["0.npz", "1.npz", "2.npz"]), ("bare", ["bare.npz"])):
        given = [str(folder / cast) for cast in casts]
        assert cli.main(["observe", *given, "--no-picture", "-o", str(folder / name)]) == 0
    return {
        "moving": [simulator.scan(SENSOR.pose(x=3.0, yaw=0.4), speed=12.0)],
        "sequence": sequence(),
        "observed": [Scan.load(folder / "observed" / f"{number:06d}") for number in range(3)],
        "without boxes": [Scan.load(folder / "bare" / "000000")],
    }


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # webdataset leaves its files open
@pytest.mark.parametrize(
    ("kind", "as_seen"), [("moving", None), ("moving", True), ("sequence", None), ("without boxes", None)]
)
@pytest.mark.parametrize("name", FORMATS)
def test_every_format_of_every_kind_of_scan(
    name: str, kind: str, as_seen: bool | None, scans: dict[str, list[Scan]], tmp_path: Path
) -> None:
    margin, drive = 0.0 if as_seen else 0.02, scans[kind]
    with (
        pytest.warns(UserWarning, match="out: no scan has a box; `observe` takes")
        if (kind == "without boxes" and name not in UNBOXED)
        else pytest.MonkeyPatch.context()
    ):
        lidardraft.export(drive, name, tmp_path / "out", as_seen=as_seen, box_margin=margin)
    seen = as_seen or name in AS_SEEN
    for scan, found in zip(drive, READERS[name](tmp_path / "out"), strict=True):
        points = scan.image.points() if seen else scan.points()
        np.testing.assert_allclose(found.points[:, :3], points, atol=6e-4 if name == "las" else 1e-6, rtol=0)
        np.testing.assert_allclose(found.points[:, 3], scan.intensities(), atol=1e-5)
        assert ("time" in found.fields) == (seen and name in TIMED)
        for field, values in {"time": scan.image.times(), "ring": scan.image.beams(), "label": scan.labels()}.items():
            if field in found.fields:
                np.testing.assert_array_equal(found.fields[field], values)
        frame = scan.frame()
        expected = frame.annotations if name in KEEP_UNSEEN else frame.seen()
        for each, box in zip(expected, found.boxes or [], strict=name not in UNBOXED):
            np.testing.assert_allclose(box.center, each.box.center, atol=2e-3)
            np.testing.assert_allclose(box.size, np.array(each.box.size) + 2 * margin, atol=1e-3)
    if name == "webdataset":
        gc.collect()


def test_observed_scans_are_where_and_when_their_casts_were(scans: dict[str, list[Scan]]) -> None:
    for scan, observed in zip(sequence(), scans["observed"], strict=True):
        np.testing.assert_array_equal(observed.pose, scan.pose)
        assert (observed.time, observed.speed, observed.turn) == (scan.time, scan.speed, scan.turn)
        assert observed.boxes() == scan.boxes()
        assert [len(each.frame().annotations) for each in (scan, observed)] == [5, 5]
    assert not scans["without boxes"][0].boxes()


def test_boxes_beside_a_cloud_of_another_renderer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cast, where = raycast(LAYOUT, SENSOR), tmp_path / "07.npy"
    record = np.dtype(
        [(f, "<u4" if f.startswith("Obj") else "<f4") for f in ["x", "y", "z", "CosAngle", "ObjIdx", "ObjTag"]]
    )
    hits = np.zeros(cast.valid.sum(), record)
    hits["x"], hits["y"], hits["z"] = cast.points().T * np.array([[1], [-1], [1]])
    hits["CosAngle"], hits["ObjIdx"] = -1.0, cast.instance[cast.valid]
    tag = {"road": 1, "bus": 16, "car": 14, "person": 12, "bicycle": 19, "rider": 13}
    for name, number in tag.items():
        hits["ObjTag"][cast.label[cast.valid] == BY_NAME[name].id] = number
    np.save(where, hits)
    SENSOR.save(tmp_path / "few.json")
    boxes = [replace(box.raised(-SENSOR.mount_height), velocity=(1.0, 0.0, 0.0)) for box in LAYOUT.boxes()]
    write_boxes(tmp_path / "07.boxes.json", boxes, [0] * len(boxes))
    argv = ["observe", str(where), "--sensor", str(tmp_path / "few.json"), "--no-picture", "-o"]
    assert cli.main([*argv, str(tmp_path / "out")]) == 0
    assert json.loads((tmp_path / "out" / "casts.json").read_text()) == {"000000": str(where)}
    scan = Scan.load(tmp_path / "out" / "000000")
    for box, found in zip(boxes, scan.boxes(), strict=True):
        np.testing.assert_allclose(found.corners(), box.corners(), atol=1e-9)
        assert (found.instance, found.label, found.velocity) == (box.instance, box.label, box.velocity)
    assert scan.returns_per_box()[0] > 50
    assert "no point is of an object" not in capsys.readouterr().err
    write_boxes(tmp_path / "07.boxes.json", [replace(box, instance=box.instance + 50) for box in boxes], [0] * 6)
    assert cli.main([*argv, str(tmp_path / "wrong")]) == 0
    assert "07.boxes.json; the cast's instances must be those of the boxes" in capsys.readouterr().err


def test_a_cast_has_its_layout_beside_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    SENSOR.save(tmp_path / "few.json")
    LAYOUT.save(tmp_path / "a.layout.json")
    argv = ["raycast", "--layout", str(tmp_path / "a.layout.json"), "--sensor", str(tmp_path / "few.json"), "-o"]
    before = (tmp_path / "a.layout.json").stat().st_mtime_ns
    assert cli.main([*argv, str(tmp_path / "a.npz")]) == 0  # it is the input, which stays
    assert (tmp_path / "a.layout.json").stat().st_mtime_ns == before
    assert cli.main([*argv, str(tmp_path / "b.npz")]) == 0
    assert Layout.load(tmp_path / "b.layout.json") == LAYOUT
    (tmp_path / "a.npz").unlink()
    assert cli.main([*argv, str(tmp_path / "a.npz"), "--surroundings", "street"]) == 2
    assert "a.layout.json is the input too; write to another file" in capsys.readouterr().err
    assert not (tmp_path / "a.npz").exists()


def test_semantickitti_says_what_moves(tmp_path: Path) -> None:
    lidardraft.export(sequence(), "semantickitti", tmp_path / "out")
    for number, scan in enumerate(sequence()):
        path = tmp_path / f"out/sequences/00/labels/{number:06d}.label"
        raw = np.fromfile(path, "<u4") & 0xFFFF
        for instance, expected in {1: 257, 2: 10, 3: 254, 4: 253, 5: 253}.items():
            assert set(raw[scan.instances() == instance]) == {expected}
        assert set(raw[scan.instances() == 0]) == {40}
        label, instances = read_label(path, len(raw))
        np.testing.assert_array_equal(instances, scan.instances())
        still = scan.labels() != BY_NAME["bicycle"].id  # what is ridden and moves is the rider's
        np.testing.assert_array_equal(label[still], scan.labels()[still])
    moving = Simulator(LAYOUT, SENSOR, detail=False).scan(speed=9.0)  # of which nobody knows what else moves
    lidardraft.export([moving], "semantickitti", tmp_path / "one")
    raw = np.fromfile(tmp_path / "one/sequences/00/labels/000000.label", "<u4") & 0xFFFF
    assert set(raw) == {RAW_FROM_CLASS[name] for name in ("road", "bus", "car", "person", "bicycle", "rider")}


def annotated(id: str, label: str, size: tuple, velocity: tuple | None = (0.0, 0.0, 0.0), **more: object) -> Annotation:
    box = Box(id, label, int(id.rpartition("_")[2]), (9.0, 0.0, 0.0), size, 0.0, velocity)
    return Annotation(**{"box": box, "num_points": 3, "occlusion": 0.0, **more})  # type: ignore[arg-type]


def written(frames: list[Frame], output: Path) -> dict[str, list]:
    writer_of("nuscenes")(output, [frames])
    return {path.stem: json.loads(path.read_text()) for path in (output / "v1.0-trainval").iterdir()}


def frame_of(*annotations: Annotation, start: float | None = None, world: str = "") -> Frame:
    frame = sequence()[0].frame()
    return replace(frame, annotations=annotations, start=start, world=world)


def test_attributes_and_children_of_nuscenes(tmp_path: Path) -> None:
    """A car that drives, one that waits and drives on, one that is parked; people; what nobody knows the speed of."""
    car, adult, drives = (4.0, 2.0, 1.5), (0.6, 0.5, 1.8), (0.31, 0.0, 0.0)
    both = [
        annotated("car_1", "car", car, drives),
        annotated("car_3", "car", car, (0.29, 0.0, 0.0)),
        annotated("person_4", "person", adult, drives),
        annotated("person_5", "person", adult),
        annotated("person_6", "person", (1.7, 0.5, 0.4)),
        annotated("person_7", "person", (0.5, 0.4, 1.3), drives),
        annotated("bicycle_8", "rider", (1.8, 0.6, 1.7), drives, ridden="bicycle"),
        annotated("bicycle_9", "bicycle", (1.8, 0.6, 1.1)),
        annotated("truck_10", "truck", (8.0, 2.5, 3.0), None),
        annotated("person_11", "person", (0.5, 0.4, 1.42)).grown(0.02),
        annotated("person_12", "person", (0.5, 0.4, 1.38)).grown(0.02),
    ]
    waits, goes = annotated("bus_2", "bus", (10.0, 2.5, 3.0)), annotated("bus_2", "bus", (10.0, 2.5, 3.0), drives)
    tables = written([frame_of(*both, waits), frame_of(*both, goes)], tmp_path / "out")
    attributes = {row["token"]: row["name"] for row in tables["attribute"]}
    categories = {row["token"]: row["name"] for row in tables["category"]}
    instances = {row["token"]: categories[row["category_token"]] for row in tables["instance"]}
    said = [
        (instances[row["instance_token"]].split(".", 1)[1], *(attributes[token] for token in row["attribute_tokens"]))
        for row in tables["sample_annotation"]
    ]
    assert said[::2] == [
        ("car", "vehicle.moving"),
        ("car", "vehicle.parked"),
        ("pedestrian.adult", "pedestrian.moving"),
        ("pedestrian.adult", "pedestrian.standing"),
        ("pedestrian.adult", "pedestrian.sitting_lying_down"),
        ("pedestrian.child", "pedestrian.moving"),
        ("bicycle", "cycle.with_rider"),
        ("bicycle", "cycle.without_rider"),
        ("truck",),
        ("pedestrian.adult", "pedestrian.standing"),
        ("pedestrian.child", "pedestrian.standing"),
        ("bus.rigid", "vehicle.stopped"),
    ]
    assert said[-1] == ("bus.rigid", "vehicle.moving")


def test_points_of_nuscenes_have_the_category_of_their_box(tmp_path: Path) -> None:
    frame = sequence()[0].frame()
    small = [replace(a, box=replace(a.box, size=(0.4, 0.4, 1.2))) if a.box.label == "person" else a
             for a in frame.annotations]  # fmt: skip
    tables = written([replace(frame, annotations=tuple(small))], tmp_path / "out")
    raw = np.fromfile(tmp_path / "out" / tables["lidarseg"][0]["filename"], np.uint8)
    names = np.array(list(CATEGORIES))[raw]
    for instance, name in {1: "vehicle.bus.rigid", 3: "human.pedestrian.child", 4: "vehicle.bicycle"}.items():
        assert set(names[frame.instance == instance]) == {name}
    ours = read_lidarseg(tmp_path / "out" / tables["lidarseg"][0]["filename"], len(raw))
    assert (ours[frame.instance == 3] == BY_NAME["person"].id).all()


@pytest.mark.parametrize(
    ("occluded", "token", "level"),
    [(0.0, "4", "v80-100"), (0.19, "4", "v80-100"), (0.21, "3", "v60-80"), (0.39, "3", "v60-80"), (0.41, "2", "v40-60"),
     (0.59, "2", "v40-60"), (0.61, "1", "v0-40"), (1.0, "1", "v0-40")],
)  # fmt: skip
def test_visibility_of_nuscenes(occluded: float, token: str, level: str, tmp_path: Path) -> None:
    """1 is 0 to 40 % visible, 2 is 40 to 60 %, 3 is 60 to 80 %, 4 is 80 to 100 %, as the devkit's schema has it."""
    tables = written([frame_of(annotated("car_1", "car", (4.0, 2.0, 1.5), occlusion=occluded))], tmp_path / "out")
    assert tables["sample_annotation"][0]["visibility_token"] == token
    assert {row["token"]: row["level"] for row in tables["visibility"]}[token] == level


def test_scenes_of_nuscenes_follow_one_another_and_say_what_they_show(tmp_path: Path) -> None:
    intents = ['{"intent": {"sentence": "a car"}}', '{"intent": {"district": "urban"}}']
    worlds = [*intents, '{"provenance": {"source": "boxes"}}', ""]
    frames = [frame_of(start=start, world=world) for world in worlds for start in (5.0, 130.0)]
    tables = written(frames, tmp_path / "out")
    assert [row["description"] for row in tables["scene"]] == ["a car", "urban", "boxes", ""]
    times = [row["timestamp"] / 1e6 - 1.6e9 for row in tables["sample"]]
    np.testing.assert_allclose(times, [0, 125, 180, 305, 360, 485, 540, 665])


@pytest.mark.skipif("NUSCENES_PYTHON" not in os.environ, reason="NUSCENES_PYTHON is no Python that has nuscenes-devkit")
def test_perfect_predictions_have_no_error_by_the_devkit(tmp_path: Path) -> None:
    lidardraft.export(sequence(), "nuscenes", tmp_path / "out")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [os.environ["NUSCENES_PYTHON"], "-c", _EVALUATION, str(tmp_path / "out"), str(tmp_path)]
    said = subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout
    errors = json.loads(said.splitlines()[-1])
    assert set(errors) == {"bicycle", "bus", "car", "pedestrian"}
    assert all(value < 1e-3 or (of == "bicycle" and name == "attr_err") for of, each in errors.items()
               for name, value in each.items()), errors  # fmt: skip


_EVALUATION = """
import json, sys
import numpy as np
from nuscenes.nuscenes import NuScenes
from nuscenes.eval.detection.config import config_factory
from nuscenes.eval.detection.evaluate import DetectionEval
from nuscenes.eval.detection.utils import category_to_detection_name
nuscenes, results = NuScenes("v1.0-trainval", sys.argv[1], verbose=False), {}
for sample in nuscenes.sample:
    results[sample["token"]] = []
    for row in (nuscenes.get("sample_annotation", token) for token in sample["anns"]):
        velocity = np.nan_to_num(nuscenes.box_velocity(row["token"])[:2]).tolist()
        results[sample["token"]].append({
            "sample_token": sample["token"], "translation": row["translation"], "size": row["size"],
            "rotation": row["rotation"], "velocity": velocity, "detection_score": 0.9,
            "detection_name": category_to_detection_name(row["category_name"]),
            "attribute_name": nuscenes.get("attribute", row["attribute_tokens"][0])["name"]})
meta = {f"use_{sensor}": sensor == "lidar" for sensor in ("camera", "lidar", "radar", "map", "external")}
path = sys.argv[2] + "/results.json"
json.dump({"meta": meta, "results": results}, open(path, "w"))
evaluation = DetectionEval(nuscenes, config_factory("detection_cvpr_2019"), path, "train", sys.argv[2], verbose=False)
found = evaluation.evaluate()[0].serialize()
of = {name for name, precisions in found["mean_dist_aps"].items() if precisions > 0.9}
print(json.dumps({name: errors for name, errors in found["label_tp_errors"].items() if name in of}))
"""

SET = """
format = "{format}"
scans = 5
shard_size = 2
[[scene]]
text = "three cars ahead, a bus 15 m behind"
surroundings = "bare"
[[sensor]]
name = "few.json"
"""


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, bytes]]:
    """Makes a data set and gives the content of its files."""
    monkeypatch.chdir(tmp_path)
    SENSOR.save("few.json")

    def make(name: str, output: str = "set") -> dict[str, bytes]:
        Path("recipe.toml").write_text(SET.format(format=name))
        assert cli.main(["dataset", "recipe.toml", "--jobs", "1", "-o", output]) == 0
        return content(output)

    return make


def content(folder: str) -> dict[str, bytes]:
    paths = [path for path in Path(folder).rglob("*") if path.is_file()]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


@pytest.mark.parametrize("name", [name for name in FORMATS if name != "webdataset"])
def test_shards_are_one_data_set(name: str, made: Callable[..., dict[str, bytes]]) -> None:
    files = made(name)
    whole = list(READERS[name](Path("set", name)))
    parts = [found for shard in ("000000", "000001", "000002") for found in READERS[name](Path("set", shard))]
    assert len(whole) == len(parts) == 5
    keys = [each.points.tobytes() for each in parts]
    assert len(set(keys)) == 5
    for found in whole:
        part = parts[keys.index(found.points.tobytes())]
        assert [(box.name, *box.center) for box in found.boxes or []] == [
            (box.name, *box.center) for box in part.boxes or []
        ]
        assert found.fields.keys() == part.fields.keys()
    if name == "nuscenes":
        tables = {path.stem: json.loads(path.read_text()) for path in Path("set/nuscenes/v1.0-trainval").iterdir()}
        for rows in tables.values():
            assert len({row["token"] for row in rows}) == len(rows)
        assert [row["name"] for row in tables["scene"]] == [f"scene-{number:04d}" for number in range(1, 6)]
        assert len(tables["calibrated_sensor"]) == len(tables["log"]) == 1
        assert (np.diff([row["timestamp"] for row in tables["sample"]]) == 60_000_000).all()
    if name == "mmdet3d":
        infos = [json.loads(Path(f"set/mmdet3d/lidardraft_infos_{part}.json").read_text()) for part in ("train", "val")]
        assert sorted(row["sample_idx"] for info in infos for row in info["data_list"]) == [0, 1, 2, 3, 4]
    if name in ("kitti", "openpcdet", "mmdet3d"):
        assert Path("set", name, "ImageSets/trainval.txt").read_text().split() == [f"{k:06d}" for k in range(5)]
    times = {path: path.stat().st_mtime_ns for path in Path("set").rglob("*") if path.is_file()}
    assert made(name) == files  # a second run changes nothing
    assert {path: path.stat().st_mtime_ns for path in times} == times


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_merge_that_is_killed_at_any_point_goes_on(made: Callable[..., dict[str, bytes]]) -> None:
    expected = made("nuscenes", "whole")
    made("nuscenes")
    died, point = True, 0
    while died:
        Path("set/summary.json").unlink(missing_ok=True)
        point += 8
        if not (child := os.fork()):
            die_at(point)
            cli.main(["dataset", "recipe.toml", "--jobs", "1", "-o", "set"])
            os._exit(0)
        died = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
        if point % 32 == 0:
            assert made("nuscenes") == expected
    assert point > 30  # 3.10 calls the disk past the functions of `os`
    assert made("nuscenes") == expected


def die_at(point: int) -> None:
    """End this process, as a kill does, at one of its next changes of the disk."""
    left = [point]

    def dies(call: Callable) -> Callable:
        def run(*args: object, **more: object) -> object:
            left[0] -= 1
            if not left[0]:
                os._exit(9)
            return call(*args, **more)

        return run

    for call in (os.link, os.rename, os.replace, os.unlink, os.mkdir, os.rmdir):
        setattr(os, call.__name__, dies(call))


def test_a_set_that_is_killed_as_it_begins_goes_on(made: Callable[..., dict[str, bytes]]) -> None:
    Path("set").mkdir()
    Path("set/recipe.json.0a1b2c3d.partial").write_text("half")
    assert made("pcd") == made("pcd", "whole")


def test_a_disk_without_links_gets_copies(
    made: Callable[..., dict[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = made("openpcdet", "linked")

    def refuse(*_: object) -> None:
        raise OSError("no links here")

    monkeypatch.setattr(os, "link", refuse)
    assert made("openpcdet") == expected


def test_a_set_that_grows_is_merged_anew(made: Callable[..., dict[str, bytes]]) -> None:
    Path("recipe.toml").write_text(SET.format(format="kitti"))
    assert cli.main(["dataset", "recipe.toml", "-n", "3", "--jobs", "1", "-o", "set"]) == 0
    assert Path("set/kitti/ImageSets/trainval.txt").read_text().split() == ["000000", "000001", "000002"]
    assert made("kitti") == made("kitti", "whole")


def test_shards_that_are_not_of_one_set_are_refused(
    made: Callable[..., dict[str, bytes]], capsys: pytest.CaptureFixture[str]
) -> None:
    """As those of versions that counted scans anew in each shard."""
    made("pcd")
    Path("set/000001/000002.pcd").rename("set/000001/000000.pcd")
    Path("set/summary.json").unlink()
    assert cli.main(["dataset", "recipe.toml", "--jobs", "1", "-o", "set"]) == 2
    assert "set/000001/000000.pcd is in another shard too, and another file there" in capsys.readouterr().err


def test_scans_names_folders_and_drives_are_exported(tmp_path: Path) -> None:
    for number, scan in enumerate(sequence()):
        scan.save(tmp_path / f"{number:06d}", picture=False)
    names = [str(tmp_path / f"{number:06d}") for number in range(3)]
    given = {"scans": sequence(), "names": names, "folder": tmp_path, "drive": [names], "made": iter(sequence())}
    found = []
    for name, those in given.items():
        lidardraft.export(those, "openpcdet", tmp_path / f"out_{name}")
        found.append(content(str(tmp_path / f"out_{name}")))
    assert all(each == found[0] for each in found)
    lidardraft.export([names, sequence()], "semantickitti", tmp_path / "two")
    assert sorted(os.listdir(tmp_path / "two/sequences")) == ["00", "01"]
    lidardraft.export(sequence()[0], "pcd", tmp_path / "one")
    assert os.listdir(tmp_path / "one") == ["000000.pcd"]
    with pytest.raises(FormatError, match=re.escape("format is 'nuscene'; it must be one of kitti, ")):
        lidardraft.export(names, "nuscene", tmp_path / "three")
    for margin in (-0.1, float("nan"), "1"):
        with pytest.raises(FormatError, match=re.escape(f"box_margin is {margin!r}; it must be a number of metres")):
            lidardraft.export(names, "kitti", tmp_path / "three", box_margin=margin)  # type: ignore[arg-type]
    with pytest.raises(FormatError, match="there are no scans to write"):
        lidardraft.export([], "kitti", tmp_path / "three")
    assert not (tmp_path / "three").exists()


_WARM, _SWEEP = 22, 0.1  # frames until KISS-ICP knows that it moves; s


def test_points_as_seen_are_brought_back_by_their_times(tmp_path: Path) -> None:
    """By the pose of the column that their time names they come where the others are, whose motion is taken out."""
    for name, as_seen in (("out", False), ("seen", True)):
        lidardraft.export(sequence(), "pcd", tmp_path / name, as_seen=as_seen)
    for plain, seen, scan in zip(
        READERS["pcd"](tmp_path / "out"), READERS["pcd"](tmp_path / "seen"), sequence(), strict=True
    ):
        column = np.round(seen.fields["time"] / SENSOR.sweep_time * SENSOR.columns).astype(int)
        there = np.linalg.inv(scan.pose) @ scan.poses()[column]
        back = np.einsum("nij,nj->ni", there[:, :3, :3], seen.points[:, :3]) + there[:, :3, 3]
        np.testing.assert_allclose(back, plain.points[:, :3], atol=1e-4)
        assert np.abs(seen.points[:, :3] - plain.points[:, :3]).max() > 0.05


def test_a_margin_holds_the_points_of_a_car() -> None:
    """A tight box loses what noise puts outside; two centimetres hold more, and five nearly all."""
    car = Layout((LAYOUT.primitives[0], solid("car", "car_1", 1, (9, 2), (4.4, 1.9, 1.5), 0.5)))
    simulator = Simulator(car, replace(SENSOR, columns=1024), detail=False)
    inside = []
    for margin in (0.0, 0.02, 0.05):
        frames = [simulator.scan(seed=seed).frame(box_margin=margin) for seed in range(4)]
        mine = [frame.annotations[0].holds(frame.instance) for frame in frames]
        assert [frame.annotations[0].num_points for frame in frames] == [each.sum() for each in mine]
        pairs = zip(frames, mine, strict=True)
        inside.append(np.mean(np.concatenate([f.annotations[0].box.contains(f.points)[m] for f, m in pairs])))
    assert inside[0] < 0.7 < inside[1] - 0.05
    assert inside[2] > 0.95
