"""Simulated scans a second, and where the time goes.

    python benches/bench_simulate.py [--sensor hdl64e] [--scans 200] [--workers 2]

Three rates: scans of one detailed layout from many poses, by Python threads that share a `Simulator`; by processes,
scans of a new layout each; and of a sentence in a new street each. Milliseconds are of processor time, in one thread;
ratios and the overhead are medians of runs that alternate with what they are held against.
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np

from lidardraft import Layout, Raycaster, Sensor, Simulator, layout_from_text, surround
from lidardraft.scene.bodies import Bodies
from lidardraft.simulation.detail.detail import detail
from lidardraft.simulation.sweeps import Sweeper

SENTENCE = "a busy street with parked cars on both sides, people on the sidewalks, trees, houses and a bus ahead"
SPEED = 9.0  # m/s
STRETCH = 5.0  # m of the road, which is free that far


def milliseconds(function: Callable[[int], object], count: int = 20) -> float:
    """Of processor time a call, with the numbers 0, 1, ...: the median."""
    spent = []
    for number in range(count):
        start = time.process_time()
        function(number)
        spent.append(time.process_time() - start)
    return 1e3 * median(spent)


def poses_a_second(simulator: Simulator, sensor: Sensor, scans: int, workers: int) -> tuple[float, float]:
    """Scans of one layout a second, by threads; milliseconds of processor time for each."""
    poses = [sensor.pose(x=STRETCH * number / scans) for number in range(scans)]
    with ThreadPoolExecutor(workers) as pool:
        start, spent = time.perf_counter(), time.process_time()
        for _ in pool.map(partial(simulator.scan, speed=SPEED), poses):
            pass
        return scans / (time.perf_counter() - start), 1e3 * (time.process_time() - spent) / scans


def _seconds(layout: Layout | str, sensor: Sensor, seed: int) -> float:
    start = time.process_time()
    Simulator(layout, sensor, seed=seed, threads=1).scan(speed=SPEED, seed=seed)
    return time.process_time() - start


def layouts_a_second(layouts: Sequence[Layout | str], sensor: Sensor, scans: int, workers: int) -> tuple[float, float]:
    """Scans a second, of a layout or a sentence each, by processes; milliseconds of processor time for each."""
    each = list(itertools.islice(itertools.cycle(layouts), scans))
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        arguments = [sensor] * scans, range(scans)
        for _ in pool.map(_seconds, each[: 4 * workers], *arguments):  # the workers have started
            pass
        start = time.perf_counter()
        spent = sum(pool.map(_seconds, each, *arguments, chunksize=4))
        return scans / (time.perf_counter() - start), 1e3 * spent / scans


def overhead(simulator: Simulator, sweeper: Sweeper, bodies: Bodies, count: int = 60) -> float:
    """Milliseconds that `Simulator.scan` takes longer than a cast that is observed."""
    sensor = sweeper.sensor

    def bare(number: int) -> None:
        poses = sensor.poses_in_motion(sensor.pose(x=STRETCH * number / count), (SPEED, 0.0, 0.0))
        sweeper.scan(bodies, poses, number)

    more = []
    for number in range(count):
        start = time.process_time()
        simulator.scan(sensor.pose(x=STRETCH * number / count), speed=SPEED, seed=number)
        middle = time.process_time()
        bare(number)
        more.append(2 * middle - start - time.process_time())
    return 1e3 * median(more)


def shares(layouts: list[Layout], sensor: Sensor) -> dict[str, float]:
    """Milliseconds of each step."""
    scenes = [detail(layout, seed=0) for layout in layouts]
    sweeper, bodies = Sweeper.of(sensor, None, None, threads=1), [Bodies.of(scene) for scene in scenes]
    moving = sensor.poses_in_motion(sensor.pose(), (SPEED, 0.0, 0.0))
    clean = [sweeper.cast(each, (), moving, 0) for each in bodies]
    casters = [Raycaster(layout) for layout in layouts]
    count = len(layouts)
    return {
        "bare cast of the layout": milliseconds(lambda k: casters[k].scan(sensor, poses=moving, threads=1), count),
        "layout of the sentence": milliseconds(lambda k: layout_from_text(SENTENCE, seed=k), count),
        "street around it": milliseconds(lambda k: surround(layouts[k], seed=k), count),
        "detail": milliseconds(lambda k: detail(layouts[k], seed=0), count),
        "compiling": milliseconds(lambda k: Bodies.of(scenes[k]), count),
        "cast of the sub-rays": milliseconds(lambda k: sweeper.cast(bodies[k], (), moving, 0), count),
        "sensor model": milliseconds(lambda k: sweeper.observe(clean[k], bodies[k].surfaces, moving, 0), count),
    }


def main() -> None:
    """Print rates and shares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sensor", default="hdl64e")
    parser.add_argument("--scans", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    sensor = Sensor.preset(arguments.sensor)
    layouts = [layout_from_text(SENTENCE, seed=seed) for seed in range(12)]
    simulator = Simulator(layouts[0], sensor, threads=1)
    sweeper, bodies = Sweeper.of(sensor, None, None, threads=1), Bodies.of(simulator.scene)
    height, width = sensor.shape
    sizes = [len(detail(layout, seed=0)) for layout in layouts]
    shapes, workers = np.mean([len(layout) for layout in layouts]), arguments.workers
    print(f"{height} x {width}, {shapes:.0f} shapes, in detail {np.mean(sizes):.0f}")
    rate, spent = poses_a_second(simulator, sensor, arguments.scans, workers)
    print(f"{rate:.0f} scans/s of one layout from many poses, {workers} threads; {spent:.2f} ms a scan")
    for given, kind in ((layouts, "of a new layout each"), ([SENTENCE], "of the sentence in a new street each")):
        rate, spent = layouts_a_second(given, sensor, arguments.scans, workers)
        print(f"{rate:.0f} scans/s {kind}, {workers} processes; {spent:.2f} ms a scan")
    steps = shares(layouts, sensor)
    bare = steps["bare cast of the layout"]
    for step, spent in steps.items():
        print(f"{step:24} {spent:6.2f} ms {spent / bare:5.1f} x the bare cast")
    scan = simulator.scan()
    print(f"{'picture of a scan':24} {milliseconds(lambda _: scan.picture()):6.2f} ms")
    with TemporaryDirectory() as folder:
        for picture in (False, True):
            saved = milliseconds(lambda k, p=picture: scan.save(f"{folder}/{k}", picture=p))
            print(f"{'saved with a picture' if picture else 'saved':24} {saved:6.2f} ms")
    print(f"{'overhead of a scan':24} {overhead(simulator, sweeper, bodies):6.2f} ms over cast and sensor model")


if __name__ == "__main__":
    main()
