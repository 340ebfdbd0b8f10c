"""How long a sentence takes to become a scan, and how much memory: a part of report_generate.

    python benches/generated_speed.py WEIGHTS STEPS [--float32]

By itself it measures in its own process and prints JSON; `measure_speed` starts it, as peak memory is that of a
process.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np
import torch

from lidardraft import Pipeline
from tables import Goal, Row, table

SENTENCE = "two cars ahead, a pedestrian on the left sidewalk, trees on both sides and a bus behind"
ROUNDS = 5
CALLS = (4, 20)
NO_BFLOAT16 = {"ONEDNN_MAX_CPU_ISA": "AVX512_CORE_VNNI"}  # for oneDNN, which asks the processor


def measure_speed(weights: str) -> Iterator[str | Goal]:
    """A table of few calls and many in both precisions, then the goal."""
    rows = {f"{n} calls, {p}": in_process(weights, n, p) for n in CALLS for p in ("bfloat16", "float32")}
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield f"### Sentence to scan, hdl64e, {cores} cores\n\n{table(rows)}\n"
    yield Goal("memory, GB", {name: row["peak memory, GB"] for name, row in rows.items()}, most=1.0)


def in_process(weights: str, steps: int, precision: str) -> Row:
    """The row of a process that measures nothing else."""
    float32 = precision == "float32"
    command = [sys.executable, __file__, weights, str(steps), *["--float32"] * float32]
    environment = os.environ | (NO_BFLOAT16 if float32 else {})
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    found: Row = json.loads(done.stdout)
    return found


def _measured(pipeline: Pipeline) -> Row:
    """Seconds of a scan after a first one, and the peak memory of this process."""
    walls, processor = [], []
    for seed in range(ROUNDS):
        wall, used = time.perf_counter(), time.process_time()
        pipeline(SENTENCE, seed=seed)
        walls.append(time.perf_counter() - wall)
        processor.append(time.process_time() - used)
    unit = 1e9 if sys.platform == "darwin" else 1e6  # bytes there, kilobytes here
    return {
        "least, s": min(walls[1:]),
        "median, s": float(np.median(walls[1:])),
        "processor time, s": float(np.median(processor[1:])),
        "first, s": walls[0],
        "peak memory, GB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit,
    }


def main() -> None:
    """Measure, print."""
    weights, steps, *float32 = sys.argv[1:]
    if float32:
        torch.cpu.get_capabilities = dict  # type: ignore[attr-defined]
    print(json.dumps(_measured(Pipeline.from_pretrained(weights, steps=int(steps)))))


if __name__ == "__main__":
    main()
