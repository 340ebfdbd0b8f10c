"""Worker processes: real ones, and none is left. What signals do to them: tests/cli/test_cli_streets_processes.py."""

import multiprocessing
import os
import signal
import threading
import time

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.streets.worker_processes import _signals_held, worker_processes


def test_each_is_a_process_of_its_own_and_ends_with_the_block():
    with worker_processes(2, 0) as workers:
        pids = {worker.submit(_pid).result()[1] for worker in workers}
        assert len(pids - {os.getpid()}) == 2
        assert pids <= {child.pid for child in multiprocessing.active_children()}
    assert not pids & {child.pid for child in multiprocessing.active_children()}


def test_they_end_when_the_block_raises_too():
    pids = set()

    def fail() -> None:
        with worker_processes(1, 0) as workers:
            pids.add(workers[0].submit(_pid).result()[1])
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert pids
    assert not pids & {child.pid for child in multiprocessing.active_children()}


def test_a_process_that_dies_is_an_error():
    killed = pytest.raises(LidarDraftError, match="one of 1 worker processes was killed")
    with killed, worker_processes(1, 0) as workers:
        workers[0].submit(os._exit, 3).result()


def test_arrays_arrive_whole_and_stay_as_they_are_while_others_come():
    sizes = (0, 1, 100, 7)
    with worker_processes(1, 8 * sum(sizes)) as workers:
        sent = [workers[0].submit(_ranges, first, sizes) for first in range(20)]
        results = [result.result() for result in sent]
    for first, (arrays, rest) in enumerate(results):
        expected, _ = _ranges(first, sizes)
        assert rest == first
        assert [array.dtype for array in arrays] == [array.dtype for array in expected]
        assert all(map(np.array_equal, arrays, expected))
        assert all(array.flags.writeable for array in arrays)


def test_a_task_that_fails_or_whose_result_cannot_be_sent_leaves_room_for_the_next():
    with worker_processes(1, 80) as workers:
        for task, error in ((_fail, ZeroDivisionError), (_not_to_be_sent, AttributeError), (_too_large, ValueError)):
            with pytest.raises(error):
                workers[0].submit(task).result()
        assert workers[0].submit(_ranges, 3, (2, 8)).result()[1] == 3


@pytest.mark.skipif(os.name == "nt", reason="signals come to all threads alike")
def test_an_interrupt_waits_until_a_process_has_started():
    started, leave = list[bool](), threading.Event()

    def start() -> None:
        with _signals_held():
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.1)
            started.append(True)

    other = threading.Thread(target=leave.wait)  # hears the signal, as threads of numpy do
    other.start()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            start()
        assert started
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
        leave.set()
        other.join()


def _pid() -> tuple[list[np.ndarray], int]:
    return [], os.getpid()


def _ranges(first: int, sizes: tuple[int, ...]) -> tuple[list[np.ndarray], int]:
    return [(first + np.arange(size)).astype("u1" if size == 7 else "f8") for size in sizes], first


def _fail() -> tuple[list[np.ndarray], None]:
    raise ZeroDivisionError


def _not_to_be_sent() -> tuple[list[np.ndarray], object]:
    return [np.ones(9)], lambda: None


def _too_large() -> tuple[list[np.ndarray], None]:
    return [np.ones(9), np.ones(2)], None
