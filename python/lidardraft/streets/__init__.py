"""The endless procedural world: `for pair in streets(seed=seed): ...`."""

from lidardraft.arranging.street_mix import StreetMix
from lidardraft.streets.drives import street_drive
from lidardraft.streets.pairs import StreetPair, streets
from lidardraft.streets.scans import street_scan
from lidardraft.streets.street import Street, StreetConfig, make_street

__all__ = ["Street", "StreetConfig", "StreetMix", "StreetPair", "make_street", "street_drive", "street_scan", "streets"]
