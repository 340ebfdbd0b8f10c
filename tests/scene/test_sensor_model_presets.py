"""What presets say that other tests do not ask: the HDL-64E's readings."""

import numpy as np
import pytest

from lidardraft.scene.sensor_model_presets import MODELS


def test_the_hdl64e_reads_roads_at_a_quarter():
    curve = MODELS["hdl64e"].intensity_curve
    assert curve is not None
    (readings,) = curve.readings
    assert np.interp(np.log(0.1), np.log(curve.responses), readings) == pytest.approx(0.26, abs=0.002)
    assert max(readings) == 1.0
