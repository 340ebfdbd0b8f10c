"""The numbers of a sensor model in JSON."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from lidardraft.errors import FormatError
from lidardraft.json_fields import check_fields, check_object, is_number
from lidardraft.scene.intensity_curve import IntensityCurve
from lidardraft.scene.sensor_model import SensorModel


def model_to_fields(model: SensorModel) -> dict[str, Any]:
    """All numbers by name; an infinite range, which JSON does not have, is null."""
    fields = dataclasses.asdict(model)
    return {name: None if value == math.inf else value for name, value in fields.items()}


def model_from_fields(value: Any) -> SensorModel:
    """The model with these numbers; what is not there has its default.

    Raises `FormatError` on a field that is unknown or no number, `SensorError` on a number that cannot be.
    """
    fields = dict(check_object(value))
    check_fields(fields, (), SensorModel.__dataclass_fields__)
    offsets = fields.pop("range_offsets", ())
    curve, reach = fields.pop("intensity_curve", None), fields.pop("compensation_range", None)
    defaults = SensorModel()
    for name, given in fields.items():
        kind = type(getattr(defaults, name))
        if not (isinstance(given, bool) if kind is bool else is_number(given)):
            needed = "true or false" if kind is bool else "a finite number"
            raise FormatError(f"{name} of the model is {given!r:.50}; it must be {needed}")
        if kind is int and given != int(given):
            raise FormatError(f"{name} of the model is {given!r}; it must be a whole number")
        fields[name] = kind(given)
    if reach is not None and not is_number(reach):
        raise FormatError(f"compensation_range of the model is {reach!r:.50}; it must be a number or null")
    fields["compensation_range"] = math.inf if reach is None else float(reach)
    if curve is not None:
        check_fields(check_object(curve), ("responses", "readings"), IntensityCurve.__dataclass_fields__)
        fields["intensity_curve"] = IntensityCurve(**curve)
    return SensorModel(range_offsets=offsets, **fields)
