"""Any rays at the border of the compiled core."""

import math
from typing import Any

import numpy as np
import pytest

from lidardraft import _core
from lidardraft.errors import LayoutError, LidarDraftError

BALL = _core.Scene(
    shapes=np.array([1], np.uint8),
    centers=np.array([[10.0, 0.0, 0.0]]),
    sizes=np.array([[2.0, 2.0, 2.0]]),
    yaws=np.zeros(1),
    labels=np.array([13], np.uint8),
    instances=np.array([4], np.uint32),
    meshes=[],
)


def test_rays_of_any_length_are_cast() -> None:
    origins = np.array([[0.0, 0, 0], [0, 0, 0], [10, 0, 5], [10, 0, 0]])
    directions = np.array([[0.1, 0, 0], [0, 1, 0], [0, 0, -30], [1, 0, 0]])
    distance, label, instance, primitive, normal = BALL.cast(origins, directions)
    np.testing.assert_allclose(distance, [9, 0, 4, 1], rtol=1e-6)
    assert (label.tolist(), instance.tolist(), primitive.tolist()) == ([13, 0, 13, 13], [4, 0, 4, 4], [0, -1, 0, 0])
    np.testing.assert_allclose(normal, [[-1, 0, 0], [0, 0, 0], [0, 0, 1], [-1, 0, 0]], atol=1e-6)
    near = BALL.cast(origins, directions, max_range=4.5)[0]
    np.testing.assert_array_equal(near > 0, [False, False, True, True])
    dtypes = [array.dtype for array in (distance, label, instance, primitive, normal)]
    assert dtypes == [np.float32, np.uint8, np.uint32, np.int32, np.float32]


RAYS = np.ones((3, 3))


@pytest.mark.parametrize(
    ("origins", "directions", "options", "error", "said"),
    [
        (RAYS, RAYS[:2], {}, LayoutError, "there are 3 origins and 2 directions"),
        (RAYS * [[1], [1], [np.nan]], RAYS, {}, LayoutError, r"origins\[2\] is \[NaN, NaN, NaN\] m"),
        (RAYS * [[1], [1e10], [1]], RAYS, {}, LayoutError, r"origins\[1\] is .* at most 1e9"),
        (
            RAYS,
            RAYS * [[1], [np.inf], [1]],
            {},
            LayoutError,
            r"directions\[1\] is \[inf, inf, inf\]; it must be finite",
        ),
        (RAYS, RAYS * [[0], [1], [1]], {}, LayoutError, r"directions\[0\] is \[0.0, 0.0, 0.0\]; .* not 0"),
        (RAYS, RAYS, {"max_range": 0.0}, LayoutError, "max_range is 0 m; it must be greater than 0"),
        (RAYS, RAYS, {"max_range": math.nan}, LayoutError, "max_range is NaN m"),
        (RAYS, RAYS, {"threads": -2}, LidarDraftError, "threads is -2"),
        (RAYS[:, :2].copy(), RAYS, {}, LayoutError, r"origins has the shape \[3, 2\]; it must be \[R, 3\]"),
        (RAYS.astype(np.float32), RAYS, {}, TypeError, "origins must be .* it is float32"),
        (RAYS, np.asfortranarray(RAYS), {}, TypeError, "directions must be .* a strided view"),
    ],
)
def test_rays_that_cannot_be(
    origins: np.ndarray, directions: np.ndarray, options: dict[str, Any], error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said):
        BALL.cast(origins, directions, **options)
