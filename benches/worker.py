"""One peer in a process of its own, driven over a pipe, so that the threads of one do not disturb the next."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from peers import PEERS
from scenes import SCENES, Pattern, column_poses, pose, poses

_BURST = 0.02  # s
# One BLAS thread: spinning workers of one peer's matrix product would disturb whoever is measured next.
_BLAS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")


class PeerError(RuntimeError):
    """What a peer could not do."""


class Worker:
    """A peer of `PEERS`, by its name. Raises `PeerError` if it cannot be made, or cannot do what it is asked for."""

    def __init__(self, peer: str, threads: int) -> None:
        os.environ.update(dict.fromkeys(_BLAS, "1"))  # the process to be started reads them
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(other, peer, threads), daemon=True)
        self._process.start()
        other.close()
        self.peer, self.threads = peer, threads
        self.version: str = self._answer()

    def load(self, scene: str, pattern: Pattern) -> tuple[np.ndarray, ...]:
        """Build the scene, and the images of it from `pose(0)`: range f32, semantic u8, instance i32 [H, W]."""
        return self._ask("load", scene, pattern)

    def reference(self) -> tuple[np.ndarray, ...]:
        """The images that the peer's own simple path makes from `pose(0)`."""
        return self._ask("reference")

    def offers(self, quantity: str) -> bool:
        """Whether the peer has such a method."""
        return self._ask("offers", quantity)

    def seconds(self, quantity: str, step: int, scans: int) -> float:
        """Time of one call of a method of the peer: the mean over about 20 ms of calls, each with another pose.

        `scans` is the number of poses of a "batch".
        """
        return self._ask("seconds", quantity, step, scans)

    def stop(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.join(timeout=5)

    def _ask(self, *request: Any) -> Any:
        self._pipe.send(request)
        return self._answer()

    def _answer(self) -> Any:
        try:
            fine, answer = self._pipe.recv()
        except EOFError:
            fine, answer = False, f"its process ended with {self._process.exitcode}"
        if not fine:
            raise PeerError(answer)
        return answer


def _serve(pipe: Connection, name: str, threads: int) -> None:
    try:
        peer = PEERS[name](threads)
    except Exception as error:  # whatever keeps it from being there is the answer
        pipe.send((False, f"{type(error).__name__}: {error}"))
        return
    pipe.send((True, peer.version))
    bench = Bench(peer)
    while True:
        try:
            command, *arguments = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send((True, getattr(bench, command)(*arguments)))
        except Exception as error:
            pipe.send((False, f"{type(error).__name__}: {error}"))


class Bench:
    """A peer with a scene: what a `Worker` asks for, in this process."""

    def __init__(self, peer: Any) -> None:
        self.peer = peer

    def load(self, scene: str, pattern: Pattern) -> tuple[np.ndarray, ...]:
        """See `Worker.load`."""
        self.scene, self.pattern = SCENES[scene](), pattern
        self.peer.build(self.scene)
        self.peer.prepare(pattern)
        images = getattr(self.peer, "images", None) or self.peer.scan
        return tuple(image.copy() for image in images(pose(0)))

    def reference(self) -> tuple[np.ndarray, ...]:
        """See `Worker.reference`."""
        return self.peer.reference(pose(0))

    def offers(self, quantity: str) -> bool:
        """See `Worker.offers`."""
        return hasattr(self.peer, quantity)

    def seconds(self, quantity: str, step: int, scans: int) -> float:
        """See `Worker.seconds`."""
        argument: dict[str, Callable[[int], Any]] = {
            "build": lambda _: self.scene,
            "compile": lambda _: self.scene,
            "rolling": lambda k: column_poses(k, self.pattern.shape[1]),
            "batch": lambda k: poses(k, scans),
        }
        return timed(self.peer, quantity, argument.get(quantity, pose), step)


def timed(peer: Any, quantity: str, argument: Callable[[int], Any], step: int) -> float:
    """Seconds a call of the peer's method `quantity` takes; what its `aim_` method does before each is not counted."""
    call, aim = getattr(peer, quantity), getattr(peer, f"aim_{quantity}", None)
    spent, calls = 0.0, 0
    warm = False  # the first call wakes threads and caches after the other peers ran, and does not count
    while spent < _BURST:
        given = argument(step + calls)
        if aim is not None:
            aim(given)
        start = time.perf_counter()
        call(given)
        if warm:
            spent += time.perf_counter() - start
            calls += 1
        warm = True
    return spent / calls
