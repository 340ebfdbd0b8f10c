"""The border of the compiled core: what it refuses, in which words, and that nothing has been written then."""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from lidardraft import _core
from lidardraft.errors import LayoutError, LidarDraftError, SensorError

PATTERN: dict[str, Any] = {
    "elevations": np.array([0.1, -0.1]),
    "azimuth_offsets": np.zeros(2),
    "origins": np.zeros((2, 3)),
    "columns": 8,
    "azimuth_start": np.pi,
    "azimuth_span": 2 * np.pi,
    "min_range": 0.5,
    "max_range": 100.0,
}
BALL: dict[str, Any] = {
    "shapes": np.array([1], np.uint8),
    "centers": np.array([[10.0, 0.0, 0.0]]),
    "sizes": np.array([[2.0, 2.0, 2.0]]),
    "yaws": np.zeros(1),
    "labels": np.array([13], np.uint8),
    "instances": np.array([4], np.uint32),
    "meshes": [],
}
DTYPES = {
    "depth": np.float32,
    "label": np.uint8,
    "instance": np.uint32,
    "primitive": np.int32,
    "incidence": np.float32,
    "normal": np.float32,
}
UNTOUCHED = 77


def images(scans: int = 2, rows: int = 2, columns: int = 8) -> dict[str, Any]:
    """Every image of some scans, full of a value that no scan of the ball writes."""
    shape = (scans, rows, columns)
    return {
        name: np.full((*shape, 3) if name == "normal" else shape, UNTOUCHED, dtype) for name, dtype in DTYPES.items()
    }


def poses(scans: int = 2, columns: int = 1) -> np.ndarray:
    return np.tile(np.eye(4), (scans, columns, 1, 1))


def given(name: str, array: Any) -> Callable[[dict[str, Any]], Any]:
    return lambda out: out.update({name: array})


def refuses(
    error: type[Exception],
    said: str,
    world_from_sensor: Any = None,
    change: Callable[[dict[str, Any]], Any] = lambda _: None,
    **options: Any,
) -> None:
    """`Scene.scan` raises, and every array is as it was before."""
    out = images()
    held = list(out.values())
    change(out)
    held += [array for array in out.values() if isinstance(array, np.ndarray)]
    before = [array.copy() for array in held]
    world_from_sensor = poses() if world_from_sensor is None else world_from_sensor
    with pytest.raises(error, match=said):
        _core.Scene(**BALL).scan(_core.SensorPattern(**PATTERN), world_from_sensor, **out, **options)
    for array, copy in zip(held, before, strict=True):
        np.testing.assert_array_equal(array, copy)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"sizes": np.array([[2.0, 0.0, 2.0]])}, "size"),
        ({"sizes": np.array([[2.0, -1.0, 2.0]])}, "size"),
        ({"centers": np.array([[np.nan, 0.0, 0.0]])}, "center"),
        ({"yaws": np.array([np.inf])}, "yaw"),
        ({"shapes": np.array([9], np.uint8)}, "9"),
        ({"labels": np.zeros(2, np.uint8)}, "2"),
        ({"shapes": np.array([4], np.uint8)}, "mesh"),
        ({"centers": np.zeros((1, 2))}, r"centers has the shape \[1, 2\]; it must be \[P, 3\]"),
    ],
)
def test_scenes_that_cannot_be(change: dict[str, Any], said: str) -> None:
    with pytest.raises(LayoutError, match=said):
        _core.Scene(**{**BALL, **change})


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("centers", np.zeros((1, 3), np.float32)),
        ("labels", np.zeros(1, np.int64)),
        ("instances", np.zeros(1, np.int32)),
        ("centers", np.asfortranarray(np.zeros((2, 3)))),
        ("yaws", [0.0]),
    ],
    ids=["float32", "int64", "int32", "fortran", "list"],
)
def test_other_arrays_are_refused(name: str, values: Any) -> None:
    with pytest.raises(TypeError, match=name):
        _core.Scene(**{**BALL, name: values})


def test_a_pattern_of_other_arrays_is_refused() -> None:
    with pytest.raises(TypeError, match="origins must be a C-contiguous array of float64 with 2 axes; it is float32"):
        _core.SensorPattern(**{**PATTERN, "origins": np.zeros((2, 3), np.float32)})
    with pytest.raises(LayoutError, match=r"origins has the shape \[2, 2\]; it must be \[H, 3\]"):
        _core.SensorPattern(**{**PATTERN, "origins": np.zeros((2, 2))})


@pytest.mark.parametrize(
    ("some", "error", "said"),
    [
        (poses(2, 3), LayoutError, "there are 3 poses for a scan; it must be 1, or 8, one for each column"),
        (poses(2, 0), LayoutError, "there are 0 poses"),
        (np.zeros((2, 1, 3, 4)), LayoutError, r"world_from_sensor has the shape \[2, 1, 3, 4\]; it must be"),
        (np.eye(4), TypeError, "world_from_sensor must be a C-contiguous array of float64 with 4 axes"),
        (poses().astype(np.float32), TypeError, "world_from_sensor .* it is float32"),
        (poses().swapaxes(2, 3), TypeError, "world_from_sensor .* a strided view"),
        (poses().tolist(), TypeError, "world_from_sensor .* it is a list"),
        (poses(3), SensorError, r"depth has the shape \[2, 2, 8\]; it must be \[3, 2, 8\]"),
    ],
    ids=["columns", "none", "3x4", "axes", "float32", "strided", "list", "scans"],
)
def test_poses_of_another_form(some: Any, error: type[Exception], said: str) -> None:
    refuses(error, said, some)


@pytest.mark.parametrize("name", DTYPES)
def test_images_of_another_form(name: str) -> None:
    right = images()[name]
    other = np.int64 if right.dtype != np.int64 else np.int32
    refuses(TypeError, f"{name} must be .* it is int64", change=given(name, right.astype(other)))
    refuses(TypeError, f"{name} must be .* it is a list", change=given(name, right.tolist()))
    refuses(TypeError, f"{name} must be .* with the shape", change=given(name, right[0]))
    refuses(TypeError, f"{name} must be .* a strided view", change=given(name, np.repeat(right, 2, axis=2)[:, :, ::2]))
    refuses(TypeError, f"{name} must be .* a strided view", change=given(name, np.asfortranarray(right)))
    for wrong in (right[:1], right[:, :1].copy(), right[:, :, :7].copy(), np.concatenate([right, right])):
        refuses(SensorError, rf"{name} has the shape \[.*\]; it must be \[2, 2, 8", change=given(name, wrong))
    locked = right.copy()
    locked.flags.writeable = False
    refuses(TypeError, f"{name} is read-only", change=given(name, locked))
    if right.itemsize > 1:
        shifted = np.zeros(right.nbytes + 1, np.uint8)[1:].view(right.dtype).reshape(right.shape)
        refuses(TypeError, f"{name} is not aligned", change=given(name, shifted))


def test_depth_label_and_instance_are_needed() -> None:
    for name in ("depth", "label", "instance"):
        refuses(TypeError, name, change=given(name, None))


@pytest.mark.parametrize(("one", "other"), list(itertools.combinations(DTYPES, 2)))
def test_images_that_share_memory(one: str, other: str) -> None:
    memory = np.full(4096, UNTOUCHED, np.uint8)

    def share(out: dict[str, Any]) -> None:
        for name in (one, other):
            out[name] = memory[: out[name].nbytes].view(out[name].dtype).reshape(out[name].shape)

    refuses(TypeError, f"{other} shares memory with an array that is in use", change=share)


def test_backends_and_threads_that_there_are_not() -> None:
    assert _core.backends()[-1] == "reference"
    names = ", ".join(_core.backends())
    refuses(LidarDraftError, f'backend is "cuda"; it must be one of {names}', backend="cuda")
    refuses(LidarDraftError, "threads is -1; it must be 0", threads=-1)
    refuses(LidarDraftError, "threads is 1000000; it must be 0", threads=1_000_000)
    refuses(TypeError, "threads", threads="two")


@pytest.mark.parametrize("backend", [None, *_core.backends()])
def test_a_scan_says_what_was_hit_and_what_was_not(backend: str | None) -> None:
    change = {"elevations": np.array([0.001, -0.3]), "azimuth_start": 0.02, "azimuth_span": 0.04, "columns": 1}
    pattern = _core.SensorPattern(**{**PATTERN, **change})
    out = images(1, 2, 1)
    _core.Scene(**BALL).scan(pattern, poses(1), **out, backend=backend)
    hit = {name: array[0, 0, 0] for name, array in out.items()}
    assert hit["depth"] == pytest.approx(9.0, abs=1e-3)
    assert (hit["label"], hit["instance"], hit["primitive"]) == (13, 4, 0)
    assert hit["incidence"] == pytest.approx(1.0, abs=1e-3)
    assert hit["normal"] == pytest.approx([-1.0, 0.0, 0.0], abs=0.02)
    missed = {name: array[0, 1, 0].tolist() for name, array in out.items()}
    assert missed == {"depth": 0, "label": 0, "instance": 0, "primitive": -1, "incidence": 0, "normal": [0, 0, 0]}


RAYS = np.ones((3, 3))


@pytest.mark.parametrize(
    ("origins", "directions", "error", "said"),
    [
        (RAYS[:, :2].copy(), RAYS, LayoutError, r"origins has the shape \[3, 2\]; it must be \[R, 3\]"),
        (RAYS.astype(np.float32), RAYS, TypeError, "origins must be .* it is float32"),
        (RAYS, np.asfortranarray(RAYS), TypeError, "directions must be .* a strided view"),
    ],
)
def test_rays_of_another_form(origins: np.ndarray, directions: np.ndarray, error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        _core.Scene(**BALL).cast(origins, directions)


ONE, TWO = np.zeros(1, np.uint32), np.zeros(2, np.uint32)


@pytest.mark.parametrize(
    ("primitives", "some", "error", "said"),
    [
        (ONE + 1, np.eye(4)[None], LayoutError, r"primitives\[0\] is 1; the scene has 1 primitives"),
        (TWO, poses()[:, 0], LayoutError, r"primitives\[1\] is 0, as is primitives\[0\]"),
        (ONE, poses()[:, 0], LayoutError, "primitives has 1 entries and world_from_primitive has 2"),
        (ONE, np.diag([2.0, 1, 1, 1])[None], LayoutError, r"world_from_primitive\[0\]: the rotation"),
        (ONE, np.zeros((1, 3, 4)), LayoutError, r"world_from_primitive has the shape \[1, 3, 4\]"),
        (ONE.astype(int), np.eye(4)[None], TypeError, "primitives must be a C-contiguous array of uint32"),
        (ONE, np.eye(4), TypeError, "world_from_primitive must be .* with 3 axes"),
    ],
    ids=["index", "twice", "count", "stretched", "3x4", "dtype", "axes"],
)
def test_moves_that_cannot_be(primitives: np.ndarray, some: np.ndarray, error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        _core.Scene(**BALL).moved(primitives, np.ascontiguousarray(some))
