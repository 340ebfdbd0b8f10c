"""`lidardraft profile`: the time of each step from a sentence to a scan on this machine."""

from __future__ import annotations

import argparse
import platform
import statistics
import sys
import time
from collections.abc import Callable
from typing import TypeVar

from lidardraft.cli.arguments import add_seed, add_sensor, add_weights, read_pipeline, read_sensor, whole_number
from lidardraft.cli.command import add_json, report
from lidardraft.cli.scan_folder import cores

T = TypeVar("T")
_SENTENCE = "a busy crossroads with parked cars, trees along both sides and people on the sidewalks"


def profile(arguments: argparse.Namespace) -> None:
    """Print a row for each step."""
    from lidardraft.drafting.cloud.layout import layout_from_cloud
    from lidardraft.drafting.text.layout import layout_from_text
    from lidardraft.scene.raycast import raycast
    from lidardraft.simulation.simulate import Simulator

    sensor, seed = read_sensor(arguments.sensor), arguments.seed
    head = f"{platform.machine()}, {cores()} cores, network on {arguments.device}; {sensor.name}; {arguments.runs} runs"
    columns = f"{'':36}{'first [s]':>11}{'median [s]':>11}{'peak [MB]':>11}"
    report(arguments, f"{head}\n{columns}", sensor=sensor.name, cores=cores(), device=arguments.device)
    layout = _timed(arguments, "sentence to layout", lambda: layout_from_text(_SENTENCE, seed=seed))
    _timed(arguments, "layout to condition image", lambda: raycast(layout, sensor))
    simulator = _timed(arguments, "layout to detailed objects", lambda: Simulator(layout, sensor, seed=seed))
    scan = _timed(arguments, "detailed objects to simulated scan", lambda: simulator.scan(seed=seed))
    points, labels = scan.points(), scan.labels()
    _timed(arguments, "scan to layout", lambda: layout_from_cloud(points, labels, sensor_height=sensor.mount_height))
    loaded = _timed(arguments, "weights into memory", lambda: read_pipeline(arguments))
    condition = scan.condition_image
    text = f"whole scan by the network, {loaded.steps} steps"
    _timed(arguments, text, lambda: loaded.generate(condition, seed=seed))


def _timed(arguments: argparse.Namespace, text: str, step: Callable[[], T]) -> T:
    """The result of a step; prints its row: the first run, which imports and compiles, and the median of the others."""
    times = []
    for _ in range(1 + arguments.runs):
        begun = time.perf_counter()
        given = step()
        times.append(time.perf_counter() - begun)
    first, median, peak = times[0], statistics.median(times[1:]), _peak()
    row = f"{text:36}{first:11.4f}{median:11.4f}{'-' if peak is None else f'{peak:.0f}':>11}"
    report(arguments, row, step=text, first_s=first, median_s=median, peak_mb=peak)
    return given


def _peak() -> float | None:
    """The peak memory [MB] of this process, if the system counts it."""
    if sys.platform == "win32":
        return None
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def profile_options(parser: argparse.ArgumentParser) -> None:
    """The options of `profile`."""
    parser.epilog = (
        "first: the first run, which imports and compiles. median: of the runs behind it. peak: the most memory that "
        "the process has had until then."
    )
    add_sensor(parser)
    add_weights(parser)
    parser.add_argument("--runs", type=whole_number(1), default=5, metavar="N", help="runs of each step (default 5)")
    add_seed(parser)
    add_json(parser)
