"""How much faster two worker processes make a data set than one.

    python benches/dataset_workers.py [--scans 96] [--rounds 3]

In turns: `lidardraft dataset` with one process, with `--jobs 2`, and two calls at once that share nothing, each with
half of the shards: more than theirs no two workers can do on the machine as it is then. The medians of all rounds, in
scans a second, and the processor time that each scan took.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

RECIPE = """
scans = 1
seed = 1
shard_size = 8
[[scene]]
text = ["{count} cars ahead, a bus on the left", "a busy crossroads with {count} pedestrians"]
words.count = { from = 2, to = 6 }
[[scene]]
street = ["urban", "residential", "avenue"]
"""
WAYS = {
    "one process": [["--jobs", "1"]],
    "--jobs 2": [["--jobs", "2"]],
    "two calls": [["--jobs", "1", "--shard", "0/2"], ["--jobs", "1", "--shard", "1/2"]],
}


def rates(calls: list[list[str]], scans: int) -> tuple[float, float]:
    """Scans a second, and seconds of processors that a scan takes, of calls at once that make a set."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "recipe.toml").write_text(RECIPE)
        command = [sys.executable, "-m", "lidardraft", "dataset", "recipe.toml", "-n", str(scans), "-o", "set"]
        begun, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        running = [subprocess.Popen([*command, *more], cwd=folder, stdout=subprocess.DEVNULL) for more in calls]
        if max([process.wait() for process in running]):  # all of them
            raise SystemExit("a call failed")
        took, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return scans / took, used / scans


def main() -> None:
    """Print a line for each way, with its ratio to one process."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scans", type=int, default=96)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    found = [[rates(calls, arguments.scans) for calls in WAYS.values()] for _ in range(arguments.rounds)]
    middle = np.median(np.array(found), axis=0)
    for name, (rate, used) in zip(WAYS, middle, strict=True):
        print(f"{name}: {rate:.1f} scans/s, {rate / middle[0, 0]:.2f} times one; {1e3 * used:.0f} ms of a core a scan")


if __name__ == "__main__":
    main()
