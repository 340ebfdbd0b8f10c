"""Complete pairs of procedural streets a second, and where the time goes.

    python benches/bench_streets.py [--seconds 30] [--workers 2] [--sensor hdl64e] [--memory]

A pair is complete when the consumer holds it: the street built, scanned and observed, its coarse layout made and cast.
A labelled scan is complete when its files are written, as `lidardraft simulate --street` does. `--memory`
prints the resident memory as the pairs pass by.
"""

from __future__ import annotations

import argparse
import itertools
import os
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lidardraft import Scan, Sensor
from lidardraft.cli.scan_folder import ScanFolder
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.simulation.sweeps import Sweeper
from lidardraft.streets import StreetConfig, pairs, streets
from lidardraft.streets.scans import street_scan

MANY = 10**6  # scans, more than are ever written

# What is timed: the owners and names of the functions that do it. None of them calls another.
STAGES: dict[str, tuple[tuple[Any, str], ...]] = {
    "building": ((pairs, "make_street"), (Bodies, "of")),
    "casting": ((Sweeper, "cast"), (ShapeTable, "scan")),
    "sensor model": ((Sweeper, "observe"),),
    "coarse layout": ((pairs, "coarse_layout"),),
}


@contextmanager
def timed() -> Iterator[dict[str, float]]:
    """Seconds of this process's time spent in each stage."""
    seconds = dict.fromkeys(STAGES, 0.0)
    plain: list[tuple[Any, str, Callable[..., Any]]] = []

    def wrap(stage: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def wrapper(*args: Any, **kwargs: Any) -> Any:
            start = time.process_time()
            try:
                return function(*args, **kwargs)
            finally:
                seconds[stage] += time.process_time() - start

        return wrapper

    for stage, functions in STAGES.items():
        for owner, name in functions:
            # as it is stored: a class method is bound to no class there
            plain.append((owner, name, vars(owner)[name]))
            setattr(owner, name, wrap(stage, getattr(owner, name)))
    try:
        yield seconds
    finally:
        for owner, name, function in plain:
            setattr(owner, name, function)


def shares(seed: int, config: StreetConfig, num: int) -> dict[str, float]:
    """Milliseconds a pair of each stage, of all threads together."""
    with timed() as seconds:
        start = time.process_time()
        for _ in itertools.islice(streets(seed=seed, config=config), num):
            pass
        whole = time.process_time() - start
    return {stage: 1e3 * spent / num for stage, spent in {**seconds, "whole": whole}.items()}


def rate(seed: int, config: StreetConfig, workers: int, seconds: float, memory: bool) -> float:
    """Pairs a second as a consumer gets them, after the workers have started."""
    with closing(streets(seed=seed, config=config, workers=workers)) as pairs:
        for _ in itertools.islice(pairs, 2 * workers * config.poses_per_street):
            pass
        start, count, shown = time.perf_counter(), 0, 0.0
        for count, _ in enumerate(pairs, start=1):
            spent = time.perf_counter() - start
            if memory and spent >= shown:
                print(f"{count:8d} pairs {resident():8.1f} MB", flush=True)
                shown = spent + seconds / 10
            if spent >= seconds and count % config.poses_per_street == 0:
                break
        return count / (time.perf_counter() - start)


def written(seed: int, config: StreetConfig, workers: int, seconds: float, *, picture: bool) -> float:
    """Labelled scans a second in a folder, after the workers have started."""
    with TemporaryDirectory() as name:
        make = partial(street_scan, seed=seed, config=config, threads=1)
        folder = ScanFolder(Path(name), MANY if picture else 0, make, Scan.save)
        with closing(folder.write(MANY, jobs=workers, run=config.poses_per_street)) as scans:
            for _ in itertools.islice(scans, 2 * workers * config.poses_per_street):
                pass
            start = time.perf_counter()
            for count, _ in enumerate(scans, start=1):
                if time.perf_counter() - start >= seconds and count % config.poses_per_street == 0:
                    return count / (time.perf_counter() - start)
    raise AssertionError("so many scans are never written")


def resident() -> float:
    """Resident memory of this process and its children [MB]."""
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    pages = sum(int(Path(f"/proc/{number}/statm").read_text().split()[1]) for number in ("self", *children))
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Print rate and shares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--sensor", default="hdl64e")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--memory", action="store_true")
    arguments = parser.parse_args()
    os.environ["RAYON_NUM_THREADS"] = "1"  # a worker is one core
    config = StreetConfig(sensor=Sensor.preset(arguments.sensor))
    found = rate(arguments.seed, config, arguments.workers, arguments.seconds, arguments.memory)
    height, width = config.sensor.shape
    print(f"{found:.1f} pairs/s of {height} x {width}, {arguments.workers} workers, {config.poses_per_street} a street")
    for picture in (False, True):
        some = written(arguments.seed, config, arguments.workers, arguments.seconds / 3, picture=picture)
        print(
            f"{some:.1f} labelled scans/s written by {arguments.workers} jobs, {'with' if picture else 'no'} pictures"
        )
    alone = rate(arguments.seed, config, 1, arguments.seconds / 3, False)
    print(f"{alone:.1f} pairs/s in one process; hand-over {1e3 * (arguments.workers / found - 1 / alone):.2f} ms")
    milliseconds = shares(arguments.seed, config, 6 * config.poses_per_street)
    whole = milliseconds.pop("whole")
    for stage, spent in milliseconds.items():
        print(f"{stage:14} {spent:6.2f} ms {spent / whole:5.0%}")
    print(f"{'other':14} {whole - sum(milliseconds.values()):6.2f} ms")


if __name__ == "__main__":
    main()
