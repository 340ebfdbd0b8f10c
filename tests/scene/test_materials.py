"""Materials against closed forms."""

import math

import numpy as np
import pytest

from lidardraft.scene.materials import (
    CLASS_MATERIALS,
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
from lidardraft.semantics import NUM_CLASSES

NAMES = [
    *("asphalt", "concrete", "paving", "gravel", "plaster", "brick", "stone", "roof-tile", "wood", "metal"),
    *("rusty-metal", "chrome", "foliage", "bark", "grass", "soil", "cloth", "dark-cloth", "skin", "light-paint"),
    *(
        "mid-paint",
        "dark-paint",
        "rubber",
        "plastic",
        "glass",
        "car-glass",
        "window",
        "retroreflector",
        "road-paint",
        "sign-back",
    ),
]
FACING = np.ones(1)
COSINES = np.cos(np.linspace(0, math.pi / 2, 50))


def test_every_name_is_there_once_and_every_class_has_a_material():
    assert [material.name for material in MATERIALS] == NAMES
    assert len(CLASS_MATERIALS) == NUM_CLASSES


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
