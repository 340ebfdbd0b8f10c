"""Every form of sensor through every public door: what comes out is right, or one line says why there is nothing.

A flat road and two cars: a return of the road lies on it, one of a car in its box, and each where its pixel looks.
"""

import copy
import math
import multiprocessing
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch.utils.data import DataLoader

from foreign_readers import READERS
from lidardraft import (
    Layout,
    ObjectSampling,
    Pipeline,
    Primitive,
    RangeImage,
    Raycaster,
    RecordedScan,
    Scan,
    Scenario,
    Sensor,
    SequenceSimulator,
    Simulator,
    edit_scan,
    observe_cast,
    observe_points,
    raycast,
    view,
)
from lidardraft.calibration.fit import fit_sensor
from lidardraft.cli import main as cli
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.errors import FormatError, SensorError
from lidardraft.formats.frame import FORMATS, writer_of
from lidardraft.formats.recording import read_points, recording_of
from lidardraft.scene.scenario import Straight
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.recorded.scan_edits import Insert
from lidardraft.training import recipes
from page_fields import fields_of_page

BEAMS = tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist())
TURN = Sensor(name="turn", elevations=BEAMS, columns=256, origin_heights=(0.1,) * 16)
SECTOR = replace(TURN, name="sector", columns=100, azimuth_start=1.2, azimuth_span=2.0)
ASIDE = (0.062, -0.028) * 8
ONE = {"elevations": (math.radians(-6),), "origin_heights": ()}
FLASH = {"elevations": tuple(np.linspace(0.15, -0.35, 40).tolist()), "origin_heights": (), "sweep_time": 0.0}
FORMS = {
    sensor.name: sensor
    for sensor in (
        TURN,
        SECTOR,
        replace(TURN, name="staggered", azimuth_offsets=ASIDE),
        replace(SECTOR, name="staggered sector", azimuth_offsets=ASIDE),
        replace(TURN, name="one beam", **ONE),
        replace(TURN, name="one column", columns=1, azimuth_start=0.01, azimuth_span=0.02),
        replace(TURN, name="one column of a turn", columns=1, azimuth_start=math.pi + 0.03),
        replace(TURN, name="blocked", blocked=(((2.5, 3.9),),) * 16),
        replace(TURN, name="no sweep time", sweep_time=0.0),
        replace(SECTOR, name="flash", columns=160, **FLASH),
    )
}
TOO_FEW = {  # what a fit says of them
    "one beam": "no laser has 100 returns of one kind at one distance; intensities need more scans",
    "one column": r"ring \d+ has \d+ returns; a laser needs 20 to be fitted",
    "one column of a turn": r"ring \d+ has \d+ returns; a laser needs 20 to be fitted",
}
CAR, PERSON = BY_NAME["car"].id, BY_NAME["person"].id
GROUND = [BY_NAME[name].id for name in ("road", "terrain")]
IMAGES = ("depth", "label", "instance", "intensity")


def car(number: int, x: float, y: float) -> Primitive:
    place = {"center": (x, y, 0.76), "size": (4.2, 1.8, 1.5)}
    return Primitive(shape="box", label="car", id=f"car_{number}", instance=number, **place)


def plane(label: str, reach: float, **more: bool) -> Primitive:
    return Primitive(shape="plane", center=(0, 0, 0), size=(reach, reach, 0), label=label, id=label, **more)


LAYOUT = Layout((plane("road", 200.0), car(1, 9, 0.3), car(2, -12, 4)))
OPEN = Layout((plane("road", 24.0), plane("terrain", 400.0, open=True), car(1, 9, 0.3)))


@pytest.fixture(scope="module", params=FORMS)
def sensor(request: pytest.FixtureRequest) -> Sensor:
    return FORMS[request.param]


@pytest.fixture(scope="module")
def simulator(sensor: Sensor) -> Simulator:
    return Simulator(LAYOUT, sensor)


@pytest.fixture(scope="module")
def scan(simulator: Simulator) -> Scan:
    return simulator.scan(speed=8.0, seed=1)


@pytest.fixture(scope="module")
def still(simulator: Simulator) -> Scan:
    return simulator.scan(seed=1)


def check(scan: Scan, sensor: Sensor, *, moved: float = 0.0) -> None:
    """Returns of the ground lie on it and those of a car in its box, whose way is `moved` [m] in half a sweep at
    most."""
    points, labels, instances = scan.points(), scan.labels(), scan.instances()
    assert len(points) > 5
    ground = points[np.isin(labels, GROUND)]
    assert len(ground) > 3
    # each laser of a unit is tilted a little
    assert (np.abs(ground[:, 2] + sensor.mount_height) < 0.1 + 2e-3 * np.linalg.norm(ground, axis=1)).all()
    assert (instances == 1).sum() >= 1
    for box in scan.boxes():
        assert box.contains(points[instances == box.instance], 0.3 + moved).all()  # mirrors, and noise
    step = sensor.azimuth_span / sensor.columns
    seen = scan.image.points()
    off = np.arctan2(seen[:, 1], seen[:, 0]) - sensor.azimuths[scan.image.valid]
    assert np.abs((off + math.pi) % math.tau - math.pi).max() < 0.5 * step
    assert not (scan.image.valid & sensor.blocked_pixels).any()


def test_raycast(sensor: Sensor) -> None:
    image = raycast(LAYOUT, sensor, primitive=True)
    height = sensor.mount_height + np.array(sensor.origin_heights or np.zeros(sensor.shape[0]))
    with np.errstate(divide="ignore"):
        depth = np.where(np.array(sensor.elevations) < 0, -height / np.sin(sensor.elevations), 0)[:, None]
    road = image.primitive == 0
    assert road.any()
    np.testing.assert_allclose(image.depth[road], np.broadcast_to(depth, sensor.shape)[road], rtol=1e-4)
    looked = np.abs(sensor.azimuths) < math.atan2(0.5, 6.9)  # at the car ahead, by beams that meet its rear
    rear = looked & (np.array(sensor.elevations) < math.radians(-5))[:, None] & (depth > 8)
    assert (image.instance[rear] == 1).all()
    assert (image.instance == 2).any() == (sensor.name in ("turn", "staggered", "one beam", "no sweep time"))


def test_simulate(scan: Scan, still: Scan, sensor: Sensor) -> None:
    check(scan, sensor)
    check(still, sensor)
    since_middle = np.arange(sensor.columns) / sensor.columns * sensor.sweep_time - sensor.sweep_time / 2
    way = 8.0 * since_middle[np.nonzero(scan.image.valid)[1]]
    np.testing.assert_allclose(scan.points() - scan.image.points(), way[:, None] * [1, 0, 0], atol=1e-4)


def test_pictures(scan: Scan, sensor: Sensor) -> None:
    picture = scan.picture()
    assert picture.shape == (788, 1400, 3)
    assert (picture[-146:-76] == view.PALETTE[CAR]).all(axis=2).any() or sensor.name == "one beam"  # of classes
    beams, columns = sensor.shape
    rendered = view.render_image(scan.image)
    strip = rendered[:: max(1, round(128 / beams))][:beams]
    looks = np.floor((sensor.azimuth_start - sensor.azimuths) / sensor.azimuth_span * columns).astype(int)
    looks = looks % columns if sensor.wraps else looks - min(0, looks.min())
    valid = scan.image.valid
    expected = np.zeros_like(strip)
    expected[np.nonzero(valid)[0], looks[valid]] = view.colour_by_depth(scan.image.depth[valid])
    assert (strip == expected).all()


def test_save_and_load(scan: Scan, tmp_path: Path) -> None:
    scan.save(tmp_path / "a")
    loaded = Scan.load(tmp_path / "a")
    assert loaded.image.sensor == scan.image.sensor
    for name in IMAGES:
        np.testing.assert_array_equal(getattr(loaded.image, name), getattr(scan.image, name))
    np.testing.assert_array_equal(loaded.poses(), scan.poses())
    np.testing.assert_array_equal(read_points(tmp_path / "a.bin")[0], scan.points())
    assert loaded.boxes() == scan.boxes()
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_html(scan: Scan, sensor: Sensor) -> None:
    held = fields_of_page(scan.html())
    points = np.stack([held[axis] for axis in "xyz"], axis=1)
    np.testing.assert_allclose(points, np.add(scan.points(), [0, 0, sensor.mount_height]), atol=0.004)
    assert held["label"].tolist() == scan.labels().tolist()


def test_sequence(sensor: Sensor, tmp_path: Path) -> None:
    scenario = Scenario(Straight(8.0), {"car_1": Straight(10.0)})
    made = SequenceSimulator(LAYOUT, sensor, scenario, frames=2)
    for number, frame in enumerate(pickle.loads(pickle.dumps(made))):
        check(frame, sensor, moved=0.5)
        assert frame.time == pytest.approx(0.1 * number + sensor.sweep_time / 2)
        assert frame.boxes()[0].velocity == pytest.approx((10.0, 0.0, 0.0))
        assert frame.boxes()[0].center[0] == pytest.approx(9 + 2 * frame.time)
        np.testing.assert_array_equal(frame.image.depth, made.frame(number).image.depth)
        frame.save(tmp_path / f"{number:06d}")
    assert cli.main(["view", str(tmp_path), "-o", str(tmp_path / "a.gif")]) == 0


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # webdataset leaves its files open
@pytest.mark.parametrize("name", FORMATS)
def test_exports(name: str, still: Scan, tmp_path: Path) -> None:
    frame = still.frame()
    writer_of(name)(tmp_path / "out", [[frame]])
    (found,) = READERS[name](tmp_path / "out")
    np.testing.assert_allclose(found.points[:, :3], frame.points, atol=6e-4)
    np.testing.assert_allclose(found.points[:, 3], frame.intensity, atol=1e-5)
    assert [annotation.num_points for annotation in frame.annotations] == still.returns_per_box()


def test_edit(still: Scan, sensor: Sensor) -> None:
    fields = {"intensity": still.intensities(), "label": still.labels(), "instance": still.instances()}
    recorded = RecordedScan.from_points(still.points(), sensor, boxes=still.boxes(), **fields)
    edited = edit_scan(recorded, [Insert("person", (5.0, 0.02))])
    box, new = edited.box("person_1"), edited.points[edited.label == PERSON]
    assert len(new) >= 2
    assert box.contains(new, 0.15).all()
    assert box.center[2] - box.size[2] / 2 == pytest.approx(-sensor.mount_height, abs=0.1)
    others = edited.points[edited.returned & (edited.label != PERSON)]
    assert {row.tobytes() for row in others} < {row.tobytes() for row in still.points()}
    sampling = ObjectSampling({"person": 2}, sensor, models=1, distances=(4.0, 20.0))
    points = np.column_stack([still.points(), still.intensities()])
    sample = {"points": points, "gt_boxes": np.zeros((0, 7), np.float32), "gt_names": np.zeros(0, str)}
    copied = pickle.loads(pickle.dumps(sampling))
    first, again = (each(dict(sample)) for each in (sampling, copied))
    for key, values in first.items():
        np.testing.assert_array_equal(again[key], values)


def test_observe(sensor: Sensor) -> None:
    cast = raycast(LAYOUT, sensor)
    observed = observe_cast(cast.depth, cast.label, sensor, instance=cast.instance)
    from_points = observe_points(cast.points(), cast.label[cast.valid], sensor, instance=cast.instance[cast.valid])
    for image in (observed, from_points):
        assert image.valid.sum() > 0.5 * cast.valid.sum()
        assert (image.label == cast.label)[image.valid].all()
        assert (image.instance == cast.instance)[image.valid].all()
        assert np.abs(image.depth - cast.depth)[image.valid].max() < 0.6  # lawns are uneven
        assert (image.intensity[image.valid] > 0).any()
        assert not (image.valid & ~cast.valid).any()


@pytest.mark.parametrize(
    "sensor",
    [
        pytest.param(name, marks=pytest.mark.slow if name in ("staggered", "no sweep time", "one beam") else ())
        for name in FORMS
    ],
    indirect=True,
    scope="module",
)
def test_fit(simulator: Simulator, sensor: Sensor) -> None:
    scans = [simulator.scan(sensor.pose(yaw=1.6 * seed), seed=seed) for seed in range(8)]
    rows = [(scan.points(), scan.intensities(), scan.image.beams()) for scan in scans]
    recordings = [recording_of("scan", points, intensity=read, ring=ring) for points, read, ring in rows]
    if sensor.name in TOO_FEW:
        with pytest.raises(FormatError, match=TOO_FEW[sensor.name]):
            fit_sensor(recordings, "mine", num_streets=2)
        return
    fitted = fit_sensor(recordings, "mine", num_streets=2).sensor
    low = np.array(sensor.elevations)[-5:][-len(fitted.elevations) :]
    np.testing.assert_allclose(fitted.elevations[-len(low) :], low, atol=3e-3)
    assert fitted.mount_height == pytest.approx(sensor.mount_height, abs=0.15)
    step = sensor.azimuth_span / sensor.columns
    assert math.tau / fitted.columns == pytest.approx(step, rel=0.1)
    pixels = replace(sensor, columns=1000, azimuth_start=math.pi, azimuth_span=math.tau, azimuth_offsets=())
    seen = np.abs(pixels.azimuths - (sensor.azimuth_start - sensor.azimuth_span / 2)) < sensor.azimuth_span / 2
    wanted = pixels.blocked_pixels | ~seen
    got = replace(fitted, columns=1000).blocked_pixels
    assert np.abs(got[-1].mean() - wanted[-1].mean()) < 0.04
    assert sensor.wraps or got.all(axis=0).mean() == pytest.approx(1 - sensor.azimuth_span / math.tau, abs=0.04)


@pytest.fixture(scope="module")
def pipeline() -> Pipeline:
    torch.manual_seed(0)
    return Pipeline(Denoiser.from_config(recipes.tiny()[-1].denoiser), steps=1)


def test_generate(pipeline: Pipeline, sensor: Sensor) -> None:
    if sensor.shape[0] % 2 or sensor.shape[1] % 4:
        with pytest.raises(SensorError, match=r"is \(\d+, \d+\); these weights need multiples of \(2, 4\)"):
            pipeline(OPEN, sensor=sensor)
        return
    made, other = (pipeline(layout, sensor=sensor, seed=1) for layout in (OPEN, LAYOUT))
    assert made.image.valid.any()
    np.testing.assert_array_equal(made.image.depth, other.image.depth)  # weights that have learned nothing heed nothing
    assert not (made.image.valid & sensor.blocked_pixels).any()


def test_copies(simulator: Simulator, still: Scan, sensor: Sensor) -> None:
    caster = Raycaster(LAYOUT)
    caster.move("car_1", sensor.pose(x=6.0))
    for copied in (pickle.loads(pickle.dumps((simulator, caster, still))), copy.deepcopy((simulator, caster, still))):
        np.testing.assert_array_equal(copied[0].scan(seed=1).image.depth, still.image.depth)
        np.testing.assert_array_equal(copied[1].scan(sensor).depth, caster.scan(sensor).depth)
        np.testing.assert_array_equal(copied[2].points(), still.points())


def test_workers_that_are_spawned_have_what_is_compiled() -> None:
    moved, sampling = Simulator(LAYOUT, TURN), ObjectSampling({"car": 3}, TURN, models=1)
    seen = moved.scan(seed=1)
    points = np.column_stack([seen.points(), seen.intensities()])
    samples = [{"points": points, "gt_boxes": np.zeros((0, 7), np.float32), "gt_names": np.zeros(0, str)}] * 2
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        scans = pool.map(moved.scan, [TURN.pose(), TURN.pose(x=3.0)], chunksize=2)
    workers = {"batch_size": None, "num_workers": 1, "multiprocessing_context": "spawn"}
    sampled = list(DataLoader(samples, collate_fn=sampling, **workers))
    for found, pose in zip(scans, (TURN.pose(), TURN.pose(x=3.0)), strict=True):
        np.testing.assert_array_equal(found.image.depth, moved.scan(pose).image.depth)
    for found, sample in zip(sampled, samples, strict=True):
        assert len(found["gt_boxes"]) > 0
        np.testing.assert_array_equal(found["points"], sampling(sample)["points"])


def test_commands(sensor: Sensor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    sensor.save("mine.json")
    LAYOUT.save("layout.json")
    mine = ["--layout", "layout.json", "--sensor", "mine.json"]
    assert cli.main(["simulate", *mine, "--speed", "8", "--seed", "1", "-o", "scans"]) == 0
    check(Scan.load("scans/000000"), sensor)
    assert Path("scans/000000.png").exists()
    assert cli.main(["raycast", *mine, "-o", "cast.npz"]) == 0
    np.testing.assert_array_equal(RangeImage.load("cast.npz").depth, raycast(LAYOUT, sensor).depth)
    for file, picture in (("scans/000000.bin", "a.png"), ("scans/000000.npz", "b.png"), ("cast.npz", "c.png")):
        assert cli.main(["view", file, "-o", picture]) == 0
    for name in ("scans/000000.bin", "cast.npz"):
        assert cli.main(["view", name, "-o", "a.html"]) == 0
    assert cli.main(["view", "layout.json", "--sensor", "mine.json", "-o", "d.png"]) == 0
    assert all(Path(f"{name}.png").stat().st_size > 5_000 for name in "abcd")
    assert cli.main(["observe", "cast.npz", "-o", "observed"]) == 0
    assert cli.main(["export", "scans", "observed", "--format", "pcd", "-o", "out"]) == 0
    np.testing.assert_allclose(read_points("out/000000.pcd")[0], Scan.load("scans/000000").points(), atol=1e-5)
