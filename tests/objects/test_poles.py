"""Lamps, poles, bollards and traffic lights."""

import pytest
from built_objects import build, placed

from lidardraft.objects.poles import LAMP_ARM


def test_the_arm_of_a_lamp_is_on_its_left_and_no_longer_than_its_room():
    for seed in range(40):
        lamp = build(placed("lamp", 1), seed)
        luminaire = next(p for p in lamp if p.material == "plastic")
        assert luminaire.center[1] > 0.5
        assert luminaire.center[1] + luminaire.size[1] / 2 <= LAMP_ARM + 1e-9


def test_low_lamps_are_lanterns_or_have_arms():
    counts = {len(build(placed("lamp", 0), seed)) for seed in range(40)}
    assert counts == {2, 3, 4}


def test_high_and_thick_poles_are_of_wood_and_bollards_reflect():
    assert build(placed("pole", 1), 0)[0].material == "wood"
    assert build(placed("pole", 0), 0)[0].material == "metal"
    bands = [len(build(placed("pole", 0), seed)) for seed in range(40)]
    assert set(bands) == {1, 2}


def test_a_wide_traffic_light_hangs_from_an_arm_and_has_another_on_its_mast():
    made = placed("traffic_light", 1)
    lights = [p for p in build(made, 0) if p.material == "plastic"]
    assert [p.center[1] for p in lights] == pytest.approx([made.size[1] / 2 - 0.2, -made.size[1] / 2 + 0.15])
    top = lights[0].center[2] + lights[0].size[2] / 2
    assert top == pytest.approx(made.size[2])
    assert len([p for p in build(placed("traffic_light", 0), 0) if p.material == "plastic"]) == 1


def test_lenses_look_forward():
    for variant in (0, 1):
        primitives = build(placed("traffic_light", variant), 0)
        housings = [p for p in primitives if p.material == "plastic"]
        lenses = [p for p in primitives if p.material == "glass"]
        for housing, lens in zip(housings, lenses, strict=True):
            assert lens.center[0] > housing.center[0]
