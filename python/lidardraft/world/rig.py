"""Several sensors on one vehicle, and their file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from lidardraft.errors import LayoutError, check_that, check_type
from lidardraft.files import JsonFile, named
from lidardraft.json_fields import are_numbers, check_fields, check_object, parse_document
from lidardraft.scene.sensor import Sensor
from lidardraft.simulation.sweeps import Spot

SCHEMA = "lidardraft.rig/1"


@dataclass(frozen=True, slots=True)
class Mount:
    """A sensor and its `spot` on the vehicle: x, y, z [m] and yaw [rad], with x ahead and z = 0 on the road. Raises
    `LayoutError` on other numbers."""

    sensor: Sensor
    spot: Spot

    def __post_init__(self) -> None:
        check_type("sensor", self.sensor, Sensor)
        fits = are_numbers(self.spot, 4) and self.spot[2] > 0.0
        check_that(fits, "spot", self.spot, "four finite numbers: x, y, z over the road and yaw")
        x, y, z, yaw = map(float, self.spot)
        object.__setattr__(self, "spot", (x, y, z, yaw))


@dataclass(frozen=True, slots=True)
class Rig(JsonFile):
    """Sensors of one vehicle, by the names of their channels; all of them scan one moment."""

    mounts: Mapping[str, Mount]

    def __post_init__(self) -> None:
        if not self.mounts:
            raise LayoutError("the rig has no sensors; it needs one at least")
        for name, mount in self.mounts.items():
            check_type(f"mount {name!r}", mount, Mount)

    def to_json(self) -> str:
        """The rig as JSON text; `from_json` gives an equal one."""
        rows = {
            name: {"sensor": json.loads(mount.sensor.to_json()), "spot": mount.spot}
            for name, mount in self.mounts.items()
        }
        return json.dumps({"schema": SCHEMA, "mounts": rows})

    @classmethod
    def from_json(cls, text: str) -> Rig:
        """Raises `FormatError` if the text is not the JSON of a rig, and the errors of its sensors."""
        mounts = {}
        for name, row in check_object(parse_document(text, SCHEMA, ("mounts",), ())["mounts"]).items():
            with named(name):
                check_fields(check_object(row), ("sensor", "spot"))
                mounts[name] = Mount(Sensor.from_json(json.dumps(row["sensor"])), row["spot"])
        return cls(mounts)
