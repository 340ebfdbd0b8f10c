"""The ids and instances of modelled objects: which pieces are parts of one thing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from lidardraft.scene.class_names import class_of, class_of_last_word, id_of, says_many, whole_of


class PieceIds:
    """Ids of pieces of nodes, each of them once, and numbers of things: those that are `given` are taken already.

    `paths` are the indices and names of all pieces, as `id_of` takes them.
    """

    def __init__(
        self,
        given: list[Any],
        classes: Mapping[str, str],
        paths: Iterable[tuple[tuple[int, ...], tuple[str, ...]]] = (),
    ) -> None:
        self._classes = classes
        self._given = {number for number in given if type(number) is int}
        self._wholes: dict[int, str] = {}  # ids of nodes
        self._used: set[str] = set()  # of these, those that a piece has
        self._taken: set[str] = set()
        self._numbers: dict[tuple[str, str], int] = {}  # the last ones behind names, and what stands before them
        self._instances: dict[str, int] = {}
        self._of_one_thing: dict[str, str | None] = {}  # the class that names say of one thing
        self._next = 1
        self._groups = self._groups_of(paths)

    def id_of(self, indices: tuple[int, ...], names: tuple[str, ...], label: str) -> str:
        """The id of one more piece of a node, of which the indices and names come first, then those of its parents.

        What is below a node that is one thing of the class is a part of it: "Truck_2.Cab".
        """
        above = (k for k in range(1, len(indices)) if indices[k] not in self._groups)
        place = max((k for k in above if self._thing_of(names[k]) == label), default=0)
        whole = self._whole_of(indices[place], names[place:])
        if place and names[0]:
            return self._distinct(f"{whole}.{id_of(names[0]).replace('.', '_')}", "_")
        if whole not in self._used:  # the node itself, and not a part of it
            self._used.add(whole)
            return whole
        return self._distinct(whole, ".")

    def _whole_of(self, index: int, names: tuple[str, ...]) -> str:
        """The id of a node; one that there is already is that of another node."""
        if index not in self._wholes:
            name = next((name for name in names if name), "unnamed")
            self._wholes[index] = self._distinct(id_of(name), "_")
        return self._wholes[index]

    def instance_of(self, whole: Any) -> int:
        """The number of the thing that an id is of, or of a part of."""
        key = whole_of(whole) if isinstance(whole, str) else ""
        if key not in self._instances:
            while self._next in self._given:
                self._next += 1
            self._instances[key] = self._next
            self._next += 1
        return self._instances[key]

    def _groups_of(self, paths: Iterable[tuple[tuple[int, ...], tuple[str, ...]]]) -> set[int]:
        """The nodes below which two or more have a name that says one thing of the same class, as they have themselves:
        "Vehicle" above "Car.001" and "Car.002". One with a number, such as "Truck_2", is one thing for all that.
        """
        first: dict[int, int] = {}
        groups: set[int] = set()
        for indices, names in paths:
            nearest: dict[str, int] = {}  # to the root, of the nodes of a class that were passed on the way there
            for index, name in zip(indices, names, strict=False):  # the last name is that of the mesh
                label = self._thing_of(name)
                below = nearest.get(label) if label else None
                if below is not None and not name[-1:].isdigit() and first.setdefault(index, below) != below:
                    groups.add(index)
                if said := self._classes.get(name) or class_of_last_word(name):
                    nearest[said] = index
        return groups

    def _thing_of(self, name: str) -> str | None:
        if name not in self._of_one_thing:
            self._of_one_thing[name] = None if says_many(name) else class_of([name], self._classes)
        return self._of_one_thing[name]

    def _distinct(self, name: str, before_number: str) -> str:
        found = name
        while found in self._taken:
            number = self._numbers[name, before_number] = self._numbers.get((name, before_number), 1) + 1
            found = f"{name}{before_number}{number}"
        self._taken.add(found)
        return found
