"""Embree driven the fastest way it offers, as a peer: packets of coherent rays, called from compiled code.

`embree_packets.c` is compiled for it with the system's C compiler, and linked to the Embree 4 that the embreex package
ships, or else that the system has. One call for all rays is timed; what it costs to make the rays, or images from the
hits, is not.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import importlib.util
import os
import shutil
import subprocess
import time
from ctypes import POINTER, c_char_p, c_float, c_int, c_int32, c_size_t, c_uint, c_void_p
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import scenes
from scenes import MAX_RANGE, Pattern, Scene

SOURCE = Path(__file__).with_name("embree_packets.c")
_FLAGS = ("-O2", "-std=c11", "-D_GNU_SOURCE", "-shared", "-fPIC")
_SIGNATURES = {
    "native_width": (c_int, []),
    "tracer_has_threads": (c_int, []),
    "tracer_new": (c_void_p, [POINTER(c_float), c_size_t, POINTER(c_uint), c_size_t, c_char_p]),
    "tracer_free": (None, [c_void_p]),
    "tracer_rays": (c_int, [c_void_p, POINTER(c_float), POINTER(c_float), c_size_t, c_size_t, c_float]),
    "tracer_cast": (None, [c_void_p, c_int]),
    "tracer_hits": (None, [c_void_p, POINTER(c_float), POINTER(c_int32)]),
}


def embree_library() -> str:
    """Where Embree 4 is: the copy in the embreex package, or the system's. Raises `RuntimeError` if there is none."""
    package = importlib.util.find_spec("embreex")
    if package is not None and package.origin is not None:
        folder = Path(package.origin).parent
        for place in (folder.with_name("embreex.libs"), folder / ".dylibs"):
            for library in sorted(place.glob("libembree4*")):
                return str(library)
    system = ctypes.util.find_library("embree4")
    if system is None:
        raise RuntimeError("no Embree 4: neither the embreex package nor a library of the system")
    return system


def compiled(embree: str) -> ctypes.CDLL:
    """`embree_packets.c` as a loaded library. Raises `RuntimeError` without a compiler, or with what it said."""
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None:
        raise RuntimeError("no C compiler")
    folder = Path(embree).parent
    link = [embree, f"-Wl,-rpath,{folder}"] if folder.name else ["-lembree4"]
    with TemporaryDirectory() as scratch:
        target = os.path.join(scratch, "packets.so")
        for threads in (["-fopenmp"], []):  # without OpenMP it still casts on one thread
            command = [compiler, *_FLAGS, *threads, str(SOURCE), *link, "-o", target]
            result = subprocess.run(command, capture_output=True, text=True, check=False)
            if result.returncode == 0:
                break
        else:
            raise RuntimeError(f"{compiler} cannot compile {SOURCE.name}: {result.stderr.strip()[-300:]}")
        library = ctypes.CDLL(target)
    for name, (returned, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = returned, arguments
    return library


class Peer:
    """Build and cast, as the benchmarks time them: in the packets that are fastest, or as single rays."""

    def __init__(self, threads: int) -> None:
        embree = embree_library()
        self.threads = threads
        self.library = compiled(embree)
        self.tracer: int | None = None
        self.native = self.library.native_width()
        self.version = f"packets of up to {self.native} rays in {Path(embree).name}"
        if threads > 1 and not self.library.tracer_has_threads():
            raise RuntimeError("the C compiler has no OpenMP")

    def build(self, scene: Scene) -> None:
        """Compile the mesh, with the robust flag."""
        if self.tracer is not None:
            self.library.tracer_free(self.tracer)
        self.scene = scene
        config = f"threads={self.threads}".encode()
        verts, faces = scene.verts, scene.faces
        self.tracer = self.library.tracer_new(_floats(verts), len(verts), _uints(faces), len(faces), config)

    def prepare(self, pattern: Pattern) -> None:
        """Keep the pattern, and find out whether packets of 8 rays are faster than those of 16.

        Only what the processor traces as it is comes into question: Embree takes wider packets apart, ray by ray.
        """
        self.pattern = pattern
        self.width = min({min(self.native, 8), self.native}, key=self._cost)

    def aim_cast(self, pose: np.ndarray) -> None:
        """Packets for the next cast, before the clock starts."""
        self._aim(pose, self.width)

    def aim_single(self, pose: np.ndarray) -> None:
        """Single rays for the next cast, before the clock starts."""
        self._aim(pose, 1)

    def cast(self, _pose: np.ndarray) -> None:
        """Cast the packets that `aim_cast` made; the hits stay in Embree's layout."""
        self.library.tracer_cast(self.tracer, self.threads)

    def single(self, _pose: np.ndarray) -> None:
        """Cast the rays that `aim_single` made; the hits stay in Embree's layout."""
        self.library.tracer_cast(self.tracer, self.threads)

    def images(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W] of one cast."""
        self.aim_cast(pose)
        self.cast(pose)
        distance, face = np.empty(self.pattern.shape, np.float32), np.empty(self.pattern.shape, np.int32)
        self.library.tracer_hits(self.tracer, _floats(distance), face.ctypes.data_as(POINTER(c_int32)))
        return self.scene.images(distance, face, self.pattern.shape)

    def _aim(self, pose: np.ndarray, width: int) -> None:
        origin, directions = self.pattern.rays(pose)
        rays = _floats(np.ascontiguousarray(directions))
        if not self.library.tracer_rays(self.tracer, _floats(origin), rays, len(directions), width, MAX_RANGE):
            raise RuntimeError(f"{len(directions)} rays are no packets of {width}")

    def _cost(self, width: int) -> float:
        seconds = []
        for step in range(5):
            self._aim(scenes.pose(step), width)
            start = time.perf_counter()
            self.library.tracer_cast(self.tracer, self.threads)
            seconds.append(time.perf_counter() - start)
        return min(seconds)


def bench_peer(n_threads: int) -> Peer:
    """Embree in packets."""
    return Peer(n_threads)


def _floats(array: np.ndarray) -> ctypes._Pointer[c_float]:
    return array.ctypes.data_as(POINTER(c_float))


def _uints(array: np.ndarray) -> ctypes._Pointer[c_uint]:
    return array.ctypes.data_as(POINTER(c_uint))
