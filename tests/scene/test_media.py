"""Media: porous shapes in a layout, and what a sensor sees of them. The core's own tests have the closed forms."""

import dataclasses
import json
import math

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Raycaster, Sensor, raycast
from lidardraft.errors import FormatError, LayoutError, LidarDraftError
from lidardraft.scene import edit
from lidardraft.scene.layout import SHAPES, primitive_mesh
from lidardraft.scene.mesh import TriangleMesh

SENSOR = Sensor(name="test", elevations=tuple(np.deg2rad(np.linspace(8, -12, 24)).tolist()), columns=600)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")
CROWN = Primitive(
    shape="ellipsoid", center=(9, 1, 2), size=(6, 5, 4), label="vegetation", id="tree_1.crown", extinction=0.6
)
STREET = Layout(
    primitives=(
        ROAD,
        CROWN,
        dataclasses.replace(CROWN, shape="box", center=(-8, 0, 1), size=(3, 20, 2), id="hedge"),
        dataclasses.replace(CROWN, shape="cylinder", center=(0, 9, 2), size=(4, 4, 4), id="bush", extinction=3),
        Primitive(shape="box", center=(30, 0, 3), size=(1, 60, 6), label="building", id="house"),
    )
)


def unit(shape: str) -> TriangleMesh:
    return primitive_mesh(
        Primitive(shape=shape, center=(0, 0, 0), size=(1, 1, float(shape != "plane")), label="road", id="x")
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_what_can_be_a_medium(shape):
    fields = {"shape": shape, "mesh": unit("ellipsoid") if shape == "mesh" else None, "extinction": 2}
    if shape == "plane":
        with pytest.raises(LayoutError, match=r"a plane has no inside; it cannot have the extinction 2\.0"):
            dataclasses.replace(ROAD, **fields)
    else:
        assert dataclasses.replace(CROWN, **fields).extinction == 2.0


def test_an_open_mesh_is_no_medium():
    whole = unit("box")
    turned = whole.faces.copy()
    turned[0] = turned[0, ::-1]
    for faces in (whole.faces[1:], turned, np.concatenate([whole.faces, whole.faces[:1]])):
        mesh = TriangleMesh(whole.vertices, faces)
        assert not mesh.is_closed()
        with pytest.raises(LayoutError, match="it: the mesh is not closed; it cannot have the extinction"):
            Primitive(shape="mesh", center=(0, 0, 0), size=(1, 1, 1), label="fence", id="it", mesh=mesh, extinction=1)
    assert all(unit(shape).is_closed() for shape in ("box", "ellipsoid", "cylinder"))
    assert not unit("plane").is_closed()


@pytest.mark.parametrize("value", [0, -1, math.inf, math.nan, "dense", True, [1.0]])
def test_extinctions_that_cannot_be(value):
    with pytest.raises(LayoutError, match=r"tree_1\.crown: extinction is .*; it must be a finite number > 0"):
        dataclasses.replace(CROWN, extinction=value)


def test_json_and_edits_keep_it():
    again = Layout.from_json(STREET.to_json())
    assert again == STREET
    assert again["bush"].extinction == 3.0
    rows = json.loads(STREET.to_json())["primitives"]
    assert [row.get("extinction") for row in rows] == [None, 0.6, 0.6, 3.0, None]
    assert "extinction" not in rows[0]
    moved = edit.move(STREET, "tree_1", (1, 2, 0), turn=0.5)
    assert moved["tree_1.crown"].extinction == 0.6
    solid = edit.replace(STREET, "tree_1", extinction=None)
    assert solid["tree_1.crown"].extinction is None
    assert solid != STREET
    with pytest.raises(FormatError, match="unknown field 'extinctions'"):
        Primitive.from_dict({**CROWN.to_dict(), "extinctions": 1})


def test_seeds():
    caster = Raycaster(STREET)
    one, same, other = (caster.scan(SENSOR, seed=seed, primitive=True) for seed in (7, 7, 8))
    np.testing.assert_array_equal(one.depth, same.depth)
    medium = (one.primitive == 1) & (other.primitive == 1)
    assert (one.depth[medium] != other.depth[medium]).mean() > 0.99
    house = (one.primitive == 4) & (other.primitive == 4)
    np.testing.assert_array_equal(one.depth[house], other.depth[house])
    sweep = np.tile(SENSOR.pose(), (SENSOR.columns, 1, 1))
    np.testing.assert_allclose(caster.scan(SENSOR, poses=sweep, seed=7).depth, one.depth, atol=5e-3)
    with pytest.raises(LidarDraftError, match="seed is -1; it must be an integer of 0 to 2"):
        caster.scan(SENSOR, seed=-1)
    for call in (lambda: caster.scan(SENSOR, seed=2**63), lambda: caster.cast(np.zeros(3), np.eye(3), seed=2**63)):
        with pytest.raises(LidarDraftError, match="seed is 9223372036854775808; it must be an integer of 0 to 2"):
            call()


def test_any_rays():
    caster = Raycaster(Layout(primitives=(dataclasses.replace(CROWN, shape="box", center=(0, 0, 0), size=(4, 4, 4)),)))
    origins, directions = np.tile([-5.0, 0.3, 0.2], (20_000, 1)), np.tile([3.0, 0.0, 0.0], (20_000, 1))
    hits = caster.cast(origins, directions, seed=1)
    passed = (hits.primitive < 0).mean()
    assert abs(passed - math.exp(-0.6 * 4)) < 4 * math.sqrt(passed * (1 - passed) / 20_000)
    met = hits.primitive == 0
    assert ((hits.distance[met] > 3) & (hits.distance[met] < 7)).all()
    np.testing.assert_array_equal(hits.normal[met], np.tile([-1.0, 0.0, 0.0], (met.sum(), 1)))
    again = caster.cast(origins, directions, seed=1, threads=2)
    np.testing.assert_array_equal(hits.distance, again.distance)
    assert (caster.cast(origins, directions, seed=2).distance != hits.distance).any()


def test_by_id_the_rays_in_a_medium_go_as_far_when_others_come_and_go() -> None:
    fewer = edit.remove(STREET, "hedge")
    before, after = (Raycaster(each, by_id=True).scan(SENSOR, primitive=True) for each in (STREET, fewer))
    kept = np.flatnonzero([p.id != "hedge" for p in STREET])
    same = (before.depth == after.depth) & (kept[after.primitive] == before.primitive)
    hedge = before.primitive == [p.id for p in STREET].index("hedge")
    assert same[~hedge & before.valid].all()
    by_number = [raycast(each, SENSOR).depth for each in (STREET, fewer)]
    assert (by_number[0] != by_number[1])[~hedge].mean() > 0.01
