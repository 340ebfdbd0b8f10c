"""A street as a picture shows it."""

import math

import numpy as np
import pytest
from scanned import NAMES, OBJECTS, VISIBLE, ids, labels, made

from lidardraft.errors import LayoutError
from lidardraft.objects.kinds import kind_of
from lidardraft.streets.coarse.as_picture import PictureStyle


def test_a_picture_shows_what_is_ahead_and_seen():
    table = made(PictureStyle(reach=40.0, view=1.5))
    objects = table.select(~np.isin(table.labels, [NAMES.index(name) for name in ("road", "sidewalk", "terrain")]))
    assert len(objects)
    middle = {placed.id: (placed.x, placed.y) for placed in OBJECTS}
    for id in {id.partition(".")[0] for id in objects.ids}:
        ahead = np.array(middle[id]) - VISIBLE.place[:2]
        assert np.hypot(*ahead) <= 40.0
        assert abs(math.remainder(math.atan2(ahead[1], ahead[0]) - VISIBLE.place[2], math.tau)) <= 0.75 + 1e-6
        assert VISIBLE.returns[[placed.id for placed in OBJECTS].index(id)].sum() >= 5


def test_a_picture_misjudges_a_little():
    exact, wrong = (made(PictureStyle(error=error, turn=error)) for error in (0.0, 0.02))
    assert exact.ids == wrong.ids
    off = np.hypot(*(exact.centers - wrong.centers)[:, :2].T)
    share = off / np.maximum(np.hypot(*exact.centers[:, :2].T), 5.0)
    assert 0.003 < np.median(share) < 0.03
    assert 0.003 < np.median(np.abs(exact.yaws - wrong.yaws)) < 0.04


def test_small_objects_sidewalks_and_poles_may_be_left_out():
    small = {placed.id for placed in OBJECTS if kind_of(placed.kind).is_small} & ids(made(PictureStyle()))
    assert small
    assert not small & ids(made(PictureStyle(omit=1.0)))
    assert "sidewalk" in labels(made(PictureStyle(relief=True)))
    assert "sidewalk" not in labels(made(PictureStyle(relief=True, sidewalks=False)))
    poles = {placed.id for placed in OBJECTS if placed.kind in ("lamp", "sign", "pole")}
    assert poles & ids(made(PictureStyle()))
    assert not poles & ids(made(PictureStyle(poles=False)))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"omit": 1.5}, "omit is 1.5; it must be 0 to 1"),
        ({"lobes": 4}, "lobes is 4; it must be 1 to 3"),
        ({"error": float("nan")}, "error is nan"),
        ({"view": 7.0}, "view is 7.0; it must be 0.1 to 6.28319"),
    ],
)
def test_values_out_of_their_limits(fields: dict, message: str):
    with pytest.raises(LayoutError, match=message):
        PictureStyle(**fields)


def test_a_picture_covers_its_view():
    assert PictureStyle().coverage is None
    assert PictureStyle(view=1.5).coverage == (-0.75, 0.75)
