"""The endless procedural world: `for pair in streets(seed): ...`."""

from lidardraft.streets.pairs import StreetPair, streets
from lidardraft.streets.street import Street, StreetConfig, make_street

__all__ = ["Street", "StreetConfig", "StreetPair", "make_street", "streets"]
