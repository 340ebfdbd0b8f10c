"""Bending of simulated scans: what passes through, and what is learned, on sweeps whose truth is known."""

import numpy as np
import pytest

import bend_to_recordings as bench
from lidardraft.metrics.sweep import Sweep
from lidardraft.semantics import BY_NAME


@pytest.fixture(scope="module")
def examples() -> list[bench.Example]:
    """Sweeps of road and building whose recordings read half as much, and lose what is bright."""
    rng = np.random.default_rng(0)
    found = []
    for _ in range(4):
        shape = (16, 256)
        points = np.zeros((*shape, 3), np.float32)
        points[..., 0], points[..., 1], points[8:, :, 2] = 10.0, rng.normal(size=shape), -1.7
        label = np.where(np.arange(16)[:, None] < 8, BY_NAME["building"].id, BY_NAME["road"].id)
        label = np.broadcast_to(label, shape).astype(np.uint8)
        intensity = rng.uniform(0.1, 0.9, shape).astype(np.float32)
        lost = intensity > 0.8
        recorded = Sweep(np.where(lost[..., None], np.float32(0), points), label, intensity / 2)
        found.append(bench.Example(recorded, Sweep(points, label, intensity), firings=True))
    return found


def test_a_network_learns_what_is_read_and_what_is_lost(examples: list[bench.Example]) -> None:
    network = bench.trained(examples[:3], steps=400)
    bent = bench.by_network(network)(examples[3].simulated, 0)
    truth = examples[3].recorded
    both = bent.valid & truth.valid
    assert abs(bent.intensity[both].mean() - truth.intensity[both].mean()) < 0.03
    assert bent.valid[~truth.valid].mean() < bent.valid[truth.valid].mean() - 0.05
