"""The modifiers of an object: arrays are carried out, all others are passed over with a note."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from lidardraft.drafting.blender.bpy.blocks import Listed, Unread
from lidardraft.drafting.blender.bpy.mathutils import Vector
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import Methods, Record, Value, describe, reals, text, truth, whole

# What changes a surface by little; the note on another says that the shape is that without it.
_SMOOTHING = ("BEVEL", "SUBSURF", "EDGE_SPLIT", "WEIGHTED_NORMAL", "SMOOTH", "TRIANGULATE", "SMOOTH_BY_ANGLE")
_MOST = 8  # modifiers of an object
_MOST_COPIES = 1000  # that one array makes


class ArrayModifier(Record):
    """Copies of an object in a row, `count` of them with itself."""

    kind = "an array modifier"

    def __init__(self, name: str) -> None:
        self.name = name
        self.values: dict[str, Value] = {
            "count": 2,
            "use_relative_offset": True,
            "use_constant_offset": False,
            "relative_offset_displace": Vector([1.0, 0.0, 0.0]),
            "constant_offset_displace": Vector([1.0, 0.0, 0.0]),
            "fit_type": "FIXED_COUNT",
            "use_merge_vertices": False,
        }

    fields: ClassVar[Methods] = {"name": lambda self: self.name, "type": lambda _: "ARRAY"}

    def attribute(self, name: str) -> Value:
        return self.values[name] if name in self.values else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name.startswith("show_"):
            return
        if name not in self.values or (name == "fit_type" and value != "FIXED_COUNT"):
            super().set_attribute(name, value)
        elif name.endswith("_displace"):
            self.values[name].change(reals(value, 3, f"the {name}"))
        elif name == "count":
            self.values[name] = whole(value, "the count of an array", 1, _MOST_COPIES)
        elif not isinstance(value, bool | int | str):
            raise RefusalError(f"{name} of an array is {describe(value)}")
        else:
            self.values[name] = value

    def copied(self) -> ArrayModifier:
        """Another one with the same settings."""
        other = ArrayModifier(self.name)
        for name, value in self.values.items():
            other.values[name] = Vector(value.numbers) if isinstance(value, Vector) else value
        return other

    def step(self, extents: np.ndarray) -> np.ndarray:
        """From one copy to the next [3], along the axes of an object whose mesh has these extents [3]."""
        values, step = self.values, np.zeros(3)
        if truth(values["use_relative_offset"]):
            step += np.array(values["relative_offset_displace"].numbers) * extents
        if truth(values["use_constant_offset"]):
            step += values["constant_offset_displace"].numbers
        return step


class Modifiers(Listed):
    """All modifiers of one object."""

    kind = "the list of modifiers"

    def __init__(self, script: Script) -> None:
        self._script = script
        self.arrays: list[ArrayModifier] = []

    def new(self, name: Value, type: Value) -> Value:
        """A new modifier; what is set in one that is passed over is passed over too."""
        kind = text(type, "the modifier")
        if kind == "ARRAY":
            if len(self.arrays) >= _MOST:
                raise RefusalError(f"an object with more than {_MOST} modifiers")
            self.arrays.append(ArrayModifier(text(name, "the name")))
            return self.arrays[-1]
        shape = "" if kind in _SMOOTHING else ": the shape is that without it"
        self._script.note(f"the modifier {kind:.40} is passed over{shape}")
        return Unread("modifiers", self._script)

    def elements(self) -> list[Value]:
        return list(self.arrays)

    def item(self, key: Value) -> Value:
        try:
            return super().item(key)
        except RaisedError:
            return Unread("modifiers", self._script)  # one that is passed over

    methods: ClassVar[Methods] = {
        **Listed.methods,
        "new": new,
        "clear": lambda self: self.arrays.clear(),
        "remove": lambda self, modifier: self.arrays.remove(modifier) if modifier in self.arrays else None,
    }

    def offsets(self, extents: np.ndarray) -> list[np.ndarray]:
        """Where its copies stand [3], along the axes of the object, itself first: arrays of arrays multiply."""
        count = 1
        for array in self.arrays:
            count *= array.values["count"]
            if count > _MOST_COPIES:
                raise RefusalError(f"the arrays of an object make {count} copies; {_MOST_COPIES} are the most")
        places = [np.zeros(3)]
        for array in self.arrays:
            step, numbers = array.step(extents), range(array.values["count"])
            extents = extents + abs(step) * (len(numbers) - 1)
            places = [place + number * step for number in numbers for place in places]
        return places
