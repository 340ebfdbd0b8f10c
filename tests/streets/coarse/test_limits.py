"""Limits of the numbers in styles."""

import pytest

from lidardraft.errors import LayoutError
from lidardraft.streets.coarse.as_picture import PictureStyle
from lidardraft.streets.coarse.limits import check_limits


def test_limits_belong_to_what_is_allowed_and_nan_does_not():
    style = PictureStyle(reach=40.0)
    check_limits(style, reach=(40.0, 40.0))
    with pytest.raises(LayoutError, match=r"reach is 40\.0; it must be 0 to 39\.5"):
        check_limits(style, reach=(0.0, 39.5))
    with pytest.raises(LayoutError, match="turn is nan"):
        PictureStyle(turn=float("nan"))
