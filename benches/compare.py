"""Our caster beside Open3D, embreex and Embree in packets, in one run: `make compare`, or `python benches/compare.py`.

Every peer casts the same rays into the same scenes (`scenes.py`), in a process of its own. In each round each peer is
asked once for each quantity, one after the other, so that a noisy machine is noisy for all; the table holds medians.
A peer that is not installed is left out with a line.

- "Build from arrays" ends with a structure that is ready to cast; "compile a layout" is our way there from a layout.
- The "bare cast" begins with rays (ours: with a pose) and ends with whatever the peer returns.
- "End to end" begins with a pose and ends with range, semantic and instance images in numpy, misses marked.
- "A pose for each column" is a scan with a rolling shutter, "batch" many scans in one call. No rival has such calls:
  beside them stand their bare cast and their end to end of one scan.
- "Packet Embree" is Embree's library called from C with packets of coherent rays that are made before the clock starts;
  only the intersect calls are timed. That time stands beside all that we cast.

"Same" is the share of rays with the same range, within 2 mm + 1e-5 of it, and with the same instance: for the triangles
as Open3D, for the analytic shapes as our own reference path, which casts one ray at a time.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import floor, log10
from pathlib import Path
from statistics import median

import numpy as np

from result_page import processor
from scenes import SCENES, Pattern, hdl64
from worker import PeerError, Worker

NAMES = ("open3d", "embreex", "packets", "analytic", "triangles")
EXPECTED = {"analytic": "reference", "triangles": "open3d", "packets": "open3d", "embreex": "open3d"}
SLOW = {"build": 3, "compile": 3, "batch": 3}  # rounds of what takes seconds in the heavy scene
# What is measured: its name, our method, and that of Open3D and embreex beside it. Packet Embree has a bare cast only,
# and stands with it beside all: rays from several origins cost it the same or more.
ROWS = (
    ("build from arrays", "build", "build"),
    ("compile a layout", "compile", "build"),
    ("bare cast", "cast", "cast"),
    ("end to end, `out=`", "scan", "scan"),
    ("end to end, new arrays", "scan_fresh", "scan"),
    ("a pose for each column", "rolling", "cast"),
    ("batch, one scan of it", "batch", "scan"),
)
QUANTITIES = ("build", "compile", "cast", "scan", "scan_fresh", "rolling", "batch", "single")
RIVALS = ("Open3D", "embreex", "packet Embree")
RATIOS = ("analytic / Open3D", "analytic / packets", "triangles / Open3D", "triangles / packets")
COLUMNS = ("scene", "measured", "threads", *RIVALS, "analytic", "triangles", *RATIOS, "same analytic", "same triangles")


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--threads", default=f"1,{os.cpu_count()}", help="numbers of threads, with commas")
    parser.add_argument("--scenes", default=",".join(SCENES), help=f"some of {', '.join(SCENES)}")
    parser.add_argument("--peers", default=",".join(NAMES), help=f"some of {', '.join(NAMES)}")
    parser.add_argument("--batch", type=int, default=1000, help="poses of a batch")
    parser.add_argument("--json", type=Path, help="write the seconds of all rounds to this file")
    given = parser.parse_args()
    threads = sorted({int(number) for number in given.threads.split(",")})
    names = given.scenes.split(",")
    if not set(names) <= set(SCENES) or threads[0] < 1:
        parser.error(f"scenes are {', '.join(SCENES)}, and threads 1 or more")
    workers = started(given.peers.split(","), threads)
    results, pattern = Results(), hdl64()
    print(machine(workers))
    print(f"{pattern.shape[0]} x {pattern.shape[1]} rays, medians of {given.rounds} rounds, times in ms\n")
    for name in names:
        measure(name, workers, pattern, results, given.rounds, given.batch)
    print(markdown(results, names, threads))
    print()
    for name in names:
        print("\n".join(f"- {line}" for line in notes(results, name, threads)))
    if given.json:
        seconds = [[*key, rounds] for key, rounds in results.seconds.items()]
        shares = [[*key, *both] for key, both in results.agreement.items()]
        given.json.write_text(json.dumps({"seconds": seconds, "agreement": shares}))
    for worker in workers:
        worker.stop()


def started(peers: list[str], threads: list[int]) -> list[Worker]:
    """A worker for each peer and number of threads; a line for each that there is not."""
    found = [_start(peer, number) for peer in peers for number in threads]
    return [worker for worker in found if worker is not None]


def _start(peer: str, threads: int) -> Worker | None:
    try:
        return Worker(peer, threads)
    except PeerError as error:
        print(f"without {peer} on {threads} threads: {error}", file=sys.stderr)
        return None


def measure(scene: str, workers: list[Worker], pattern: Pattern, results: Results, rounds: int, batch: int) -> None:
    """All rounds of one scene."""
    images = {}
    for worker in workers:
        images[worker.peer] = worker.load(scene, pattern)
        if worker.peer == "analytic":
            images["reference"] = worker.reference()
    for peer, expected in EXPECTED.items():
        if peer in images and expected in images:
            results.agreement[scene, peer] = agreement(images[expected], images[peer])
    most = max((worker.threads for worker in workers), default=1)
    asked = [(worker, quantity) for worker in workers for quantity in QUANTITIES if wanted(worker, quantity, most)]
    for step in range(rounds):
        for worker, quantity in asked:
            if step < SLOW.get(quantity, rounds):
                seconds = worker.seconds(quantity, step, batch) / (batch if quantity == "batch" else 1)
                results.add(scene, worker.peer, worker.threads, quantity, seconds)


def wanted(worker: Worker, quantity: str, most: int) -> bool:
    """One thread for all but a batch, which is for all threads; what a user calls for every number of them."""
    everywhere = quantity in ("cast", "scan") or most == 1
    return worker.offers(quantity) and (everywhere or (worker.threads == most) == (quantity == "batch"))


def machine(workers: list[Worker]) -> str:
    """What this ran on."""
    versions = ", ".join(sorted({worker.version for worker in workers}))
    return f"{processor()}, {os.cpu_count()} cores; Python {platform.python_version()}; {versions}"


def notes(results: Results, scene: str, threads: list[int]) -> list[str]:
    """Lines under the table: scans per second, Embree with single rays called from C, and whether the rivals agree."""
    lines = []
    for peer in ("analytic", "triangles"):
        seconds = results.median(scene, peer, threads[-1], "batch")
        if seconds is not None:
            lines.append(f"{scene}, {peer}, batch on {threads[-1]} threads: {1 / seconds:,.0f} scans/s")
    seconds = results.median(scene, "packets", threads[0], "single")
    if seconds is not None:
        lines.append(f"{scene}, Embree called from C with single rays: {1e3 * seconds:.2f} ms")
    for peer in ("packets", "embreex"):
        if (scene, peer) in results.agreement:
            near, same = results.agreement[scene, peer]
            lines.append(f"{scene}, {peer} as Open3D: same range {near:.3%}, same instance {same:.3%}")
    return lines


@dataclass
class Results:
    """What was measured: `seconds` of each round, by scene, peer, threads and quantity; `agreement`, by scene and peer,
    the shares of rays with the same range and with the same instance."""

    seconds: dict[tuple[str, str, int, str], list[float]] = field(default_factory=dict)
    agreement: dict[tuple[str, str], tuple[float, float]] = field(default_factory=dict)

    def add(self, scene: str, peer: str, threads: int, quantity: str, seconds: float) -> None:
        """One more round."""
        self.seconds.setdefault((scene, peer, threads, quantity), []).append(seconds)

    def median(self, scene: str, peer: str, threads: int, quantity: str) -> float | None:
        """Seconds, or None where nothing was measured."""
        measured = self.seconds.get((scene, peer, threads, quantity))
        return median(measured) if measured else None


def agreement(expected: tuple[np.ndarray, ...], got: tuple[np.ndarray, ...]) -> tuple[float, float]:
    """Shares of rays with the same range, within 2 mm + 1e-5 of it, and with the same instance."""
    near = np.abs(expected[0] - got[0]) <= 2e-3 + 1e-5 * expected[0]
    return float(near.mean()), float((expected[2] == got[2]).mean())


def markdown(results: Results, scenes: list[str], threads: list[int]) -> str:
    """The table: times in ms, ratios as how many times faster we are."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---|---|" + "---:|" * (len(COLUMNS) - 2)]
    for scene in scenes:
        for number in threads:
            lines += ["| " + " | ".join(cells) + " |" for cells in _rows(results, scene, number)]
    return "\n".join(lines)


def _rows(results: Results, scene: str, threads: int) -> Iterator[list[str]]:
    for name, ours, theirs in ROWS:
        mine = [results.median(scene, peer, threads, ours) for peer in ("analytic", "triangles")]
        open3d, embreex = (results.median(scene, peer, threads, theirs) for peer in ("open3d", "embreex"))
        packets = results.median(scene, "packets", threads, "build" if theirs == "build" else "cast")
        if not any(mine) and (ours != theirs or not any((open3d, embreex))):
            continue
        times = [_milliseconds(seconds) for seconds in (open3d, embreex, packets, *mine)]
        ratios = [_ratio(rival, own) for own in mine for rival in (open3d, packets)]
        same = [
            _same(results.agreement.get((scene, peer)) if ours == "cast" else None)
            for peer in ("analytic", "triangles")
        ]
        yield [scene, name, str(threads), *times, *ratios, *same]


def _milliseconds(seconds: float | None) -> str:
    return "" if seconds is None else three_digits(1e3 * seconds)


def _ratio(rival: float | None, own: float | None) -> str:
    return "" if rival is None or own is None else three_digits(rival / own) + "x"


def three_digits(value: float) -> str:
    """A number above 0 with three digits, all of those before the point: 0.0123, 12.3, 1234."""
    return f"{value:.{max(0, 2 - floor(log10(value)))}f}"


def _same(shares: tuple[float, float] | None) -> str:
    return "" if shares is None else "{:.3%}, {:.3%}".format(*shares)


if __name__ == "__main__":
    main()
