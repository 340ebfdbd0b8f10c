"""What one unit's lasers read of an echo."""

from __future__ import annotations

from dataclasses import dataclass

from lidardraft.errors import SensorError
from lidardraft.json_fields import is_number


@dataclass(frozen=True, kw_only=True)
class IntensityCurve:
    """Readings, 0 to 1, of responses: a curve for each beam, row 0 the highest, or one for all.

    Each of `readings` has a value for each of `responses`, which ascend; between these knots a reading is linear in the
    logarithm of the response, beyond them it stays. A response of 1 is that of a white surface that faces the sensor.
    Responses are multiplied before by `distance_gains`, linear in their logarithm between `distances` [m], which
    ascend: optics have a focus. A reading below a beam's value of `cutoffs` is 0; without values none is.

    Raises `SensorError` naming the table that is none; the core checks its values.
    """

    responses: tuple[float, ...]
    readings: tuple[tuple[float, ...], ...]
    distances: tuple[float, ...] = ()
    distance_gains: tuple[float, ...] = ()
    cutoffs: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for table in ("responses", "distances", "distance_gains", "cutoffs"):
            object.__setattr__(self, table, _numbers(table, getattr(self, table)))
        if not isinstance(self.readings, list | tuple):
            raise SensorError(f"readings of the intensity curve is {self.readings!r:.50}; it must be a list of lists")
        object.__setattr__(self, "readings", tuple(_numbers("readings", values) for values in self.readings))

    @property
    def tables(self) -> tuple[list[float], list[list[float]], list[float], list[float], list[float]]:
        """Responses, readings, distances, gains and cut-offs, as the core has them."""
        readings = [list(values) for values in self.readings]
        return list(self.responses), readings, list(self.distances), list(self.distance_gains), list(self.cutoffs)

    def check_beams(self, beams: int) -> None:
        """Raises `SensorError` where a table is not of so many beams."""
        for table, found, other in (("readings", len(self.readings), 1), ("cutoffs", len(self.cutoffs), 0)):
            if found not in (beams, other):
                raise SensorError(f"{table} of the intensity curve has {found} values; it needs {beams}")


def _numbers(table: str, values: object) -> tuple[float, ...]:
    if not isinstance(values, list | tuple) or not all(map(is_number, values)):
        raise SensorError(f"{table} of the intensity curve is {values!r:.50}; it must be a list of finite numbers")
    return tuple(map(float, values))
