"""The surfaces of a layout as columns, against the materials they are made of."""

from dataclasses import replace

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene import edit
from lidardraft.scene.effects import observe
from lidardraft.scene.materials import MATERIAL_BY_NAME, response
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces


def boxes(*materials: str | None, label: str = "building") -> Layout:
    return Layout(
        primitives=tuple(
            Primitive(shape="box", center=(5.0, 3.0 * i, 1.0), size=(1, 1, 2), label=label, id=f"b_{i}", material=name)
            for i, name in enumerate(materials)
        )
    )


def test_surfaces_hold_the_response_of_each_primitive_and_0_for_none():
    layout = boxes("plaster", "glass", None)
    surfaces = Surfaces.from_layout(layout, variation=False)
    image = raycast(layout, Sensor(name="s", elevations=(0.0,), columns=720), primitive=True, incidence=True)
    assert image.primitive is not None
    assert image.incidence is not None
    # with every effect off the intensity is the response
    back = 300.0 * observe(image, surfaces, seed=0, model=replace(SensorModel.ideal(), full_scale=300.0)).intensity
    assert (back[~image.valid] == 0).all()
    for i, name in enumerate(("plaster", "glass", "plaster")):
        met = image.primitive == i
        expected = response(MATERIAL_BY_NAME[name], image.incidence[met].astype(np.float64))
        # within a bin of the table
        np.testing.assert_allclose(back[met], expected, rtol=0.06)
    assert surfaces.transmission.tolist() == pytest.approx([0, 0, 0.75, 0])


def test_primitives_of_one_material_differ_by_where_they_stand():
    one, two = (Surfaces.from_layout(boxes("plaster", "plaster", "plaster")) for _ in range(2))
    np.testing.assert_array_equal(one.table, two.table)
    factors = one.table[1:, 0] / Surfaces.from_layout(boxes("plaster"), variation=False).table[1, 0]
    assert len(set(factors.tolist())) == 3
    np.testing.assert_allclose(one.table[1], one.table[1, 0] * one.table[2] / one.table[2, 0], rtol=1e-5)


def test_by_id_a_primitive_that_is_moved_looks_as_before():
    layout = boxes("plaster", "cloth", "wood")
    moved = edit.remove(edit.move(layout, "b_1", (3.0, 1.0, 0.0)), "b_0")
    before, after = (Surfaces.from_layout(each, by_id=True).table for each in (layout, moved))
    np.testing.assert_array_equal(before[2:], after[1:])
    assert (Surfaces.from_layout(layout).table[2] != Surfaces.from_layout(moved).table[1]).any()


@pytest.mark.parametrize("by_id", [False, True])
def test_variation_is_the_spread_of_a_material(by_id: bool):
    spread = MATERIAL_BY_NAME["cloth"].variation
    factors = np.log(Surfaces.from_layout(boxes(*["cloth"] * 2000), by_id=by_id).table[1:, 0] / 0.48)
    assert factors.std() == pytest.approx(spread, rel=0.1)
    assert abs(factors.mean()) < 0.05


def test_wet_ground_is_darker_and_least_seen_at_grazing_incidence():
    dry, wet, half = (
        Surfaces.from_layout(boxes("asphalt", "plaster"), wetness=w, variation=False).table for w in (0.0, 1.0, 0.5)
    )
    share = wet[1] / dry[1]
    assert share[0] == pytest.approx(0.5 * 0.96**2, rel=0.01)
    assert share[-1] < 0.1
    np.testing.assert_allclose(half[1], (dry[1] + wet[1]) / 2, rtol=1e-5)
    np.testing.assert_array_equal(wet[2], dry[2])


def test_surfaces_that_cannot_be():
    with pytest.raises(LayoutError, match="b_0: material is 'cheese'; it must be one of asphalt, "):
        Surfaces.from_layout(boxes("cheese"))
    with pytest.raises(SensorError, match=r"wetness is 1\.5; it must be 0 to 1"):
        Surfaces.from_layout(boxes("wood"), wetness=1.5)
