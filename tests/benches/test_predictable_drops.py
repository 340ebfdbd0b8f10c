import numpy as np

from lidardraft.metrics.sweep import Sweep
from predictable_drops import features, measure


def _hits(rng: np.random.Generator, told: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Hits of which a tenth are lost: those that are far, or any."""
    known = rng.random((4000, 9))
    lost = known[:, 2] > 0.9 if told else rng.random(4000) > 0.9
    return known, lost, rng.random(4000) > 0.9


def test_lost_rays_are_told_where_the_layout_decides_them_and_else_not():
    rng = np.random.default_rng(0)
    decided = measure(_hits(rng, True), _hits(rng, True))
    assert decided["best threshold"] > 0.95
    assert decided["drawn"] > 0.9
    assert decided["simulated"] < 0.2
    assert measure(_hits(rng, False), _hits(rng, False))["best threshold"] < 0.25


def test_features_tell_the_steps_to_the_neighbours():
    points = np.zeros((2, 4, 3), dtype=np.float32)
    points[..., 0] = [[5, 5, 5, 5], [5, 5, 8, 5]]
    known = features(Sweep(points, label=np.ones((2, 4), dtype=np.uint8)))
    assert known.shape == (2, 4, 9)
    assert known[1, 1].tolist() == [1, 1, 5, 1, 0, 0, 0, 0, 3]
