"""Random layouts and poses for hypothesis, which favours round numbers: flush faces, rays along edges, the seam."""

import numpy as np
from hypothesis import strategies as st

from lidardraft.scene.layout import SHAPES, Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.pose import rotations
from lidardraft.scene.sensor import Sensor

LABELS = ("road", "building", "car", "vegetation", "pole", "person")
LENGTHS = st.floats(0.0625, 12.0, width=32)
ANGLES = st.floats(-4.0, 4.0, width=32)


@st.composite
def meshes(draw: st.DrawFn) -> TriangleMesh:
    """A soup of 1 to 24 triangles in the unit box that share vertices, slivers among them."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    vertices = random.uniform(-0.5, 0.5, (draw(st.integers(3, 16)), 3))
    faces = [random.choice(len(vertices), 3, replace=False) for _ in range(draw(st.integers(1, 24)))]
    return TriangleMesh(vertices, np.array(faces))


@st.composite
def primitives(draw: st.DrawFn, number: int) -> Primitive:
    """Any shape within 20 m of the origin, from 6 cm to 12 m in size."""
    shape = draw(st.sampled_from(SHAPES))
    x, y, z = draw(LENGTHS), draw(LENGTHS), draw(LENGTHS)
    return Primitive(
        shape=shape,
        center=tuple(draw(st.floats(-20.0, 20.0, width=32)) for _ in range(3)),
        size=(x, y, 0.0 if shape == "plane" else z),
        yaw=draw(ANGLES),
        label=draw(st.sampled_from(LABELS)),
        id=f"{shape}_{number}",
        instance=number,
        mesh=draw(meshes()) if shape == "mesh" else None,
    )


@st.composite
def layouts(draw: st.DrawFn) -> Layout:
    """Up to nine primitives, each with an instance of its own, overlapping as it comes."""
    return Layout(tuple(draw(primitives(number)) for number in range(1, 1 + draw(st.integers(0, 9)))))


@st.composite
def poses(draw: st.DrawFn) -> np.ndarray:
    """world_from_sensor [4, 4], anywhere within 12 m of the origin and turned any way."""
    pose = np.eye(4)
    pose[:3, :3] = rotations(np.array([[draw(ANGLES) for _ in range(3)]]))[0]
    pose[:3, 3] = [draw(st.floats(-12.0, 12.0, width=32)) for _ in range(3)]
    return pose


@st.composite
def sensors(draw: st.DrawFn) -> Sensor:
    """1 to 12 beams of uneven spacing by 1 to 40 columns, with or without offsets, around or ahead."""
    beams = draw(st.integers(1, 12))
    steps = [draw(st.floats(0.002, 0.1)) for _ in range(beams)]

    def table(reach: float) -> tuple[float, ...]:
        return tuple(draw(st.lists(st.floats(-reach, reach), min_size=beams, max_size=beams)))

    return Sensor(
        name="random",
        elevations=tuple(draw(st.floats(-0.3, 1.5)) - np.cumsum(steps)),
        columns=draw(st.integers(1, 40)),
        azimuth_offsets=table(0.1) if draw(st.booleans()) else (),
        origin_forwards=table(0.05) if draw(st.booleans()) else (),
        origin_lefts=table(0.05) if draw(st.booleans()) else (),
        origin_heights=table(0.2) if draw(st.booleans()) else (),
        azimuth_start=draw(st.floats(-4.0, 4.0)),
        azimuth_span=draw(st.sampled_from([2 * np.pi, 1.0, 0.2])),
        min_range=draw(st.sampled_from([0.0, 0.5])),
        max_range=draw(st.sampled_from([15.0, 120.0])),
    )
