"""Layouts of the schema "lidardraft.layout/1", whose provenance holds what later schemas have fields for. No other
code gives meaning to a provenance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from lidardraft.files import expecting, named
from lidardraft.json_fields import read_as
from lidardraft.scene.intent import Intent
from lidardraft.scene.road import Road
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.scene.street import StreetFrame

SCHEMA_1 = "lidardraft.layout/1"
_CLUSTERINGS = ("cloud", "point cloud")  # sources whose boxes do not tell front from back


def converted(provenance: dict[str, Any]) -> dict[str, Any]:
    """The roads, the intent and the notes of a layout, by the names of its fields; raises `LidarDraftError` if they are
    not as lidardraft writes them."""
    with named("provenance"), expecting("what lidardraft writes"):
        return {"roads": _roads(provenance), "intent": _intent(provenance), "notes": tuple(_notes(provenance))}


def _roads(provenance: dict[str, Any]) -> RoadNetwork | None:
    road = provenance.get("road")
    return None if road is None else RoadNetwork(street=StreetFrame(road=read_as(Road, road, "road")))


def _intent(provenance: dict[str, Any]) -> Intent:
    spec, around = provenance.get("spec"), provenance.get("surroundings")
    intent = Intent.of_spec(spec, provenance.get("objects", {})) if isinstance(spec, dict) else Intent()
    clustered = provenance.get("source") in _CLUSTERINGS or "sensor_height" in provenance
    said: dict[str, Any] = {"sentence": provenance.get("sentence"), "headed": not clustered}
    said["around"] = around.get("district") if isinstance(around, dict) else None
    if provenance.get("source") == "streets":
        said["district"] = provenance.get("district")
    return replace(intent, **said)


def _notes(provenance: dict[str, Any]) -> Iterator[str]:
    if words := _lines(provenance, "not_understood"):
        nearest = provenance.get("nearest_words")
        near = "".join(f"; did you mean {known!r}?" for known in nearest.values()) if nearest else ""
        yield f"not understood: {', '.join(words)}{near}"
    if words := _lines(provenance, "not_shown"):
        yield f"not shown: {', '.join(words)}"
    yield from (f"ignored: {line}" for line in _lines(provenance, "ignored"))
    yield from (*_lines(provenance, "notes"), *_lines(provenance, "findings"))
    if isinstance(around := provenance.get("surroundings"), dict):
        yield from [around["note"]] if "note" in around else []
        yield from (f"{name} cannot be seen: {by} stands before it" for name, by in around.get("hidden", {}).items())


def _lines(provenance: dict[str, Any], name: str) -> list[str]:
    """The lines of that name; an empty list if it holds no list."""
    lines = provenance.get(name)
    return list(map(str, lines)) if isinstance(lines, list | tuple) else []
