import numpy as np
import pytest

from lidardraft.drafting.sketches.drawn_shapes import MOST_SHAPES, Blob, Sketch, SketchFrame, Stroke
from lidardraft.errors import FormatError

BLOB = Blob("car", (), "", np.zeros(2), 4.0, 2.0, 0.0)
STROKE = Stroke("wall", (), "", np.zeros((2, 2)), 0.3)


def test_up_on_the_sheet_is_ahead_and_left_is_left() -> None:
    frame = SketchFrame(np.array([50.0, 80.0]), 0.2)
    np.testing.assert_allclose(
        frame.to_layout(np.array([(50.0, 80.0), (50.0, 30.0), (40.0, 80.0)])), [(0, 0), (10, 0), (0, 2)]
    )


def test_shapes_are_put_to_their_like_and_counted() -> None:
    sketch = Sketch(0.1, False)
    sketch.add([BLOB, STROKE, BLOB])
    assert (len(sketch.blobs), len(sketch.strokes)) == (2, 1)
    with pytest.raises(FormatError, match=f"more than {MOST_SHAPES} shapes"):
        sketch.add([BLOB] * MOST_SHAPES)
