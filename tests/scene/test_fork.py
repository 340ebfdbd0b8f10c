"""A process that was forked from one that had cast scans: none of the threads of its parent are left in it."""

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection

import numpy as np
import pytest

from lidardraft import Layout, Primitive, RangeImage, Sensor
from lidardraft.scene.effects import observe
from lidardraft.scene.raycast import Raycaster

pytestmark = [
    pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="this system has no fork"),
    # Python from 3.12 on warns of what is tried here.
    pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning"),
]

LAYOUT = Layout((Primitive(shape="box", center=(8, 0, 0), size=(2, 9, 6), label="building", id="house"),))
CASTER = Raycaster(LAYOUT)
SENSOR = Sensor.preset("vlp16")


def scan(threads: int | None) -> np.ndarray:
    return CASTER.scan(SENSOR, threads=threads).depth


def scan_batch(threads: int | None) -> np.ndarray:
    return CASTER.scan_batch(SENSOR, np.stack([SENSOR.pose()] * 4), threads=threads).depth


def cast(threads: int | None) -> np.ndarray:
    directions = np.stack([np.ones(5000), np.linspace(-1, 1, 5000), np.zeros(5000)], axis=-1)
    return CASTER.cast(np.zeros((5000, 3)), directions, threads=threads).distance


def observed(threads: int | None) -> np.ndarray:
    clean = CASTER.scan(SENSOR, primitive=True, incidence=True, threads=threads)
    return observe(clean, LAYOUT, seed=0, threads=threads).depth


def projected(_: int | None) -> np.ndarray:
    points = np.stack([np.full(9000, 9.0), np.linspace(-9, 9, 9000), np.zeros(9000)], axis=-1)
    return RangeImage.project(points, SENSOR).depth


def send(pipe: Connection, work: Callable[[int | None], np.ndarray], threads: int | None) -> None:
    pipe.send(work(threads))


@pytest.mark.parametrize("threads", [1, 2, None])
@pytest.mark.parametrize("work", [scan, scan_batch, cast, observed, projected])
def test_a_forked_child_does_what_its_parent_did(work: Callable[[int | None], np.ndarray], threads: int | None):
    for before in (threads, 2):
        expected = work(before)
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=send, args=(theirs, work, threads), daemon=True)
    child.start()
    try:
        assert ours.poll(60), "the child hangs"
        np.testing.assert_array_equal(ours.recv(), expected)
    finally:
        child.kill()
        child.join()
    np.testing.assert_array_equal(work(2), expected)
