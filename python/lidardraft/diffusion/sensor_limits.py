"""Limits of sensors: the range of sensors that a network was trained on."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from lidardraft.scene.sensor import Sensor


@dataclass(frozen=True, kw_only=True)
class SensorLimits:
    """The least and the most of each: beams, columns of a full turn, elevations [deg], mount height [m]."""

    beams: tuple[int, int]
    columns: tuple[int, int]
    elevation: tuple[float, float]
    mount_height: tuple[float, float]

    @classmethod
    def from_sensor(cls, sensor: Sensor) -> SensorLimits:
        """The limits of one sensor alone."""
        found = _measured(sensor)
        return cls(**{name: (min(values), max(values)) for name, values in found.items()})  # type: ignore[arg-type]

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> SensorLimits:
        """The inverse of `to_dict`."""
        return cls(**{name: tuple(values) for name, values in fields.items()})

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON types."""
        return {name: list(values) for name, values in asdict(self).items()}

    def difference(self, sensor: Sensor) -> str | None:
        """A text on the properties of a sensor outside the limits, with the limits; None if all are inside."""
        for name, values in _measured(sensor).items():
            low, high = getattr(self, name)
            if min(values) < low - 1e-3 or max(values) > high + 1e-3:
                trained, has = (" to ".join(f"{v:.4g}" for v in dict.fromkeys(of)) for of in ((low, high), values))
                return f"{name.replace('_', ' ')} of {trained}, and {sensor.name} has {has}"
        return None


def _measured(sensor: Sensor) -> dict[str, list[float]]:
    columns = round(sensor.columns * 2 * math.pi / sensor.azimuth_span)
    return {
        "beams": [len(sensor.elevations)],
        "columns": [columns],
        "elevation": [math.degrees(min(sensor.elevations)), math.degrees(max(sensor.elevations))],
        "mount_height": [sensor.mount_height],
    }
