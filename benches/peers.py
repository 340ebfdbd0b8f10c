"""The casters that `compare.py` times, each in a process of its own: `PEERS[name](threads)`.

"analytic" is ours with shapes kept as they are, "triangles" with everything as triangles, "fresh" as "analytic" with
new arrays for each scan. The others cast all bodies as one mesh: "open3d" (Embree with threads), "embreex" (Embree one
ray at a time, one thread), and "packets": Embree driven the fastest way it offers, in packets of coherent rays, by
`embree_packets.c`, which is compiled with the system's C compiler and linked to the Embree 4 that the embreex package
ships, or else that the system has. One call for all rays is timed; making the rays, or images from the hits, is not.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import importlib.util
import os
import shutil
import subprocess
import time
from collections.abc import Callable
from ctypes import POINTER, c_char_p, c_float, c_int, c_int32, c_size_t, c_uint, c_void_p
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import scenes
from lidardraft import CLASSES, Layout, Primitive, RangeImageBatch, Raycaster, Sensor, _core
from scenes import MAX_RANGE, Body, Pattern, Scene

_SHAPES = {"cuboid": "box", "ellipsoid": "ellipsoid", "plane": "plane"}


def layout_of(scene: Scene, *, triangles: bool) -> Layout:
    """The scene's primitives, in their order, as a layout; meshes, or all if `triangles`, with exactly its vertices."""
    return Layout(tuple(_primitive(k, body, triangles) for k, body in enumerate(scene.primitives)))


def _primitive(index: int, body: Body, triangles: bool) -> Primitive:
    label = CLASSES[body.semantic].name
    if triangles or body.kind == "mesh":
        return Primitive.from_mesh(body.verts, body.faces, label=label, id=str(index), instance=body.instance)
    (x, y, z), (length, width, height) = body.center, body.half
    return Primitive(
        shape=_SHAPES[body.kind],
        center=(float(x), float(y), float(z)),
        size=(2.0 * length, 2.0 * width, 2.0 * height),
        yaw=float(body.yaw),
        label=label,
        id=str(index),
        instance=body.instance,
    )


def sensor_of(pattern: Pattern) -> Sensor:
    """The sensor whose rays are those of the pattern; any distance up to 120 m counts."""
    azimuth = np.asarray(pattern.azimuth)
    step = (azimuth[0] - azimuth[-1]) / (len(azimuth) - 1)
    start, span = float(azimuth[0] + step / 2), float(step * len(azimuth))
    assert np.allclose(azimuth, start - (np.arange(len(azimuth)) + 0.5) * span / len(azimuth), rtol=0, atol=1e-12)
    return Sensor(
        name="bench",
        elevations=tuple(np.asarray(pattern.elevation).tolist()),
        columns=len(azimuth),
        azimuth_start=start,
        azimuth_span=min(span, 2 * np.pi),
        min_range=0.0,
        max_range=120.0,
    )


class LidarDraft:
    """Build, cast and scan, as the benchmarks time them.

    `cast` is the core alone, into buffers that stay; `scan` is `Raycaster.scan` with `out=`, or with new arrays each
    time where the peer is `fresh`. A scan is asked for one image more than it needs, the index of the primitive: unlike
    `instance` it is -1 where nothing returns, as the benchmarks want it, and equals the instance everywhere else.
    """

    version = f"lidardraft ({_core.backends()[0]})"

    def __init__(self, threads: int, *, triangles: bool, fresh: bool = False) -> None:
        self.threads, self.triangles, self.fresh = threads, triangles, fresh

    def build(self, scene: Scene) -> None:
        """Make a layout of the scene's arrays, and compile it."""
        assert all(body.instance == k for k, body in enumerate(scene.primitives)), "instance k must be primitive k"
        self.layout = layout_of(scene, triangles=self.triangles)
        self.caster = Raycaster(self.layout)

    def compile(self, _scene: Scene) -> None:
        """Compile the layout that is there."""
        self.caster = Raycaster(self.layout)

    def prepare(self, pattern: Pattern) -> None:
        """Make the sensor and the buffers."""
        self.sensor = sensor_of(pattern)
        self.image = self.caster.scan(self.sensor, np.eye(4), primitive=True)
        empty = RangeImageBatch.empty(self.sensor, 1)
        self.buffers: dict[str, Any] = {"depth": empty.depth, "label": empty.label, "instance": empty.instance}
        self.batch_out: Any = None

    def cast(self, pose: np.ndarray) -> dict[str, np.ndarray]:
        """Depth, label and instance [1, H, W], straight from the core."""
        self.caster._scene.scan(self.sensor.pattern, pose[None, None], **self.buffers, threads=self.threads)
        return self.buffers

    def scan(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W], end to end."""
        out = None if self.fresh else self.image
        image = self.caster.scan(self.sensor, pose, out=out, primitive=True, threads=self.threads)
        assert image.primitive is not None
        return image.depth, image.label, image.primitive

    def scan_fresh(self, pose: np.ndarray) -> Any:
        """A scan into new arrays."""
        return self.caster.scan(self.sensor, pose, threads=self.threads)

    def rolling(self, poses: np.ndarray) -> Any:
        """A scan with one pose for each column [W, 4, 4], into arrays that stay."""
        return self.caster.scan(self.sensor, poses=poses, out=self.image, primitive=True, threads=self.threads)

    def batch(self, poses: np.ndarray) -> Any:
        """Scans from all poses [N, 4, 4], into arrays that stay from one call to the next of the same size."""
        self.batch_out = self.caster.scan_batch(self.sensor, poses, out=self.batch_out, threads=self.threads)
        return self.batch_out

    def reference(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """What `scan` returns, by the reference path: one ray at a time, in float64, through a tree of bounds."""
        primitive = np.zeros((1, *self.sensor.shape), np.int32)
        self.caster._scene.scan(
            self.sensor.pattern, pose[None, None], **self.buffers, primitive=primitive, backend="reference"
        )
        return self.buffers["depth"][0].copy(), self.buffers["label"][0].copy(), primitive[0]


class Open3d:
    """Open3D's RaycastingScene, as the benchmarks time it."""

    def __init__(self, threads: int) -> None:
        import open3d

        self.threads, self.open3d, self.tensor = threads, open3d, open3d.core.Tensor
        self.version = "Open3D " + open3d.__version__

    def build(self, scene: Scene) -> None:
        """Compile the mesh."""
        self.scene = scene
        self.caster = self.open3d.t.geometry.RaycastingScene(nthreads=self.threads)
        self.caster.add_triangles(self.tensor(scene.verts), self.tensor(scene.faces))
        # The hierarchy is built when the first ray is cast; this one looks up from above everything.
        self.cast_rays = self.tensor(np.array([[0, 0, 1e4, 0, 0, 1]], np.float32))
        self.cast(np.eye(4))

    def prepare(self, pattern: Pattern) -> None:
        """Keep the pattern, and rays for the bare cast."""
        self.pattern = pattern
        self.aim_cast(np.eye(4))

    def aim_cast(self, pose: np.ndarray) -> None:
        """Rays for the next casts, before the clock starts."""
        origin, directions = self.pattern.rays(pose)
        rays = np.empty((len(directions), 6), np.float32)
        rays[:, :3], rays[:, 3:] = origin, directions
        self.cast_rays = self.tensor(rays)

    def cast(self, _pose: np.ndarray) -> Any:
        """Cast the rays that `aim_cast` made; the answer stays in Open3D's form."""
        return self.caster.cast_rays(self.cast_rays, nthreads=self.threads)

    def scan(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W], end to end."""
        self.aim_cast(pose)
        answer = self.cast(pose)
        return self.scene.images(answer["t_hit"].numpy(), answer["primitive_ids"].numpy(), self.pattern.shape)


class Embreex:
    """The Embree binding that trimesh uses, as the benchmarks time it."""

    def __init__(self, threads: int) -> None:
        import embreex
        from embreex import mesh_construction, rtcore_scene

        if threads != 1:
            raise RuntimeError("embreex casts on one thread")
        self.new_mesh, self.new_scene = mesh_construction.TriangleMesh, rtcore_scene.EmbreeScene
        self.version = "embreex " + embreex.__version__

    def build(self, scene: Scene) -> None:
        """Compile the mesh."""
        self.scene, self.caster = scene, self.new_scene()
        self.mesh = self.new_mesh(self.caster, scene.verts, scene.faces.astype(np.int32))
        # The hierarchy is built when the first ray is cast; this one looks up from above everything.
        self.caster.run(np.array([[0, 0, 1e4]], np.float32), np.array([[0, 0, 1]], np.float32))

    def prepare(self, pattern: Pattern) -> None:
        """Keep the pattern, and rays for the bare cast."""
        self.pattern = pattern
        self.aim_cast(np.eye(4))

    def aim_cast(self, pose: np.ndarray) -> None:
        """Rays for the next casts, before the clock starts."""
        origin, directions = self.pattern.rays(pose)
        origins = np.ascontiguousarray(np.broadcast_to(origin, directions.shape))
        self.cast_rays = origins, np.ascontiguousarray(directions)

    def cast(self, _pose: np.ndarray) -> Any:
        """Cast the rays that `aim_cast` made; the answer stays in embreex's form."""
        return self.caster.run(*self.cast_rays, query="INTERSECT", output=True)

    def scan(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W], end to end."""
        self.aim_cast(pose)
        answer = self.cast(pose)
        return self.scene.images(answer["tfar"], answer["primID"], self.pattern.shape)


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


class Packets:
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


def _floats(array: np.ndarray) -> ctypes._Pointer[c_float]:
    return array.ctypes.data_as(POINTER(c_float))


def _uints(array: np.ndarray) -> ctypes._Pointer[c_uint]:
    return array.ctypes.data_as(POINTER(c_uint))


PEERS: dict[str, Callable[[int], Any]] = {
    "analytic": partial(LidarDraft, triangles=False),
    "triangles": partial(LidarDraft, triangles=True),
    "fresh": partial(LidarDraft, triangles=False, fresh=True),
    "open3d": Open3d,
    "embreex": Embreex,
    "packets": Packets,
}
