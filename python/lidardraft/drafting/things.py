"""The objects of a modelled scene that are parts of one thing, by their parents or their names; the ids and numbers of
all."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, filterfalse, takewhile
from typing import Any

import numpy as np

from lidardraft.scene.class_names import class_of, class_of_last_word, id_of, says_many, whole_and_part, without_number
from lidardraft.scene.layout import MORE
from lidardraft.semantics import BY_NAME

_NUMBERED_PART = re.compile(r"(.*?\d+)[._ -]+(\D.*)", re.DOTALL)  # of stuff: "tree_1_trunk" is a part of "tree_1"
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_BODY = re.compile("body|chassis|hull|base|main|frame|torso")  # names of a part that a thing has once
_PART = re.compile(
    "(?:wheel|tire|tyre|rim|hub|axle|cabin|cab|roof|hood|bonnet|door|trunk|window|windshield|windscreen|glass|bumper"
    "|fender|grille|headlight|taillight|light|mirror|spoiler|seat|saddle|handlebar|fork|pedal|plate|head|arm|leg|hand"
    "|foot|helmet)s?"
)


@dataclass(eq=False, slots=True)
class Node:
    """An object of a scene: its name, the class of its surface (None without one), its parent, its place [3], and the
    suffix of its name if an array copied it from another one."""

    name: str
    label: str | None = None
    parent: Node | None = None
    place: Callable[[], np.ndarray] = lambda: np.zeros(3)
    suffix: str = ""

    def up(self) -> Iterator[Node]:
        """The node, its parent, the parent of that, and so on."""
        node: Node | None = self
        while node is not None:
            yield node
            node = node.parent


class Things:
    """The things of nodes, each with its id, the prefix of its parts, and its number; `given` numbers are taken
    already."""

    def __init__(self, nodes: Sequence[Node], classes: Mapping[str, str], given: Iterable[Any] = ()) -> None:
        self._classes = classes
        self._wholes: dict[Node, str] = {}  # the names of those that are not parts
        self._ids: dict[str, str] = {}  # of wholes
        self._used: set[str] = set()  # ids that an object has itself, and not only its parts
        self._distinct_wholes, self._distinct_ids = _Distinct(), _Distinct()
        taken = {number for number in given if type(number) is int}
        self._numbers = defaultdict[str, int](filterfalse(taken.__contains__, count(1)).__next__)
        self._found: dict[tuple[Node, str], tuple[str, str]] = {}  # wholes and parts
        self._of_one_thing: dict[Node, str | None] = {}
        self._groups = self._groups_of(nodes)
        # Those that are not parts, by the words of their names and the suffix of a copy, and their places [N, 3].
        self._known: dict[tuple[tuple[str, ...], str], list[Node]] = {}
        self._places: dict[tuple[tuple[str, ...], str], np.ndarray] = {}
        for node in nodes:
            name = _Name(node.name)
            if _is_thing(node.label) and not name.is_part:
                self._known.setdefault((name.keys[0], node.suffix), []).append(node)

    def fields_of(self, node: Node, label: str, properties: Mapping[str, Any]) -> dict[str, Any]:
        """The fields of a primitive for one more surface of a node, with a class; the object's own properties take
        precedence."""
        fields = {name: properties[name] for name in ("instance", *MORE) if name in properties}
        fields |= {"label": label, "id": properties.get("id") or self.id_of(node, label)}
        if "instance" not in fields:
            fields["instance"] = self.number_of(node, label)
        return fields

    def id_of(self, node: Node, label: str) -> str:
        """The id of one more surface of a node, with a class: that of its whole or, after a dot, of a part of it."""
        whole, part = self._whole_and_part(node, label)
        if whole not in self._ids:
            self._ids[whole] = self._distinct_ids.name(id_of(whole).replace(".", "_"), "_")
        own = self._ids[whole]
        if part:
            return self._distinct_ids.name(f"{own}.{id_of(part).replace('.', '_')}", "_")
        if own in self._used:
            return self._distinct_ids.name(own, ".")
        self._used.add(own)
        return own

    def number_of(self, node: Node, label: str) -> int:
        """The number of the thing of a node, as a whole or a part; 0 for stuff."""
        return self._numbers[self._whole_and_part(node, label)[0]] if _is_thing(label) else 0

    def _whole_and_part(self, node: Node, label: str) -> tuple[str, str]:
        """The names of the whole and of the part; the part is "" if the node is an object of its own.

        The node is a part of the uppermost node above it that is one thing of its class, or else of "Car_1" if its name
        is "Car_1_Wheel".
        """
        if (node, label) not in self._found:
            above = (each for each in node.up() if each is not node and each not in self._groups)
            things = [each for each in above if self._thing_of(each) == label]
            whole, part = self._named(things[-1] if things else node, label)
            if things:
                whole, part = whole + node.suffix, node.name.removeprefix(whole).lstrip("._ -") or node.name
            self._found[node, label] = whole, part
        return self._found[node, label]

    def _named(self, node: Node, label: str | None) -> tuple[str, str]:
        """The whole and the part in its name."""
        if not _is_thing(label):
            numbered = _NUMBERED_PART.fullmatch(node.name[:200])
            return self._own(node, *(numbered.groups() if numbered else whole_and_part(node.name)))
        name = _Name(node.name)
        keys = [(key, suffix) for key in name.keys for suffix in (node.suffix, "")]
        key = next((key for key in keys if key in self._known), None)
        if not name.is_part or key is None:
            return self._own(node, name.whole, name.part)
        known = self._known[key]
        if key not in self._places:
            self._places[key] = np.array([each.place() for each in known])
        # If several share a name, it belongs to the nearest one.
        place = node.place() if len(known) > 1 else 0.0
        nearest = known[int(np.argmin(((self._places[key] - place) ** 2).sum(axis=1)))]
        return self._named(nearest, nearest.label)[0], name.part + node.suffix.removeprefix(key[1])

    def _own(self, node: Node, whole: str, part: str) -> tuple[str, str]:
        """The whole and the part of a node that names them itself; a name in use gets a number."""
        if part:
            return whole + node.suffix, part
        if node not in self._wholes:
            self._wholes[node] = self._distinct_wholes.name(node.name + node.suffix, ".")
        return self._wholes[node], ""

    def _groups_of(self, nodes: Iterable[Node]) -> set[Node]:
        """The nodes above two or more whose names are one thing of the same class as their own: "Vehicle" above
        "Car.001" and "Car.002". A node with a number, such as "Truck_2", is one thing all the same."""
        first: dict[Node, Node] = {}
        groups: set[Node] = set()
        for node in nodes:
            nearest: dict[str, Node] = {}  # to the root, of those of a class on the way there
            for each in node.up():
                label = self._thing_of(each)
                below = nearest.get(label) if label else None
                if below and not each.name[-1:].isdigit() and first.setdefault(each, below) is not below:
                    groups.add(each)
                if said := self._classes.get(each.name) or class_of_last_word(each.name):
                    nearest[said] = each
        return groups

    def _thing_of(self, node: Node) -> str | None:
        """The class of a node that is one thing; None if it is several."""
        if node not in self._of_one_thing:
            said = None if says_many(node.name) else node.label or class_of([node.name], self._classes)
            self._of_one_thing[node] = said
        return self._of_one_thing[node]


class _Distinct:
    """Names, each handed out once."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._last: dict[tuple[str, str], int] = {}  # the last numbers after names, and the separator before them

    def name(self, name: str, before_number: str) -> str:
        """The name or, if it is taken, with the first free number after it."""
        found = name
        while found in self._taken:
            number = self._last[name, before_number] = self._last.get((name, before_number), 1) + 1
            found = f"{name}{before_number}{number}"
        self._taken.add(found)
        return found


class _Name:
    """The parts of a thing's name: its whole ("Car_Red" of "Car_Red_Wheel_FL"), its part of that, and the numbers after
    the part, of which the first may be the whole's ("Car_Wheel_0_1")."""

    def __init__(self, name: str) -> None:
        plain = without_number(name)[:200]
        words = list(_WORD.finditer(plain))
        said = [word.group().lower() for word in words]
        kinds = [_PART.fullmatch(word) or _BODY.fullmatch(word) for word in said]
        place = next((k for k in range(len(said) - 1, 0, -1) if kinds[k]), None)
        numbers = [] if place is None else list(takewhile(str.isdigit, said[place + 1 :]))
        self.is_part = place is not None and _PART.fullmatch(said[place]) is not None
        self.keys = [(*said[:place], *numbers[:count]) for count in range(len(numbers), -1, -1)]
        if place is None:
            self.whole, self.part = whole_and_part(name)
            return
        start = plain[: words[place].start()].rstrip("._ -")
        own = numbers[: len(numbers) - 1] if self.is_part else numbers
        self.whole, self.part = "_".join([start, *own]), name[words[place].start() :]
        if not self.is_part:
            self.whole += name[len(plain) :]  # the number that distinguishes bodies


def _is_thing(label: str | None) -> bool:
    return label in BY_NAME and BY_NAME[label].is_thing
