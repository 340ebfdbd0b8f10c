"""Streets that worker processes make while a network learns, for devices that learn faster than streets are made."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import IMAGES, Pair
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, streets
from lidardraft.training.processes import ALONE, Processes
from lidardraft.training.sources import CPU, PAIR_BYTES, free_memory, scans_of_step
from lidardraft.training.stack import PairStack, as_tensors

_POSES = 4  # of a street
_MOST = 16_000  # pairs that are kept
_LEAST = 16  # batches' worth of pairs before the first step


class StreetBank:
    """The newest pairs of the streets of a seed, made by `workers` processes and held on the device that learns.

    A step draws from the pairs that are there by then: a run is not the same twice, nor is one in slices the run in
    one. `running` starts the processes and ends them.
    """

    def __init__(self, seed: int, sensor: Sensor, workers: int) -> None:
        self.seed, self.sensor, self.workers = seed, sensor, workers
        self.sensors, self.path = (sensor,), Path("streets")
        self.source = f"streets of seed {seed}, {sensor.name}, made meanwhile"
        self.checksum = seed
        self.made = 0
        self._images: dict[str, Tensor] = {}
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._filling: Future[None] | None = None

    @contextmanager
    def running(self, processes: Processes, device: torch.device) -> Iterator[None]:
        """While the block runs, worker processes make the share of this one of several `processes`."""
        pair = PAIR_BYTES * int(np.prod(self.sensor.shape))
        free = torch.cuda.mem_get_info(device)[0] if device.type == "cuda" else free_memory()
        kept = _MOST if free is None else min(_MOST, free // 2 // pair)
        if kept < 1:
            raise TrainingError(f"{device} has no room for pairs of {self.sensor.name}, of {pair / 1e6:.1f} MB each")
        dtypes = {name: torch.int16 if dtype == np.uint16 else torch.uint8 for name, dtype in IMAGES.items()}
        self._images = {
            name: torch.zeros((kept, *self.sensor.shape), dtype=dtype, device=device) for name, dtype in dtypes.items()
        }
        self.made = 0
        self._ended.clear()
        with ThreadPoolExecutor(1) as thread:
            self._filling = thread.submit(self._fill, kept, processes)
            try:
                yield
            finally:
                self._ended.set()

    def _fill(self, kept: int, processes: Processes) -> None:
        config = StreetConfig(sensor=self.sensor, poses_per_street=_POSES, simulated=True)
        shard = (processes.rank, processes.count)
        with closing(streets(seed=self.seed, config=config, shard=shard, workers=self.workers)) as made:
            for pair in made:
                if self._ended.is_set():
                    return
                assert pair.simulated is not None
                images = as_tensors(Pair(pair.scan, pair.condition_image, pair.simulated).compact())
                with self._lock:
                    for name, image in images.items():
                        self._images[name][self.made % kept].copy_(image)
                    self.made += 1

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """Pairs drawn at random from those that are there (`PairSource.stack`)."""
        assert self._filling is not None, "the bank is not running"
        count = len(processes.share(scans_of_step(scans, self.sensor)))
        kept = len(self._images["scan_label"])
        while self.made < min(_LEAST * count, kept):
            if self._filling.done():
                self._filling.result()  # raises what ended it
            time.sleep(0.05)
        with self._lock:
            drawn = np.random.default_rng([self.seed, step, processes.rank]).integers(min(self.made, kept), size=count)
            at = torch.from_numpy(drawn).to(device)
            return PairStack.of(self.sensor, {name: rows[at] for name, rows in self._images.items()})
