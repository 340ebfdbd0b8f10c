"""What one unit's lasers read of an echo."""

from __future__ import annotations

from dataclasses import dataclass

from lidardraft.errors import SensorError
from lidardraft.json_fields import is_number


@dataclass(frozen=True, kw_only=True)
class IntensityCurve:
    """Readings, 0 to 1, of responses: a curve that all beams share, and how each of them differs.

    `readings` are those of `responses`, which ascend; between these knots a reading is linear in the logarithm of the
    response, beyond them it stays. A response of 1 is that of a white surface that faces the sensor. `gains` are what
    each beam's responses are multiplied by before, `offsets` what it reads less; what is then below its value of
    `cutoffs` reads 0. These tables have a value for each beam, row 0 the highest, or none: 1 and 0 for all.

    Raises `SensorError` naming the table that cannot be; the core checks its values.
    """

    responses: tuple[float, ...]
    readings: tuple[float, ...]
    gains: tuple[float, ...] = ()
    offsets: tuple[float, ...] = ()
    cutoffs: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for table in self.__dataclass_fields__:
            values = getattr(self, table)
            if not isinstance(values, list | tuple) or not all(map(is_number, values)):
                raise SensorError(f"{table} of the intensity curve is {values!r}; it must be a list of finite numbers")
            object.__setattr__(self, table, tuple(map(float, values)))
        if len(self.responses) != len(self.readings):
            raise SensorError(
                f"the intensity curve has {len(self.readings)} readings; it needs one for each of "
                f"{len(self.responses)} responses"
            )

    @property
    def tables(self) -> tuple[list[tuple[float, float]], list[float], list[float], list[float]]:
        """Knots, gains, offsets and cut-offs, as the core has them."""
        knots = list(zip(self.responses, self.readings, strict=True))
        return knots, list(self.gains), list(self.offsets), list(self.cutoffs)

    def check_beams(self, beams: int) -> None:
        """Raises `SensorError` where a table is not of so many beams."""
        for table, values in (("gains", self.gains), ("offsets", self.offsets), ("cutoffs", self.cutoffs)):
            if len(values) not in (0, beams):
                raise SensorError(f"{table} of the intensity curve has {len(values)} values; it needs {beams}")
