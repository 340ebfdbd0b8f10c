"""Processes that train together: each takes its share of a batch, and their gradients are added."""

from __future__ import annotations

import os
from dataclasses import dataclass

import torch
from torch import Tensor
from torch import distributed as dist

from lidardraft.errors import TrainingError


@dataclass(frozen=True)
class Processes:
    """The `rank`-th of `count` processes."""

    rank: int = 0
    count: int = 1

    @classmethod
    def from_environment(cls, device: torch.device) -> Processes:
        """The processes that `torchrun` or `accelerate launch` started, by the environment; or this one alone."""
        if int(os.environ.get("WORLD_SIZE", "1")) == 1:
            return cls()
        if not dist.is_initialized():
            dist.init_process_group("nccl" if device.type == "cuda" else "gloo")
        return cls(dist.get_rank(), dist.get_world_size())

    def share(self, scans: int) -> range:
        """The scans of a step for this process; raises `TrainingError` if one of the processes has none."""
        if scans < self.count:
            raise TrainingError(f"a step learns from {scans} scans, too few for {self.count} processes; raise --batch")
        return range(self.rank, scans, self.count)

    def add_up(self, tensor: Tensor) -> None:
        """Replace a tensor by the sum of those of all processes."""
        if self.count > 1:
            dist.all_reduce(tensor)

    def total(self, number: float, device: torch.device) -> float:
        """The sum of a number over all processes."""
        if self.count == 1:
            return float(number)
        tensor = torch.tensor(float(number), device=device)
        self.add_up(tensor)
        return tensor.item()

    def wait(self) -> None:
        """Wait until all processes are here."""
        if self.count > 1:
            dist.barrier()


ALONE = Processes()
