"""Simulated scans: exact labels, the same bytes for the same seed, and one line for what cannot be."""

import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import Layout, Primitive, RangeImage, Sensor, Simulator, layout_from_text, on_relief, simulate, surround
from lidardraft.errors import LayoutError, LidarDraftError, SensorError, TextError
from lidardraft.scene import edit
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.weather import Weather
from lidardraft.simulation.detail.detail import detail
from lidardraft.simulation.sweeps import Sweeper

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=256)
SENTENCE = "two parked cars on the left, trees along both sides, a person ahead"
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")
CAR = Primitive(shape="box", center=(9, 1, 0.8), size=(4, 2, 1.5), label="car", id="car_4", instance=4)


@pytest.fixture(scope="module")
def layout() -> Layout:
    return layout_from_text(SENTENCE, seed=1)


def same(one: RangeImage, two: RangeImage) -> bool:
    return all(
        getattr(one, name).tobytes() == getattr(two, name).tobytes()
        for name in ("depth", "intensity", "label", "instance")
    )


def test_the_same_seed_gives_the_same_bytes_on_any_threads(layout: Layout) -> None:
    scans = [Simulator(layout, SMALL, seed=3, threads=threads).scan(speed=9.0, seed=3) for threads in (1, 2, 5)]
    again = simulate(layout, SMALL, seed=3, speed=9.0, threads=2)
    assert all(same(scan.image, again.image) for scan in scans)
    assert not same(simulate(layout, SMALL, seed=4, speed=9.0).image, again.image)
    simulator = Simulator(layout, SMALL, seed=3)
    with ThreadPoolExecutor(3) as pool:
        at_once = list(pool.map(lambda _: simulator.scan(speed=9.0, seed=3), range(9)))
    assert all(same(scan.image, again.image) for scan in at_once)


def test_an_edit_changes_what_it_hides_and_shows_and_nothing_else() -> None:
    crown = Primitive(
        shape="ellipsoid", center=(12, -4, 3), size=(4, 4, 3), label="vegetation", id="tree_1.crown", extinction=0.8
    )
    house = Primitive(shape="box", center=(20, 0, 4), size=(4, 30, 8), label="building", id="house_1")
    layout = Layout((ROAD, CAR, crown, replace(crown, center=(12, 6, 3), id="tree_2.crown"), house))
    sensor = replace(SMALL, elevations=tuple(np.deg2rad(np.linspace(14, -14, 28)).tolist()), columns=512)
    before = simulate(layout, sensor, seed=2)
    for edited, name in ((edit.remove(layout, "car_4"), "car_4"), (edit.move(layout, "tree_1", (0, 2, 0)), "tree_1")):
        after = simulate(edited, sensor, seed=2)
        clean, ids = [], []
        for scene in (detail(layout, seed=2), detail(edited, seed=2)):
            clean.append(Sweeper.of(sensor, None, None).cast(Bodies.of(scene), (), sensor.pose(), 2))
            ids.append(np.array([*(p.id for p in scene), "none"])[clean[-1].primitive])
        moved = clean[0].depth != clean[1].depth
        hidden_or_shown = np.char.startswith(ids[0], name) | np.char.startswith(ids[1], name)
        assert hidden_or_shown.any()
        assert (ids[0] == ids[1])[~hidden_or_shown].all()
        # beside an outline rays are cast in float64, which differs in the last digits of float32
        assert np.abs(clean[0].depth - clean[1].depth)[~hidden_or_shown].max() < 1e-4
        # a beam has three sub-rays, each a row of the cast
        unchanged = ~(moved | hidden_or_shown).reshape(28, 3, 512).any(axis=1)
        for image in ("depth", "intensity", "label", "instance"):
            same = getattr(before.image, image) == getattr(after.image, image)
            assert same[unchanged].all(), image


def test_a_sentence_is_laid_out_by_the_seed() -> None:
    scan = simulate(SENTENCE, SMALL, seed=5)
    level = surround(layout_from_text(SENTENCE, seed=5), seed=5)
    assert scan.layout.primitives[: len(level)] == on_relief(level).primitives
    assert same(scan.image, simulate(level, SMALL, seed=5).image)
    assert same(scan.image, simulate(scan.layout, SMALL, seed=5).image)
    with pytest.raises(TextError, match="xyzzy"):
        simulate("xyzzy", SMALL)


def test_labels_and_instances_are_those_of_what_was_hit() -> None:
    scan = simulate(Layout((ROAD, CAR)), SMALL)
    points, labels, instances = scan.points() + SMALL.pose()[:3, 3], scan.labels(), scan.instances()
    assert set(labels) == {1, 13}
    np.testing.assert_array_equal(instances, np.where(labels == 13, 4, 0))
    on_car = labels == 13
    assert on_car.sum() > 20
    assert (np.abs(points[on_car] - CAR.center) < np.array(CAR.size) / 2 + 0.5).all()
    assert np.abs(points[~on_car, 2]).max() < 0.5


def test_weather_and_model_are_used() -> None:
    layout = Layout((ROAD, CAR))
    clear = simulate(layout, SMALL)
    foggy = simulate(layout, SMALL, weather=Weather(visibility=20.0))
    backscatter = foggy.image.valid & (foggy.image.label == 0)
    assert backscatter.any()
    assert (foggy.image.instance[backscatter] == 0).all()
    assert np.count_nonzero(foggy.image.label) < np.count_nonzero(clear.image.label)
    assert not same(simulate(layout, SMALL, model=SensorModel.ideal()).image, clear.image)


def test_the_scene_is_the_layout_in_detail_or_as_it_is() -> None:
    layout = Layout((ROAD, CAR))
    assert Simulator(layout, SMALL, seed=3).scene == detail(layout, seed=3)
    assert Simulator(layout, SMALL, detail=False).scene == layout
    plain, lifelike = (simulate(layout, SMALL, detail=on) for on in (False, True))
    assert plain.layout == lifelike.layout == layout
    assert not same(plain.image, lifelike.image)


def test_a_layout_without_ground_is_a_warning_and_is_scanned() -> None:
    with pytest.warns(UserWarning, match="the layout has no ground") as found:
        scan = simulate(Layout((CAR,)), SMALL)
    assert len(found) == 1
    assert set(scan.labels()) == {13}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(Layout((ROAD,)), SMALL)


@pytest.mark.parametrize(
    ("kwargs", "error", "message"),
    [
        ({"speed": np.nan}, SensorError, "speed is nan; it must be a finite number"),
        ({"pose": np.full((4, 4), np.nan)}, LayoutError, "pose"),
        ({"pose": np.eye(3)}, LayoutError, r"pose has shape \(3, 3\)"),
        ({"seed": -1}, LidarDraftError, "seed"),
    ],
)
def test_bad_input_is_one_line(kwargs: dict[str, object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        simulate(Layout((ROAD, CAR)), SMALL, **kwargs)  # type: ignore[arg-type]


def test_simulating_loads_no_torch_and_a_layout_no_grammar() -> None:
    code = (
        "import sys, lidardraft; lidardraft.simulate(lidardraft.Layout(), lidardraft.Sensor.preset('vlp16')); "
        "print(sorted({'torch', 'sklearn', 'scipy'} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
