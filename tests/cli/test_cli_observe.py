"""`lidardraft observe`."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft import RangeImage, Sensor, observe_cast
from lidardraft.cli import main as cli
from lidardraft.formats import kitti, semantickitti
from lidardraft.formats.carla import carla_sensor

ENDINGS = (".bin", ".label", ".sensor.json", ".png")


@pytest.fixture
def cast() -> RangeImage:
    """A cast of ours, in cast.npz."""
    cli.main(["raycast", "--text", "a car ahead", "--sensor", "small.json", "-o", "cast.npz"])
    return RangeImage.load("cast.npz")


def test_casts_are_observed_in_their_order(cast: RangeImage, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--material", "car=dark-paint", "--weather", "wet:1", "--seed", "5"]
    assert cli.main(["observe", "cast.npz", "cast.npz", "-o", "out", *options]) == 0
    assert {path.name for path in Path("out").iterdir()} == {f"00000{k}{end}" for k in range(2) for end in ENDINGS}
    assert "out: 2 scans, 000000.bin to 000001.bin, each with .label and .png" in capsys.readouterr().out
    points, intensity = kitti.read_bin("out/000000.bin")
    label, instance = semantickitti.read_label("out/000000.label", len(points))
    assert 0 < len(points) <= cast.valid.sum()
    assert len(np.unique(intensity)) > 3
    assert set(label) <= set(np.unique(cast.label))
    assert set(instance) <= set(np.unique(cast.instance))
    assert Path("out/000001.bin").read_bytes() != Path("out/000000.bin").read_bytes()
    assert cli.main(["observe", "cast.npz", "-o", "out", "--overwrite"]) == 0
    assert {path.name for path in Path("out").iterdir()} == {f"000000{end}" for end in ENDINGS}


def test_the_help_promises_no_sensor(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["observe", "--help"])
    assert "(default hdl64e)" not in " ".join(capsys.readouterr().out.split())


def test_a_cast_without_a_sensor_is_of_the_one_given(cast: RangeImage, refused: Callable[..., str]) -> None:
    np.savez("bare.npz", depth=cast.depth, label=cast.label.astype(np.int64))
    assert "bare.npz: it does not say by which sensor it is" in refused("observe", "bare.npz", "-o", "out")
    assert cli.main(["observe", "bare.npz", "--sensor", "small.json", "-o", "out"]) == 0
    expected = observe_cast(cast.depth, cast.label, Sensor.load("small.json"))
    np.testing.assert_array_equal(kitti.read_bin("out/000000.bin")[0], expected.points())


def test_clouds_of_carla_are_observed(refused: Callable[..., str]) -> None:
    Path("carla.json").write_text(carla_sensor(channels=4, points_per_second=14400, max_range=50.0).to_json())
    fields = ("float32 x", "float32 y", "float32 z", "float32 CosAngle", "uint32 ObjIdx", "uint32 ObjTag")
    head = ["ply", "format ascii 1.0", "element vertex 2", *(f"property {field}" for field in fields), "end_header"]
    rows = ["9.8481 0.0000 1.7365 0.9000 31 14", "8.6603 0.0000 -5.0000 0.5000 0 1"]
    Path("a.ply").write_text("\n".join([*head, *rows, ""]))
    assert "a.ply does not say by which sensor it is; give its --sensor" in refused("observe", "a.ply", "-o", "out")
    assert cli.main(["observe", "a.ply", "--sensor", "carla.json", "-o", "out"]) == 0
    points, _ = kitti.read_bin("out/000000.bin")
    np.testing.assert_allclose(points, [[9.85, 0, 1.74], [8.66, 0, -5.0]], atol=0.2)
    label, instance = semantickitti.read_label("out/000000.label", 2)
    assert label.tolist() == [13, 1]
    assert instance.tolist() == [31, 0]


def test_bad_input_is_one_line(cast: RangeImage, refused: Callable[..., str]) -> None:
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
