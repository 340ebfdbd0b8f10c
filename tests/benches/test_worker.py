"""Peers in processes of their own, and how a call is timed."""

import time

import numpy as np
import pytest

from scenes import hdl64, pose
from worker import PeerError, Worker, timed


class Sleeper:
    """Something to time: 5 ms a call after 10 ms of aiming, and 50 ms more on the first call."""

    def __init__(self) -> None:
        self.aimed: list[int] = []
        self.called: list[int] = []

    def aim_cast(self, step: int) -> None:
        self.aimed.append(step)
        time.sleep(0.01)

    def cast(self, step: int) -> None:
        self.called.append(step)
        time.sleep(0.055 if len(self.called) == 1 else 0.005)


def test_neither_the_first_call_nor_aiming_counts() -> None:
    peer = Sleeper()
    seconds = timed(peer, "cast", lambda step: step, 40)
    assert peer.aimed == peer.called
    assert len(peer.called) > 1
    assert peer.called[-1] > 40  # a new pose for each call: nothing to gain from keeping a result
    assert 0.005 <= seconds <= 0.05  # what sleeps 5 ms took 5 ms or more, and not the 55 ms of the first call


def test_a_peer_that_is_not_there_says_so() -> None:
    with pytest.raises(PeerError, match="peer_of_nothing"):
        Worker("peer_of_nothing", 1)


def test_our_peer_works_from_its_process() -> None:
    worker = Worker("peer_analytic", 1)
    try:
        assert worker.peer == "analytic"
        assert "lidardraft" in worker.version
        depth, semantic, instance = worker.load("small", hdl64(beams=4, columns=64))
        assert depth.shape == semantic.shape == instance.shape == (4, 64)
        for image, same in zip(worker.reference(), (depth, semantic, instance), strict=True):
            np.testing.assert_allclose(image, same, rtol=1e-5, atol=2e-3)
        assert worker.offers("rolling")
        assert not worker.offers("single")
        assert worker.seconds("cast", 0, 1) > 0
        assert worker.seconds("batch", 0, 3) > 0
        with pytest.raises(PeerError, match="single"):
            worker.seconds("single", 0, 1)
        assert pose(0).shape == (4, 4)
    finally:
        worker.stop()
