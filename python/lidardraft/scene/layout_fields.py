"""The fields that shapes and boxes of a layout have alike, checked."""

from __future__ import annotations

from typing import Any

from lidardraft.errors import LayoutError
from lidardraft.json_fields import are_numbers, is_number

FURTHEST = 1e9  # m, the limit of coordinates and extents: that of the core, which squares them in float32


def check_id(id: object) -> None:
    """Raise `LayoutError` on what is no name, or one that steers the terminal it is printed on."""
    if not (isinstance(id, str) and id and id.isprintable()):
        raise LayoutError(f"id is {id!r}; it must be a non-empty string of printable characters")


def checked_vector(id: str, name: str, values: Any, length: int = 3, limit: float = FURTHEST) -> Any:
    """So many finite numbers as a tuple of floats; `LayoutError` on anything else."""
    if not are_numbers(values, length):
        raise LayoutError(f"{id}: {name} is {values!r}; it must be {length} finite numbers")
    if max(map(abs, values)) > limit:
        raise LayoutError(f"{id}: {name} is {values!r}; no number may be larger than {limit:g} m")
    return tuple(map(float, values))


def checked_yaw(id: str, yaw: Any) -> float:
    """A finite number of radians; `LayoutError` on anything else."""
    if not is_number(yaw):
        raise LayoutError(f"{id}: yaw is {yaw!r}; it must be a finite number of radians")
    return float(yaw)
