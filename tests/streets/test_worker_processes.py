"""Worker processes: real ones, and none is left. What signals do to them: tests/cli/test_cli_streets_processes.py."""

import multiprocessing
import os

import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.streets.worker_processes import process_pools


def test_each_pool_is_a_process_of_its_own_and_ends_with_the_block():
    with process_pools(2) as pools:
        pids = {pool.submit(os.getpid).result() for pool in pools}
        assert len(pids - {os.getpid()}) == 2
        assert pids <= {child.pid for child in multiprocessing.active_children()}
    assert not pids & {child.pid for child in multiprocessing.active_children()}


def test_they_end_when_the_block_raises_too():
    pids = set()

    def fail() -> None:
        with process_pools(1) as pools:
            pids.add(pools[0].submit(os.getpid).result())
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert pids
    assert not pids & {child.pid for child in multiprocessing.active_children()}


def test_a_process_that_dies_is_an_error():
    with pytest.raises(LidarDraftError, match="one of 1 worker processes was killed"), process_pools(1) as pools:
        pools[0].submit(os._exit, 3).result()
