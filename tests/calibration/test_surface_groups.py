"""What is alike: by class, or by place and shape."""

import numpy as np
import pytest
from recorded_streets import SENSOR

from lidardraft import Layout, Primitive, raycast
from lidardraft.calibration.surface_groups import GROUND, LANE, LOW, ROUGH, SMOOTH, groups_of
from lidardraft.metrics.sweep import Sweep
from lidardraft.semantics import BY_NAME


def box(id: str, label: str, center: tuple[float, float, float], size: tuple[float, float, float], **fields: float):
    return Primitive(shape="box", id=id, label=label, center=center, size=size, **fields)


@pytest.fixture(scope="module")
def sweep() -> Sweep:
    road = Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road")
    front = box("front", "building", (0.0, 25.0, 10.0), (300.0, 1.0, 20.0))
    hedge = box("hedge", "vegetation", (0.0, -25.0, 10.0), (300.0, 8.0, 20.0), extinction=0.5)
    car = box("car", "car", (10.0, 5.0, 0.9), (4.0, 1.8, 1.2))
    return Sweep.from_image(raycast(Layout((road, front, hedge, car)), SENSOR))


def test_place_and_shape_say_what_a_return_is_of(sweep):
    group, height = groups_of(sweep, labelled=False), sweep.points[..., 2] + SENSOR.mount_height
    is_of = {name: sweep.label == BY_NAME[name].id for name in ("road", "building", "vegetation", "car")}
    assert set(np.unique(group[is_of["road"]])) == {LANE, GROUND}
    assert (np.abs(sweep.points[..., 1][group == LANE]) < 2.0).all()
    assert (group[is_of["car"] & (height > 0.6)] == LOW).all()
    high = height > 2.6
    assert (group[is_of["building"] & high] == SMOOTH).mean() > 0.6  # at a slant rows bend
    assert (group[is_of["vegetation"] & high] == ROUGH).mean() > 0.9


def test_labels_say_it_where_there_are_some(sweep):
    group = groups_of(sweep, labelled=True)
    per_class = [np.unique(group[sweep.label == BY_NAME[name].id]) for name in ("road", "building", "car")]
    assert [len(found) for found in per_class] == [1, 1, 1]
    assert len(np.unique(per_class)) == 3
