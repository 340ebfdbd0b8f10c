"""The processes that make pairs: they end with the process that started them, however that ends."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from lidardraft.errors import LidarDraftError


@contextmanager
def process_pools(count: int) -> Iterator[list[ProcessPoolExecutor]]:
    """`count` pools of one process each; all have ended when the block is left.

    Raises `LidarDraftError` in place of the block's error where one of the processes was killed.
    """
    context = multiprocessing.get_context("spawn")  # a fork would copy the threads' locks
    pools = [ProcessPoolExecutor(1, mp_context=context, initializer=_follow_parent) for _ in range(count)]
    try:
        with _signals_held():
            for pool in pools:
                pool.submit(int)  # a pool starts its process with its first task
        yield pools
    except BrokenProcessPool:
        raise LidarDraftError(
            f"one of {count} worker processes was killed; with too little memory for {count}, ask for fewer workers"
        ) from None
    finally:
        for pool in pools:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _signals_held() -> Iterator[None]:
    """Ctrl-C, and SIGTERM as batch systems send it, go to a group of processes. Those started in this block never see
    them: their parent ends them."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _follow_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it could not be held
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end_after_parent() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end_after_parent, daemon=True).start()
