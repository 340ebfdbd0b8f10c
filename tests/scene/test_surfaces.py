"""What materials, surfaces and the air make of light."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.errors import SensorError
from lidardraft.scene import edit
from lidardraft.scene.effects import observe
from lidardraft.scene.materials import (
    MATERIAL_BY_NAME,
    MATERIALS,
    Material,
    diffuse_response,
    fresnel,
    leaf_response,
    response,
    retro_response,
    specular_response,
)
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import (
    Weather,
    first_particle,
    fog_echo,
    fog_extinction,
    particles,
    rain_extinction,
    snow_extinction,
)


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


FACING = np.ones(1)
COSINES = np.cos(np.linspace(0, math.pi / 2, 50))


@pytest.mark.parametrize("material", MATERIALS, ids=lambda material: material.name)
def test_no_material_sends_back_more_diffuse_light_than_it_gets(material: Material):
    assert 0 < material.reflectance + material.specular + material.transmission <= 1.0
    diffuse = diffuse_response(material, COSINES)
    assert (diffuse >= 0).all()
    # rough surfaces send a little more towards the light than Lambert says
    assert (diffuse <= material.reflectance * 1.2).all()
    assert (response(material, COSINES) >= diffuse).all()


def test_a_facing_white_surface_responds_with_its_reflectance():
    assert diffuse_response(Material("matt", 0.4), FACING) == pytest.approx(0.4)


def test_a_smooth_matt_surface_is_lamberts():
    np.testing.assert_allclose(response(Material("matt", 0.4, roughness=0.0), COSINES), 0.4 * COSINES, atol=1e-12)


def test_a_grazed_rough_surface_still_responds():
    # B / A of Oren and Nayar at a slope spread of 0.4 rad
    expected = (0.45 * 0.16 / 0.25) / (1 - 0.5 * 0.16 / 0.49)
    assert diffuse_response(Material("matt", 1.0, roughness=0.4), np.zeros(1)) == pytest.approx(expected)


def test_a_clear_coat_takes_fresnels_share_twice():
    bare, coated = Material("bare", 0.4), Material("coated", 0.4, specular=0.04)
    expected = ((1 - fresnel(COSINES)) / 0.96) ** 2
    np.testing.assert_allclose(diffuse_response(coated, COSINES), diffuse_response(bare, COSINES) * expected)


def test_a_mirror_shines_only_at_what_it_faces():
    glossy = Material("glossy", 0.0, specular=0.04, rms_slope=0.1)
    # F / (4 m^2) where the facets stand flat
    assert specular_response(glossy, FACING) == pytest.approx(1.0)
    assert specular_response(glossy, np.array([math.cos(0.4)])) < 1e-5
    assert specular_response(Material("matt", 0.4), FACING) == 0.0


def test_a_retroreflector_has_the_classes_of_en_12899():
    sheeting = MATERIAL_BY_NAME["retroreflector"]
    for degrees, coefficient in ((5, 250), (30, 150), (40, 110)):
        sent = retro_response(sheeting, np.array([math.cos(math.radians(degrees))])) / math.pi
        assert sent == pytest.approx(coefficient, rel=0.06)


def test_leaves_send_back_two_thirds_of_their_reflectance():
    assert leaf_response(MATERIAL_BY_NAME["foliage"]) == pytest.approx(1 / 3)


def test_koschmieder_at_550_nm_and_in_thick_fog_at_any_wavelength():
    # at the visibility 2 per cent of the contrast is left; below 500 m the wavelength does not matter (Kim)
    for visibility in (50.0, 200.0, 500.0):
        assert math.exp(-fog_extinction(visibility) * visibility) == pytest.approx(0.02, rel=0.01)
    # Kruse: 3.91 / V (905 / 550)^-1.3 in clear air of 20 km
    assert fog_extinction(20_000.0) == pytest.approx(3.91 / 20_000 * (905 / 550) ** -1.3)
    assert fog_extinction(math.inf) == 0.0


def test_rain_and_snow_as_itu_p_1814_has_them():
    decibels = 10 / math.log(10) * 1000
    assert rain_extinction(10.0) * decibels == pytest.approx(1.076 * 10**0.67)
    assert snow_extinction(2.0) * decibels == pytest.approx((1.023e-4 * 905 + 3.7855) * 2**0.72)
    assert rain_extinction(0.0) == snow_extinction(0.0) == Weather().extinction == 0.0


def test_extinctions_add_up():
    weather = Weather(rain=5.0, snow=1.0, visibility=300.0)
    assert weather.extinction == pytest.approx(fog_extinction(300.0) + rain_extinction(5.0) + snow_extinction(1.0))


def test_marshall_and_palmer_count_the_drops():
    # the integral of 8000 exp(-4.1 R^-0.21 D) per m3 and mm over half a millimetre and more
    slope = 4.1 * 10.0**-0.21
    density, least, larger, _ = particles(Weather(rain=10.0))
    assert density == pytest.approx(8000 / slope * math.exp(-slope * 0.5))
    assert least == 0.5e-3
    assert larger == pytest.approx(1e-3 / slope)
    assert particles(Weather()) == (0.0, 0.0, 0.0, 0.0)


def test_the_first_drop_is_met_as_often_as_the_beam_has_room_for_drops():
    weather = Weather(snow=1.0)
    met, _ = first_particle(weather, (3e-3, 1.5e-3), (40_000,), np.random.default_rng(0))
    steps = np.linspace(0.95, 10.0, 20_001)
    volume = np.trapezoid(math.pi / 4 * (0.011 + 3e-3 * steps) * (0.011 + 1.5e-3 * steps), steps)
    share = ((met > 0) & (met < 10.0)).mean()
    assert share == pytest.approx(1 - math.exp(-particles(weather)[0] * volume), rel=0.03)


def test_no_drop_without_rain_and_no_fog_in_clear_air():
    rng = np.random.default_rng(0)
    for depth, echo in (
        first_particle(Weather(), (3e-3, 1e-3), (100,), rng),
        fog_echo(Weather(), 0.75, (100,), rng),
    ):
        assert not echo.any()
        assert not depth.any()


def test_fog_sends_light_back_from_near_the_sensor_and_more_so_the_thicker_it_is():
    thick, thin = (fog_echo(Weather(visibility=v), 0.75, (1000,), np.random.default_rng(0)) for v in (50.0, 200.0))
    assert thick[1][0] == pytest.approx(math.pi * 0.046 / 50 * 0.75)
    assert thick[1][0] == pytest.approx(4 * thin[1][0])
    assert 0.95 <= thick[0].min() <= thick[0].max() <= 9.5 + 1e-5
    assert np.median(thick[0]) < 2.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"rain": "a"}, r"rain is 'a'; it must be 0 to 200"),
        ({"snow": None}, r"snow is None; it must be 0 to 200"),
        ({"wetness": True}, r"wetness is True; it must be 0 to 1"),
        ({"visibility": [100.0]}, r"visibility is \[100\.0\]; it must be 0 to inf"),
        ({"rain": -1.0}, r"rain is -1\.0; it must be 0 to 200"),
        ({"snow": math.nan}, "snow is nan; it must be 0 to 200"),
        ({"visibility": 0.0}, r"visibility is 0\.0; it must be more than 0"),
        ({"wetness": 2.0}, r"wetness is 2\.0; it must be 0 to 1"),
    ],
)
def test_weather_that_cannot_be(wrong, message):
    with pytest.raises(SensorError, match=message):
        Weather(**wrong)
