"""Semantic maps: guessed ranges, and the files that maps come from."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft import Layout, Primitive, Sensor, simulate
from lidardraft.errors import FormatError
from lidardraft.formats.recording import read_semantic_map
from lidardraft.scene.raycast import raycast
from lidardraft.scene.semantic_map import standing_on_ground
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 32)).tolist()), columns=128)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(90, 90, 0), label="road", id="road")
HOUSE = Primitive(shape="box", center=(20, 0, 2), size=(0.2, 30, 4), label="building", id="house")
SCENE = Layout((ROAD, HOUSE))


def test_flat_ground_and_what_stands_on_it_have_their_ranges() -> None:
    cast = raycast(SCENE, SENSOR)
    guessed = standing_on_ground(cast.label, SENSOR)
    np.testing.assert_array_equal(guessed.label, cast.label)
    road = cast.valid & (cast.label == BY_NAME["road"].id) & (cast.depth < 50)
    np.testing.assert_allclose(guessed.depth[road], cast.depth[road], rtol=1e-5)
    house = cast.label == BY_NAME["building"].id
    assert house.sum() > 100
    # it begins somewhere between two rows of the road: guesses are the nearer one
    assert (guessed.depth[house] <= cast.depth[house] * 1.001).all()
    assert np.median(cast.depth[house] / guessed.depth[house]) < 1.2


@pytest.mark.parametrize(
    ("label", "message"),
    [
        (np.ones((32, 64), np.uint8), r"the map is uint8 \(32, 64\); small needs whole numbers \(32, 128\)"),
        (np.ones(SENSOR.shape), "the map is float64"),
        (np.zeros(SENSOR.shape, np.uint8), "the map holds 0 to 0; classes are 1 to 20"),
        (np.full(SENSOR.shape, 21), "the map holds 21 to 21"),
    ],
)
def test_what_is_no_map_of_the_sensor(label: np.ndarray, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        standing_on_ground(label, SENSOR)


def test_maps_come_from_pictures_arrays_and_labelled_scans(tmp_path: Path) -> None:
    scan = simulate(SCENE, SENSOR)
    scan.save(tmp_path / "scan")
    np.save(tmp_path / "map.npy", scan.image.label)
    Image.fromarray(scan.image.label).save(tmp_path / "map.png")
    for name in ("scan.bin", "map.npy", "map.png"):
        np.testing.assert_array_equal(read_semantic_map(tmp_path / name, SENSOR), scan.image.label)
    (tmp_path / "scan.label").unlink()
    with pytest.raises(FormatError, match=r"scan.bin: it has no labels; a semantic map is made of them"):
        read_semantic_map(tmp_path / "scan.bin", SENSOR)
