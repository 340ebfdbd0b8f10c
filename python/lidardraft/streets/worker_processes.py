"""Processes that make pairs and scans: they end with their parent process, however it ends."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.context import SpawnContext
from multiprocessing.synchronize import Semaphore
from typing import Any, TypeVar

import numpy as np

from lidardraft.errors import LidarDraftError

T = TypeVar("T")
Item = TypeVar("Item")
_AHEAD = 2  # items in the queue of a process
_Layout = list[tuple[tuple[int, ...], np.dtype[Any]]]  # shapes and types of consecutive arrays


class WorkerProcess:
    """A process that runs one task after the other.

    The arrays of a result come through shared memory: a pipe takes three to six times as long. It has room for
    `array_bytes` of one result, and is free again as soon as that is copied.
    """

    def __init__(self, context: SpawnContext, array_bytes: int) -> None:
        shared, self._free = context.RawArray("B", max(array_bytes, 1)), context.Semaphore(1)
        self._memory = np.frombuffer(shared, dtype=np.uint8)
        self._pool = ProcessPoolExecutor(1, mp_context=context, initializer=_start, initargs=(shared, self._free))
        self._pool.submit(int)  # a pool starts its process with its first task

    def submit(self, task: Callable[..., tuple[list[np.ndarray], T]], *args: Any) -> Future[tuple[list[np.ndarray], T]]:
        """The future result of `task(*args)`, a function of a module: arrays, and its other return value."""
        result: Future[tuple[list[np.ndarray], T]] = Future()

        def receive(sent: Future[tuple[_Layout, T]]) -> None:
            try:
                layout, rest = sent.result()
                result.set_result((self._copied(layout), rest))
            except BaseException as error:  # is raised when the result is asked for
                result.set_exception(error)
            finally:
                self._free.release()

        self._pool.submit(_run, task, args).add_done_callback(receive)
        return result

    def shutdown(self) -> None:
        """Ends the process after its current task."""
        self._pool.shutdown(cancel_futures=True)

    def _copied(self, layout: _Layout) -> list[np.ndarray]:
        arrays, start = [np.empty(shape, dtype) for shape, dtype in layout], 0
        for array in arrays:
            array.reshape(-1).view(np.uint8)[:] = self._memory[start : start + array.nbytes]
            start += array.nbytes
        return arrays


@contextmanager
def worker_processes(count: int, array_bytes: int) -> Iterator[list[WorkerProcess]]:
    """`count` processes, with room for the arrays of one result each; all have ended when the block is left.

    Raises `LidarDraftError` in place of the block's error if one of the processes was killed.
    """
    context = multiprocessing.get_context("spawn")  # a fork would copy the threads' locks
    workers = list[WorkerProcess]()
    try:
        with _signals_held():
            workers += [WorkerProcess(context, array_bytes) for _ in range(count)]
        yield workers
    except BrokenProcessPool:
        raise LidarDraftError(
            f"one of {count} worker processes was killed; with too little memory for {count}, ask for fewer workers"
        ) from None
    finally:
        for worker in workers:
            worker.shutdown()


def in_processes(make: Callable[[Item], T], items: Iterable[Item], count: int, ahead: int = _AHEAD) -> Iterator[T]:
    """`make(item)` of each item as it is done, by `count` processes. These get `make` once, and `ahead` items at a
    time: with few long items, a second one would wait behind the first while another process is idle.

    Raises the errors of `make`, and `LidarDraftError` if a process was killed.
    """
    with worker_processes(count, 0) as processes:
        for begun in [process.submit(_begin, make) for process in processes]:
            begun.result()
        left, at_work = iter(items), dict[Future[tuple[list[np.ndarray], T]], WorkerProcess]()
        idle = processes * ahead
        while True:
            for process, item in zip(idle, left, strict=False):
                at_work[process.submit(_make, item)] = process
            if not at_work:
                return
            done = wait(at_work, return_when=FIRST_COMPLETED).done
            idle = [at_work.pop(future) for future in done]
            yield from (future.result()[1] for future in done)


_make_item: Callable[[Any], Any]  # of this worker process


def _begin(make: Callable[[Any], Any]) -> tuple[list[np.ndarray], None]:
    global _make_item
    _make_item = make
    warnings.simplefilter("ignore", UserWarning)  # the parent process has shown them
    return [], None


def _make(item: Any) -> tuple[list[np.ndarray], Any]:
    return [], _make_item(item)


@contextmanager
def _signals_held() -> Iterator[None]:
    """Hold Ctrl-C and the SIGTERM of batch systems, which go to a group of processes. Processes started in this block
    never see them: their parent ends them. It receives them itself after the block, so that no start of a process is
    left halfway."""
    if sys.platform == "win32":
        yield
        return
    from multiprocessing import resource_tracker  # which Windows does not have

    resource_tracker.ensure_running()  # a later start by itself would let signals through again
    # A mask is for one thread: signals to others, such as numpy's, are still handled in the main one.
    arrived: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    in_main_thread = threading.current_thread() is threading.main_thread()
    handlers = {number: signal.getsignal(number) for number in numbers if in_main_thread}
    held = [number for number, handler in handlers.items() if callable(handler)]
    for number in held:
        signal.signal(number, lambda came, _frame: arrived.append(came))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        for number in held:
            signal.signal(number, handlers[number])
        for came in arrived[:1]:
            signal.raise_signal(came)


_memory: np.ndarray  # of this worker process
_free: Semaphore  # whether the previous result is copied


def _start(shared: Any, free: Semaphore) -> None:
    global _memory, _free
    _memory, _free = np.frombuffer(shared, dtype=np.uint8), free
    _follow_parent()


def _run(task: Callable[..., tuple[list[np.ndarray], T]], args: tuple[object, ...]) -> tuple[_Layout, T]:
    try:
        arrays, rest = task(*args)
    finally:
        _free.acquire()  # until the parent has the previous result or error
    start = 0
    for array in arrays:
        _memory[start : start + array.nbytes] = array.reshape(-1).view(np.uint8)
        start += array.nbytes
    return [(array.shape, array.dtype) for array in arrays], rest


def _follow_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # in case it could not be held
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end_after_parent() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end_after_parent, daemon=True).start()
