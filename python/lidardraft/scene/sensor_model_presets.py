"""The constants of each known sensor, with their sources."""

from __future__ import annotations

import math
from typing import Any

from lidardraft.scene.intensity_curve import IntensityCurve
from lidardraft.scene.sensor_model import SensorModel

_FWHM = math.sqrt(2.0 / math.log(2.0))  # of a Gaussian: full width at 1 / e^2 over full width at half maximum

# Velodyne's calibrated reflectivity (HDL-32E, VLP-16, VLP-32C manuals): 0 to 100 is per cent of a diffuse surface, 101
# to 255 are retroreflectors. Ouster's (firmware user manual) is alike.
_REFLECTIVITY: dict[str, Any] = {"full_scale": 300.0, "knee": 100.0 / 255.0}


def _ouster(degrees: float, reach: float, jitter: float) -> SensorModel:
    """Ouster's data sheets: 865 nm, a beam of `degrees` at half maximum, a range of `reach` [m] at 0.10.

    `jitter` [m] is such that their samples come out (benches/fit_sensor.py).
    """
    width = math.radians(degrees) * _FWHM
    return SensorModel(
        divergence_h=width,
        divergence_v=width,
        detection_threshold=0.10 / reach**2,
        range_step=0.001,
        offset_spread=0.003,
        edge_drop=0.0,  # their samples lose no more at edges than streets do without
        tilt_spread=0.0,  # each unit's own table comes with it
        jitter=jitter,
        **_REFLECTIVITY,
    )


_ROOT_KNOTS = tuple(10.0 ** (k / 3.0) for k in range(-12, 4))  # of responses
# HDL-64E S2 manual: 905 nm, 5 ns, 2 cm; pavement of 0.10 is seen to 50 m, from a roof: at 2 degrees, where it sends
# back two thirds and its echo is stretched over three sub-rays. Of the 2 cm, a part is noise (`Sensor`); the rest stays
# in a laser, as the 1 to 3 cm of Glennie and Lichti (Remote Sensing 2, 2010), who have the divergence too. Its units of
# 2 mm disappear in a correction that differs along the range. Its intensity is corrected by a focal distance and slope
# for each laser, of 3 to 20 m in published calibrations (ros-drivers/velodyne), so not beyond some tens of metres;
# KITTI stores hundredths. Lasers set their own power (manual), so readings are compressed. By how much is not
# published: that they grow with the root of the response, and that roads read 0.26, was set near what is known of
# KITTI. In one calibration (64e_s2.1-sztaki, BSD) the least readings of the lasers are 0 to 90 of 255, 25 on average
# and 22 apart; and the corrections for focus are 8 to 13 apart at 8 to 15 m: of a road's reading of 66, 0.12 to 0.20,
# and of the response under the root 0.25 to 0.39, which is the spread of the gains.
_ROOT = IntensityCurve(
    responses=_ROOT_KNOTS, readings=(tuple(min(0.26 * math.sqrt(r / 0.1), 1.0) for r in _ROOT_KNOTS),)
)
_HDL64E = SensorModel(
    divergence_h=2.0e-3,
    divergence_v=2.0e-3,
    detection_threshold=0.10 * 0.67 / 3 / 50.0**2,
    range_step=0.0,
    offset_spread=0.018,
    gain_spread=0.3,
    intensity_curve=_ROOT,
    cutoff=25.0 / 255.0,
    cutoff_spread=22.0 / 255.0,
    levels=100,
    compensation_range=40.0,
)

MODELS: dict[str, SensorModel] = {
    "hdl64e": _HDL64E,
    "hdl64e-linear": _HDL64E,
    # Manuals: 3.0 by 1.5 mrad; 100 m, and 200 m of the VLP-32C, without a reflectance. ika's VLP-32C drops rays to the
    # ground as if that were 0.10 (benches/fit_sensor.py), so it is taken for all three; and 0.022 of them at any range,
    # some perhaps by the projection.
    "hdl32e": SensorModel(detection_threshold=0.10 / 100.0**2, **_REFLECTIVITY),
    "vlp16": SensorModel(detection_threshold=0.10 / 100.0**2, **_REFLECTIVITY),
    "vlp32c": SensorModel(
        detection_threshold=0.10 / 200.0**2,
        drop_exponent=0.022,
        jitter=0.04,
        range_step=0.004,
        tilt_spread=2.6e-3,
        **_REFLECTIVITY,
    ),
    # Pandar64 manual: 905 nm, 2 cm, 200 m at 0.10. Divergence: an estimate after sensors of its kind. Scale and noise
    # are fitted to PandaSet by benches/fit_sensor.py.
    "pandar64": SensorModel(
        detection_threshold=0.10 / 200.0**2,
        offset_spread=0.007,
        range_step=0.004,
        tilt_spread=1.8e-3,
        full_scale=255.0 / 66.0,
    ),
    "os0-128": _ouster(0.35, 20.0, 0.03),
    "os1-128": _ouster(0.18, 40.0, 0.035),
    "os1-32": _ouster(0.18, 40.0, 0.035),
    "os2-128": _ouster(0.09, 90.0, 0.035),
}
