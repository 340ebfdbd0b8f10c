"""The roads of a layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lidardraft.json_fields import check_fields


@dataclass(frozen=True, slots=True)
class RoadNetwork:
    """The roads of a layout."""

    def to_dict(self) -> dict[str, Any]:
        """The network as JSON types."""
        return {}

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> RoadNetwork:
        """The inverse of `to_dict`; raises `FormatError` for a missing or unknown field, `LayoutError` for a value."""
        check_fields(fields, ())
        return cls()
