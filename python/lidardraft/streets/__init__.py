"""The endless procedural world: `for pair in streets(seed): ...`."""

from lidardraft.streets.street import Street, StreetConfig, StreetPair, make_street, streets

__all__ = ["Street", "StreetConfig", "StreetPair", "make_street", "streets"]
