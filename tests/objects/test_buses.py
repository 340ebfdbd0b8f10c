"""Buses: seats behind their windows, plates at both ends."""

import numpy as np
from built_objects import build, cast, placed


def test_rays_through_the_windows_end_at_glass_or_seats_or_go_through():
    bus = build(placed("bus", 1), 0)
    rng = np.random.default_rng(0)
    at = np.column_stack([rng.uniform(-4.0, 4.0, 400), np.zeros(400), rng.uniform(1.6, 1.8, 400)])
    found = cast(bus, (0.0, 40.0, 1.7), at)
    materials = [bus[index].material if index >= 0 else "nothing" for index in found]
    assert materials.count("car-glass") > 200
    assert materials.count("dark-cloth") > 3
    assert {p.label for p in bus} == {"bus"}


def test_number_plates_are_at_both_ends():
    made = placed("bus")
    ends = sorted(p.center[0] for p in build(made, 0) if p.material == "retroreflector")
    assert ends == [-made.size[0] / 2, made.size[0] / 2]
