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
    Responses are multiplied before by one of `distance_gains`, for each beam or for all, which has a value for each of
    `distances` [m] and is linear in its logarithm between them: optics have a focus. A reading below a beam's value of
    `cutoffs` is 0; without values none is.

    Raises `SensorError` naming the table that is none; the core checks its values.
    """

    responses: tuple[float, ...]
    readings: tuple[tuple[float, ...], ...]
    distances: tuple[float, ...] = ()
    distance_gains: tuple[tuple[float, ...], ...] = ()
    cutoffs: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for table in ("responses", "distances", "cutoffs"):
            object.__setattr__(self, table, _numbers(table, getattr(self, table)))
        for table in ("readings", "distance_gains"):
            lists = getattr(self, table)
            if not isinstance(lists, list | tuple):
                raise SensorError(f"{table} of the intensity curve is {lists!r:.50}; it must be a list of lists")
            object.__setattr__(self, table, tuple(_numbers(table, values) for values in lists))

    @property
    def tables(self) -> tuple[list[float], list[list[float]], list[float], list[list[float]], list[float]]:
        """Responses, readings, distances, gains and cut-offs, as the core has them."""
        readings, gains = ([list(values) for values in lists] for lists in (self.readings, self.distance_gains))
        return list(self.responses), readings, list(self.distances), gains, list(self.cutoffs)

    def check_beams(self, beams: int) -> None:
        """Raises `SensorError` where a table is not of so many beams."""
        for table, others in (("readings", (1,)), ("distance_gains", (0, 1)), ("cutoffs", (0,))):
            if (found := len(getattr(self, table))) not in (beams, *others):
                raise SensorError(f"{table} of the intensity curve has {found} values; it needs {beams}")


def _numbers(table: str, values: object) -> tuple[float, ...]:
    if not isinstance(values, list | tuple) or not all(map(is_number, values)):
        raise SensorError(f"{table} of the intensity curve is {values!r:.50}; it must be a list of finite numbers")
    return tuple(map(float, values))
