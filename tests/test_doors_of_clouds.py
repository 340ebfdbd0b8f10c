"""Every reader of clouds x frame, scale, handedness and names: the right value, or one line that says why not."""

import itertools
import re
from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lidardraft import Layout, Sensor, layout_from_cloud
from lidardraft.cli import main as cli
from lidardraft.errors import FormatError
from lidardraft.formats.carla import TAGS_BEFORE_0_9_14, read_carla
from lidardraft.formats.kitti import write_bin
from lidardraft.formats.pcd import parse_pcd
from lidardraft.formats.point_fields import unit_intensity
from lidardraft.formats.recording import read_points, read_recording
from lidardraft.formats.semantickitti import write_label
from lidardraft.protocols import PROTOCOLS, compare
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.recorded.object_sampling import ObjectSampling
from lidardraft.simulation.recorded.recorded_scan import RecordedScan
from small_recordings import pandaset

SENSOR = Sensor(name="few", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=180)
ROAD, CAR, PERSON = (BY_NAME[name].id for name in ("road", "car", "person"))
Columns = dict[str, np.ndarray]


def scene(height: float = 1.73) -> tuple[np.ndarray, np.ndarray]:
    """Points [N, 3] and classes of a road around a sensor so high over it, and of a car on its left."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(-20, 20.1, 0.5), np.arange(-12, 12.1, 0.5)))
    road = np.column_stack([x, y, np.full(x.size, -height)])
    along, up = (axis.ravel() for axis in np.meshgrid(np.linspace(8, 12, 30), np.linspace(0.3, 1.4, 9)))
    car = np.column_stack([along, np.full(along.size, 4.1), up - height])
    back = np.column_stack([np.full(90, 8.0), np.tile(np.linspace(4.1, 5.8, 10), 9), np.repeat(up[::30], 10) - height])
    label = np.repeat([ROAD, CAR], [len(road), len(car) + len(back)])
    return np.concatenate([road, car, back]).astype(np.float32), label.astype(np.uint8)


POINTS, LABEL = scene()
DIM = np.linspace(0, 1, len(POINTS)).astype(np.float32)  # intensities
NO_TURN = "0 0 0 1 0 0 0"


def write_pcd(path: Path, columns: Columns, viewpoint: str = NO_TURN, text: bool = False) -> None:
    records = np.rec.fromarrays(list(columns.values()), names=list(columns))
    kinds = [values.dtype for values in columns.values()]
    head = {
        "FIELDS": columns,
        "SIZE": [str(kind.itemsize) for kind in kinds],
        "TYPE": [kind.kind.upper() for kind in kinds],
        "VIEWPOINT": [viewpoint],
        "POINTS": [str(len(records))],
        "DATA": ["ascii" if text else "binary"],
    }
    body = "".join(" ".join(map(str, row)) + "\n" for row in records.tolist()).encode() if text else records.tobytes()
    path.write_bytes("".join(f"{key} {' '.join(words)}\n" for key, words in head.items()).encode() + body)


def write_ply(path: Path, columns: Columns) -> None:
    kinds = {"f4": "float", "f8": "double", "u1": "uchar", "u2": "ushort", "u4": "uint", "i4": "int"}
    lines = [f"property {kinds[values.dtype.str[1:]]} {name}" for name, values in columns.items()]
    records = np.rec.fromarrays(list(columns.values()), names=list(columns))
    head = "\n".join(["ply", "format binary_little_endian 1.0", f"element vertex {len(records)}", *lines, "end_header"])
    path.write_bytes(head.encode() + b"\n" + records.tobytes())


def write_npz(path: Path, columns: Columns) -> None:
    others = {name: values for name, values in columns.items() if name not in ("x", "y", "z")}
    np.savez(path, xyz=np.stack([columns[axis] for axis in "xyz"], axis=1), **others)


def write_npy(path: Path, columns: Columns) -> None:
    np.save(path, np.rec.fromarrays(list(columns.values()), names=list(columns)))


def write_las(path: Path, columns: Columns) -> None:
    names = [name for name in columns if name not in ("x", "y", "z", "intensity")]
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales = np.full(3, 0.0001)
    header.offsets = np.floor([columns[axis].min() for axis in "xyz"])
    header.add_extra_dims([laspy.ExtraBytesParams(name, columns[name].dtype) for name in names])
    points = laspy.LasData(header)
    for name, values in columns.items():
        points[name] = values
    points.write(path)


WITH_NAMES: dict[str, Callable[[Path, Columns], None]] = {
    ".pcd": write_pcd,
    ".ply": write_ply,
    ".npz": write_npz,
    ".npy": write_npy,
}


def columns_of(points: np.ndarray = POINTS, **more: np.ndarray) -> Columns:
    return dict(zip("xyz", points.T, strict=True)) | more


def run(capsys: pytest.CaptureFixture[str], *argv: str, status: int = 0) -> str:
    """What a command says, on both channels."""
    assert cli.main(argv) == status, capsys.readouterr().err
    said = capsys.readouterr()
    assert "Traceback" not in said.err
    return said.err + said.out


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    SENSOR.save("few.json")
    return tmp_path


# Scales


@pytest.mark.parametrize("ending", WITH_NAMES)
@pytest.mark.parametrize(
    ("full", "kind", "scale"),
    [(1, "<f4", None), (255, "<u1", None), (65535, "<u2", None), (255, "<f4", 255), (4095, "<u2", 4095)],
)
def test_the_scale_is_stated_by_the_type_or_given(
    folder: Path, ending: str, full: float, kind: str, scale: float | None
) -> None:
    values = np.round(DIM * full).astype(kind) if full > 1 else DIM
    path = folder / f"a{ending}"
    WITH_NAMES[ending](path, columns_of(intensity=values))
    points, fields = read_points(path, intensity_scale=scale)
    np.testing.assert_allclose(points, POINTS, atol=1e-6)
    np.testing.assert_allclose(fields["intensity"], DIM, atol=0.51 / full if full > 1 else 0)


@pytest.mark.parametrize("ending", WITH_NAMES)
@pytest.mark.parametrize("kind", ["<f4", "<u4", "<i4", "<f8"])
def test_no_scale_is_guessed(folder: Path, capsys: pytest.CaptureFixture[str], ending: str, kind: str) -> None:
    """Signal photons, say: commands that need intensities ask, and `draft` does without."""
    path = folder / f"a{ending}"
    ring = np.repeat(np.arange(16), len(POINTS) // 16 + 1)[: len(POINTS)]
    WITH_NAMES[ending](path, columns_of(intensity=(DIM * 3000).astype(kind), ring=ring.astype("<u2")))
    asked = rf"a\{ending}: intensities have a median of 1500 and a maximum of 3000, over 1; give their scale as"
    asked += r" --intensity-scale \(intensity_scale\), likely 4095"
    with pytest.raises(FormatError, match=asked):
        read_recording(path)
    write_label(folder / "a.label", LABEL, np.zeros(len(LABEL), np.uint32))
    for argv in (
        ["edit", "--sensor", "few.json"],
        ["pairs", "--sensor", "few.json", "-o", "p"],
        ["fit", "-o", "s.json"],
    ):
        assert re.search(asked, run(capsys, argv[0], path.name, *argv[1:], status=2))
    said = run(capsys, "draft", "--points", path.name, "--labels", "a.label", "--no-preview", "-o", "l.json")
    assert re.search(asked + "; read without intensities", said)
    (box,) = Layout.load("l.json").boxes()
    assert box.center[1] == pytest.approx(5, abs=0.3)
    edit = ("edit", path.name, "--labels", "a.label", "--sensor", "few.json")
    assert "car_1" in run(capsys, *edit, "--intensity-scale", "3000")
    assert read_recording(path, intensity_scale=3000).intensity.max() == 1


@given(st.integers(0, 40), st.floats(1.0001, 1e6), st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_a_few_values_over_1_are_clipped_and_all_others_stay(count: int, over: float, seed: int) -> None:
    values = np.random.default_rng(seed).random(2000, np.float32)
    values[:count] = over
    arguments = (values, None)
    if not count:
        np.testing.assert_array_equal(unit_intensity(*arguments, of="a"), values)
    elif count <= 20:
        with pytest.warns(
            UserWarning, match=rf"a: {count} of 2000 intensities are over 1, at most .*; they are clipped"
        ):
            np.testing.assert_array_equal(unit_intensity(*arguments, of="a"), np.minimum(values, 1))
    else:
        with pytest.raises(FormatError, match="give their scale"):
            unit_intensity(*arguments, of="a")


def test_scales_of_formats(folder: Path) -> None:
    counts = np.round(DIM * 255).astype("<f4")
    np.column_stack([-POINTS[:, 1], POINTS[:, 0], POINTS[:, 2], counts, np.zeros_like(DIM)]).tofile("a.pcd.bin")
    np.testing.assert_allclose(read_points("a.pcd.bin")[1]["intensity"], counts / 255, rtol=1e-6)
    np.testing.assert_allclose(read_points("a.pcd.bin", intensity_scale=510)[1]["intensity"], counts / 510, rtol=1e-6)
    assert read_points(pandaset(folder))[1]["intensity"].tolist() == pytest.approx([0, 0.2])
    write_las(Path("a.las"), columns_of(intensity=np.round(DIM * 65535).astype("<u2")))
    np.testing.assert_allclose(read_points("a.las")[1]["intensity"], DIM, atol=1e-5)
    write_las(Path("b.las"), columns_of(intensity=np.round(DIM * 4095).astype("<u2")))
    said = "b.las: intensities of 16 bits are divided by 65535, but the largest is 4095: give --intensity-scale 4095 if"
    with pytest.warns(UserWarning, match=said):
        np.testing.assert_allclose(read_points("b.las")[1]["intensity"], DIM / 16, atol=1e-4)
    np.testing.assert_allclose(read_points("b.las", intensity_scale=4095)[1]["intensity"], DIM, atol=2e-4)
    np.column_stack([POINTS, DIM * 255]).tofile("a.bin")
    with pytest.raises(
        FormatError, match=r"a\.bin: intensities have a median of 12.* and a maximum of 255, over 1; give"
    ):
        read_points("a.bin")
    np.testing.assert_allclose(read_points("a.bin", intensity_scale=255)[1]["intensity"], DIM, rtol=1e-6)
    with pytest.raises(FormatError, match=r"over 100; give their scale as .*, likely 255"):
        read_points("a.bin", intensity_scale=100)
    write_pcd(Path("a.pcd"), columns_of(intensity=-DIM))
    with pytest.raises(FormatError, match="an intensity is not finite or not within 0 to 1"):
        read_recording("a.pcd")


def test_scales_in_python() -> None:
    with pytest.raises(FormatError, match=r"--intensity-scale \(intensity_scale\), likely 255"):
        RecordedScan.from_points(POINTS, SENSOR, intensity=DIM * 255)
    for wrong in (0, -1.0, float("nan"), "255"):
        with pytest.raises(FormatError, match=f"intensity_scale is {wrong!r}; it must be a number over 0"):
            RecordedScan.from_points(POINTS, SENSOR, intensity=DIM, intensity_scale=wrong)
    scan = RecordedScan.from_points(POINTS, SENSOR, intensity=DIM * 255, intensity_scale=255)
    np.testing.assert_allclose(scan.intensity[scan.returned], DIM, rtol=1e-6)
    sample = {
        "points": np.column_stack([POINTS, DIM * 200]),
        "gt_boxes": np.zeros((0, 7)),
        "gt_names": np.zeros(0, str),
    }
    with pytest.raises(FormatError, match=r"--intensity-scale \(intensity_scale\), likely 255"):
        ObjectSampling({"car": 1}, SENSOR, models=1)(sample)
    found = ObjectSampling({"car": 1}, SENSOR, models=1, intensity_scale=200)(sample)["points"]
    kept = (found[:, None] == sample["points"]).all(axis=2).any(axis=1)
    assert 0.5 < kept.mean() < 1  # recorded ones to the last bit
    assert found[~kept, 3].max() <= 200


def test_protocols_read_intensities_only_for_networks(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_pcd(folder / "a.pcd", columns_of(intensity=DIM * 255))
    write_bin(folder / "b.bin", POINTS, DIM)
    scores = compare(PROTOCOLS["lidm"], ["a.pcd"] * 4, ["b.bin"] * 4)
    assert next(score.value for score in scores if score.metric == "JSD") == 0
    folders = ("--real", "a.pcd", "--generated", "b.bin", "--intensity-scale", "255")
    assert "JSD" in run(capsys, "evaluate", "--protocol", "lidm", *folders)


# Names

INTENSITIES = (
    *("intensity", "Intensity", "scalar_Intensity", "scalar_intensity"),
    *("reflectivity", "reflectance", "i", "I"),
)
RINGS = ("ring", "Ring", "scalar_ring", "scalar_Ring", "channel", "laser_id", "line")


@pytest.mark.parametrize("ending", WITH_NAMES)
@pytest.mark.parametrize(("name", "ring"), [*itertools.zip_longest(INTENSITIES, RINGS, fillvalue="ring")])
def test_names_of_fields(folder: Path, ending: str, name: str, ring: str) -> None:
    number = (np.arange(len(POINTS)) % 16).astype("<f4")
    WITH_NAMES[ending](folder / f"a{ending}", columns_of(**{name: DIM, ring: number, "noise": 9 * DIM}))
    recording = read_recording(folder / f"a{ending}")
    np.testing.assert_array_equal(recording.intensity, DIM)
    np.testing.assert_array_equal(recording.ring, number)


def test_las_has_names_for_rings_too(folder: Path) -> None:
    write_las(folder / "a.las", columns_of(laser_id=(np.arange(len(POINTS)) % 16).astype("<u2")))
    np.testing.assert_array_equal(read_recording(folder / "a.las").ring, np.arange(len(POINTS)) % 16)


@pytest.mark.parametrize("ending", [".pcd", ".ply", ".npz"])
def test_what_is_missing_is_said_with_what_is_there(
    folder: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    path = folder / f"a{ending}"
    there = "xyz, brightness" if ending == ".npz" else "x, y, z, brightness"
    WITH_NAMES[ending](path, columns_of(np.random.default_rng(0).permutation(POINTS), brightness=DIM))
    with pytest.raises(FormatError, match=rf"the lasers of the points are unknown: .*; its fields are {there}"):
        read_recording(path)
    write_label(folder / "a.label", LABEL, np.zeros(len(LABEL), np.uint32))
    said = run(capsys, "pairs", path.name, "--labels", "a.label", "--sensor", "few.json", "-o", "p", status=2)
    assert f"it has no intensities, which the generator learns too; its fields are {there}" in said
    assert "it has no intensities" not in run(capsys, "edit", path.name, "--sensor", "few.json")
    said = run(capsys, "edit", path.name, "--sensor", "few.json", "--insert", "car at 9,-5", "-o", "edited")
    assert f"it has no intensities; its fields are {there}: recorded returns read 0" in said


def test_fit_says_if_there_are_no_intensities(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    elevation, azimuth = (
        axis.ravel() for axis in np.meshgrid(np.array(SENSOR.elevations)[-8:], np.linspace(0, 6.2, 400), indexing="ij")
    )
    far = 1.73 / -np.sin(elevation)
    level = far * np.cos(elevation)
    points = np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), far * np.sin(elevation)])
    write_pcd(folder / "a.pcd", columns_of(points.astype("<f4"), line=np.repeat(np.arange(8), 400).astype("<u1")))
    said = run(capsys, "fit", "a.pcd", "-o", "mine.json", "--streets", "4")
    assert "a.pcd: it has no intensities; its fields are x, y, z, line: none are fitted" in said


# Frames

ANGLES = st.floats(-3.1, 3.1)
PLACES = st.tuples(st.floats(0.1, 900), *[st.floats(-900, 900)] * 2)


@given(PLACES, st.tuples(ANGLES, ANGLES, ANGLES))
@settings(max_examples=25, deadline=None)
def test_viewpoint_is_undone(
    tmp_path_factory: pytest.TempPathFactory, place: tuple[float, ...], angles: tuple[float, ...]
) -> None:
    """Points in the world come back into the frame of the sensor that stood at VIEWPOINT; missing returns stay."""
    path = tmp_path_factory.mktemp("viewpoint") / "a.pcd"
    turn = Rotation.from_euler("xyz", angles)
    world = POINTS @ turn.as_matrix().T + place
    world[:3] = 0
    x, y, z, w = turn.as_quat()
    write_pcd(path, columns_of(world), " ".join(map(repr, map(float, (*place, w, x, y, z)))))
    with pytest.warns(UserWarning, match=r"a\.pcd: VIEWPOINT \[.*\] is applied: points are taken from its frame"):
        points = read_points(path)[0]
    np.testing.assert_allclose(points[3:], POINTS[3:], atol=1e-4)
    assert not points[:3].any()


def test_a_viewpoint_far_from_the_points_is_not_applied(folder: Path) -> None:
    write_pcd(folder / "a.pcd", columns_of(), "431200 5822000 61 1 0 0 0")
    with pytest.warns(UserWarning, match=r"is not applied: the points lie around their origin, and far from it"):
        points, _ = read_points(folder / "a.pcd")
    np.testing.assert_array_equal(points, POINTS)
    write_pcd(folder / "a.pcd", columns_of(), "0 0 0 0 0 0 0")  # as some writers have it
    np.testing.assert_array_equal(read_points(folder / "a.pcd")[0], POINTS)


@pytest.mark.parametrize("ending", [*WITH_NAMES, ".las", ".bin"])
def test_clouds_of_maps_are_refused_by_every_command(
    folder: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    path, far = folder / f"a{ending}", POINTS + np.array([431200, 5822000, 61])
    if ending == ".bin":
        write_bin(path, far, DIM)
    else:
        (WITH_NAMES | {".las": write_las})[ending](path, columns_of(far))
    write_label(folder / "a.label", LABEL, np.zeros(len(LABEL), np.uint32))
    for argv in (
        ["draft", "--points", path.name, "--labels", "a.label", "-o", "l.json"],
        ["view", path.name, "-o", "v.png"],
        ["edit", path.name, "--sensor", "few.json"],
        ["fit", path.name, "-o", "s.json"],
        ["evaluate", "--protocol", "lidm", "--real", path.name, "--generated", path.name],
    ):
        said = run(capsys, *argv, status=2)
        assert f"{path.name}: the nearest returns are 5837" in said
        assert "m from the origin, the place of the sensor; of a cloud in the frame of a map, subtract" in said
        assert "and of one in other units make metres" in said


def test_coarse_coordinates_of_maps_are_told(folder: Path) -> None:
    place = np.array([431200, 5822000, 61])
    for kind, steps in (("<f8", ""), ("<f4", ", where coordinates of float32 are in steps of 0.5 m")):
        write_pcd(folder / "a.pcd", columns_of((POINTS + place).astype(kind)), "431200 5822000 61 1 0 0 0")
        with pytest.warns(UserWarning, match=r"VIEWPOINT \[.*\] is applied: .* into the sensor's" + steps + "$"):
            points, _ = read_points(folder / "a.pcd")
        np.testing.assert_allclose(points, POINTS, atol=0.26 if steps else 1e-6)


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_pairs_say_what_is_applied_in_other_processes_too(capfd: pytest.CaptureFixture[str], jobs: str) -> None:
    for name, intensity in (("a", DIM), ("b", 1 - DIM)):
        write_pcd(Path(f"{name}.pcd"), columns_of(POINTS + np.float32([5, 0, 0]), intensity=intensity), "5 0 0 1 0 0 0")
        write_label(f"{name}.label", LABEL, np.zeros(len(LABEL), np.uint32))
    command = ["pairs", "a.pcd", "b.pcd", "--labels", ".", "--sensor", "few.json", "--jobs", jobs, "-o", "p"]
    assert cli.main(command) == 0
    said = capfd.readouterr().err
    for name in "ab":
        assert f"lidardraft: {name}.pcd: VIEWPOINT [5.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0] is applied" in said


def test_clouds_that_are_not_around_the_sensor_are_told(folder: Path) -> None:
    write_ply(folder / "a.ply", columns_of(POINTS + np.float32([200, 0, 0])))
    with pytest.warns(
        UserWarning, match=r"a\.ply: the nearest returns are 18\d m from the origin, the place of the sensor"
    ):
        read_points(folder / "a.ply")


def test_clouds_around_the_origin_of_a_map_are_told(folder: Path) -> None:
    few = np.float32([[3, 0, 0], [0, 4, 0], [-3, 0, 0]])
    write_ply(folder / "a.ply", columns_of(np.concatenate([POINTS + np.float32([100, 50, 0]), few])))
    with pytest.warns(UserWarning, match=r"a\.ply: the nearest returns are 9\d m from the origin"):
        read_points(folder / "a.ply")
    write_pcd(
        folder / "a.pcd",
        columns_of(np.concatenate([POINTS, POINTS[:3] + np.float32([100, 50, 0])])),
        "100 50 0 1 0 0 0",
    )
    with pytest.warns(UserWarning, match=r"VIEWPOINT \[100.*\] is not applied"):
        np.testing.assert_array_equal(read_points(folder / "a.pcd")[0][: len(POINTS)], POINTS)


@pytest.mark.parametrize("nearest", [1.0, 12.0])
@pytest.mark.parametrize("height", [0.3, 3.2])
def test_a_ground_that_begins_far_away_says_the_height_too(nearest: float, height: float) -> None:
    around = np.stack([np.cos(np.arange(0, 6.28, 0.01)), np.sin(np.arange(0, 6.28, 0.01))], axis=1)
    rings = np.concatenate([around * radius for radius in (nearest, nearest + 2, nearest + 5)])
    road = np.column_stack([rings, np.full(len(rings), -height)]).astype(np.float32)
    (note,) = layout_from_cloud(road, np.full(len(road), ROAD, np.uint8), sensor_height=1.73).notes
    assert f"by the cloud it is {height:.2f} m: give sensor_height (--sensor-height)" in note
    assert layout_from_cloud(road, np.full(len(road), ROAD, np.uint8), sensor_height=height).notes == ()


@pytest.mark.parametrize("height", [0.4, 32.0, -3.0])
def test_the_ground_says_how_high_the_sensor_stood(
    folder: Path, capsys: pytest.CaptureFixture[str], height: float
) -> None:
    points, label = scene(height)
    write_bin(folder / "a.bin", points, np.zeros(len(points)))
    write_label(folder / "a.label", label, np.zeros(len(label), np.uint32))
    draft = ("draft", "--points", "a.bin", "--no-preview", "-o", "l.json")
    said = run(capsys, *draft)
    assert (
        f"a.bin: the ground lies at z = {1.73 - height:.2f} m, as the sensor is taken to be 1.73 m over the road"
        in said
    )
    below = "; or does z point down in it?" if height < 0 else ""
    assert f"it is {height:.2f} m: give sensor_height (--sensor-height){below}\n" in said
    assert len(Layout.load("l.json").notes) == 1
    said = run(capsys, *draft, "--sensor-height", f"{height}")
    assert "the ground lies" not in said
    layout = Layout.load("l.json")
    assert layout.notes == ()
    assert abs(layout["road"].center[2]) < 0.05
    assert layout.boxes()[0].center[2] == pytest.approx(0.75, abs=0.2)


def test_boxes_are_of_a_sensor_of_any_height_too(capsys: pytest.CaptureFixture[str]) -> None:
    Path("boxes.txt").write_text("9.0 4.0 0.35 4.4 1.9 1.5 0.5 Car\n")  # seen from 0.4 m
    draft = ("draft", "--boxes", "boxes.txt", "--surroundings", "bare", "--no-preview", "-o", "l.json")
    run(capsys, *draft, "--sensor-height", "0.4")
    assert Layout.load("l.json").boxes()[0].center[2] == pytest.approx(0.75, abs=0.02)
    assert "--sensor-height goes with --points or --boxes" in run(
        capsys, "draft", "--text", "a car", "--sensor-height", "1", "-o", "l.json", status=2
    )


def test_no_note_where_the_road_is_right_or_there_is_no_ground() -> None:
    assert layout_from_cloud(POINTS, LABEL).notes == ()
    steep = POINTS + np.column_stack([0 * POINTS[:, :2], 0.1 * POINTS[:, 0]])
    assert layout_from_cloud(steep, LABEL).notes == ()
    car, label = POINTS[LABEL == CAR], LABEL[LABEL == CAR]
    assert layout_from_cloud(car, label).notes == ()
    (note,) = layout_from_cloud(car + np.float32([0, 0, 32]), label).notes
    assert note.startswith(
        "the lowest point lies at z = 32.30 m, as the sensor is taken to be 1.73 m over the road; by"
    )


# Left-handed clouds of CARLA

TAGS_NOW, TAGS_OLD = {ROAD: 1, CAR: 14}, {ROAD: 7, CAR: 10}


def hits(tags: dict[int, int], label: np.ndarray = LABEL) -> Columns:
    ours = {"CosAngle": np.full(len(label), 0.5, "<f4"), "ObjIdx": np.where(label == CAR, 7, 0).astype("<u4")}
    tag = np.array([tags[number] for number in label.tolist()], "<u4")
    return columns_of(POINTS * np.float32([1, -1, 1]), **ours, ObjTag=tag)


MIRRORED = (
    r"a cloud of CARLA's semantic LiDAR, whose y points right: y is turned to the left, and ObjTag gives the classes"
)


@pytest.mark.parametrize("ending", [".ply", ".npy", ".pcd"])
def test_clouds_of_carla_are_mirrored_and_have_classes(
    folder: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    path = folder / f"a{ending}"
    WITH_NAMES[ending](path, hits(TAGS_NOW))
    with pytest.warns(UserWarning, match=MIRRORED):
        points, fields = read_points(path)
    np.testing.assert_array_equal(points, POINTS)
    np.testing.assert_array_equal(fields["label"], LABEL)
    np.testing.assert_array_equal(fields["instance"], np.where(LABEL == CAR, 7, 0))
    named = {
        f"scalar_{name}" if name.startswith(("Cos", "Obj")) else name: v.astype("<f4")
        for name, v in hits(TAGS_NOW).items()
    }
    WITH_NAMES[ending](folder / f"b{ending}", named)  # as CloudCompare saves it again
    with pytest.warns(UserWarning, match=MIRRORED):
        np.testing.assert_array_equal(read_points(folder / f"b{ending}")[1]["label"], LABEL)
    said = run(capsys, "draft", "--points", path.name, "--no-preview", "-o", "l.json")
    assert MIRRORED in said
    assert Layout.load("l.json").boxes()[0].center[1] == pytest.approx(5, abs=0.3)
    write_label(folder / "a.label", np.where(LABEL == CAR, PERSON, ROAD), np.zeros(len(LABEL), np.uint32))
    said = run(capsys, "edit", path.name, "--labels", "a.label", "--sensor", "few.json")
    assert "car_1" not in said  # labels that are given come first
    said = run(capsys, "edit", path.name, "--sensor", "few.json")
    assert MIRRORED in said
    found = re.search(r"car_1: car at [\d.]+,(\S+) ", said)
    assert found is not None
    assert float(found[1]) == pytest.approx(5, abs=0.3)
    assert "it has no intensities" in run(capsys, "pairs", path.name, "--sensor", "few.json", "-o", "p", status=2)


@pytest.mark.parametrize("ending", [".ply", ".npy"])
def test_tags_before_0_9_14(folder: Path, capsys: pytest.CaptureFixture[str], ending: str) -> None:
    path = folder / f"a{ending}"
    write = {".npy": write_npy, ".ply": write_semantic_ply}[ending]
    write(path, hits(TAGS_OLD))
    said = f"below the sensor {(LABEL == ROAD).sum()} hits have tags of poles, traffic lights or signs, and "
    with pytest.warns(UserWarning, match=f"{said}.* of the ground; these are tags of roads before CARLA 0.9.14"):
        read_carla(path)
    assert set(read_carla(path, TAGS_BEFORE_0_9_14).label) == {ROAD, CAR}
    observe = ("observe", path.name, "--sensor", "few.json", "--no-picture", "-o")
    assert said in run(capsys, *observe, "new")
    assert said not in run(capsys, *observe, "old", "--carla-tags", "0.9.13")
    assert said in run(capsys, "view", path.name, "--sensor", "few.json")
    draft = ("draft", "--points", path.name, "--no-preview", "-o", "l.json")
    assert said not in run(capsys, *draft, "--carla-tags", "0.9.13")
    assert [box.label for box in Layout.load("l.json").boxes()] == ["car"]
    write(path, hits(TAGS_NOW))
    assert "hits have tags" not in run(capsys, *observe, "right")


def write_semantic_ply(path: Path, columns: Columns) -> None:
    """As CARLA writes it, with its names of types."""
    write_ply(path, columns)
    path.write_bytes(path.read_bytes().replace(b"float ", b"float32 ").replace(b"uint ", b"uint32 "))


def test_the_other_lidar_of_carla_is_told(folder: Path) -> None:
    write_ply(folder / "a.ply", columns_of(I=DIM))
    with pytest.warns(
        UserWarning, match=r"x y z I are the fields of CARLA's LiDAR, whose y points right; y is read unchanged"
    ):
        np.testing.assert_array_equal(read_points(folder / "a.ply")[0], POINTS)


# Files of tools


def test_fields_without_values_and_whole_numbers_with_a_point(folder: Path) -> None:
    head = "FIELDS x y z _ ring _ t\nSIZE 4 4 4 1 2 4 8\nTYPE F F F U U U U\nCOUNT 1 1 1 0 1 0 1\nPOINTS 2\nDATA "
    record = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("ring", "<u2"), ("t", "<u8")])
    rows = np.array([(1, 2, 3, 6, 2**60 + 1), (4, 5, 6, 65535, 0)], record)
    for body in (b"binary\n" + rows.tobytes(), b"ascii\n1 2 3 6 1152921504606846977\n4 5 6 65535 0\n"):
        columns = parse_pcd(head.encode() + body).columns
        assert list(columns) == ["x", "y", "z", "ring", "t"]
        assert columns["ring"].tolist() == [6, 65535]
        assert columns["t"].tolist() == [2**60 + 1, 0]
    assert parse_pcd(head.encode() + b"ascii\n1 2 3 6.0 7.0\n4 5 6 65535.000 0.0").columns["ring"].tolist() == [
        6,
        65535,
    ]
    for word in ("6.5", "-1.0", "65536.0", "nan"):
        with pytest.raises(FormatError, match=rf"could not convert string '{word.removesuffix('.0')}' to uint16"):
            parse_pcd(head.encode() + f"ascii\n1 2 3 {word} 7\n4 5 6 1 0\n".encode())
    write_pcd(folder / "a.pcd", columns_of(ring=np.zeros(len(POINTS), "<f4")), text=True)
    np.testing.assert_allclose(read_points(folder / "a.pcd")[0], POINTS, atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "more", "called"),
    [
        ("<f4", 2, r"5 columns of float32 \(nuScenes' \.pcd\.bin\?\)"),
        ("<f4", 3, "6 columns of float32"),
        ("<f4", 0, "3 columns of float32"),
        ("<f8", 1, "4 columns of float64"),
        ("<f8", 2, "5 columns of float64"),
    ],
)
@pytest.mark.parametrize("command", [("view",), ("draft", "--no-preview", "-o", "l.json", "--points"), ("edit",)])
def test_bin_files_of_other_columns_are_named(
    capsys: pytest.CaptureFixture[str], kind: str, more: int, called: str, command: tuple[str, ...]
) -> None:
    extra = [DIM, np.arange(len(POINTS)) % 16, DIM][:more]
    np.column_stack([POINTS, *extra]).astype(kind).tofile("a.bin")
    assert re.search(
        f"a.bin looks like {called}; a KITTI scan is float32 x y z and intensity",
        run(capsys, *command, "a.bin", status=2),
    )


def test_scans_without_returns_are_told_plainly(capsys: pytest.CaptureFixture[str]) -> None:
    sky = Sensor(name="up", elevations=(0.5, 0.4), columns=64)
    sky.save("up.json")
    bare = ("simulate", "--text", "a car ahead", "--surroundings", "bare", "--sensor", "up.json", "-o", "none")
    run(capsys, *bare)
    assert Path("none/000000.bin").read_bytes() == b""
    for argv in (
        ["view", "none/000000.bin"],
        ["draft", "--points", "none/000000.bin", "-o", "l.json"],
        ["edit", "none/000000.bin"],
        ["pairs", "none/000000.bin", "-o", "p"],
    ):
        assert "none/000000.bin is empty: a scan without returns" in run(capsys, *argv, status=2)
    assert "it has no return" in run(capsys, "fit", "none/000000.bin", "-o", "s.json", status=2)
    run(capsys, "view", "none/000000.npz", "-o", "v.png")
    for form in ("kitti", "nuscenes", "pcd", "las"):
        run(capsys, "export", "none", "--format", form, "-o", form)


def test_npy_of_numbers_has_intensities_in_its_fourth_column(folder: Path) -> None:
    np.save(folder / "a.npy", np.column_stack([POINTS, DIM]))
    np.testing.assert_array_equal(read_points(folder / "a.npy")[1]["intensity"], DIM)
