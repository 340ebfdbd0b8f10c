"""The words of a sentence that count: without them, or with others, the spec would differ."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from lidardraft.drafting.solver.scene_spec import SceneSpec, relations
from lidardraft.drafting.text.chart import Features, Grammar, Node, Rule
from lidardraft.drafting.text.doubts import STRANGE
from lidardraft.drafting.text.grammar import UNSHOWN
from lidardraft.drafting.text.positions import Position
from lidardraft.drafting.text.tree import leaves

Path = tuple[int, ...]  # from the sentence down to a constituent, by the numbers of children
Changes = Mapping[Path, tuple[Node, ...]]  # replacements of constituents
Same = Callable[[Changes], bool]  # whether the spec stays the same
Idle = dict[Path, tuple[Node, tuple[Node, ...]]]  # constituents that change nothing, with the part of each that is kept
Read = Callable[[Sequence[Node]], SceneSpec]
_SAYS_NOTHING = [(one.name, one.default) for one in dataclasses.fields(Position)]
_VERBS = ("crossed", "turned", "state")
_NEUTRAL = (  # words that join others, or state a default
    *("silent", "usual", "is", "and", "with", "has", "but", "except", "which", "there", "ego", "pronoun", "time"),
    *("the", "a", "single", "about", "unit", "another", "all", "both", "of", "ofthem", "respectively"),
    *("lengthways", "median_where"),
    *(",", ".", ":", "(", ")", "of_road"),
)
_CONTENT = ("usual", "time", "unit", "ego")  # those of them with a meaning
_PLAIN = (
    ("road", "straight"),
    ("anyway", "coming"),
    ("anyway", "walking"),
    ("anyway", "riding"),
    ("anyway", "standing"),
    ("another", True),
    ("rest", "other"),
    ("each_way", True),
    ("around", True),
)
_OTHERS = {
    **{"left": "right", "right": "left", "front": "behind", "behind": "front"},
    **{"parked": "against", "many": "few", "some": "many"},
}


def idle_parts(nodes: Sequence[Node], grammar: Grammar, read: Read) -> list[Node]:
    """The constituents that change nothing: the spec is the same without them, and with another word in their place.

    If two say the same, both count, as the spec differs without both. Words that mean more than they change, such as
    "child", are among the returned ones.
    """
    whole = read(nodes)

    def same(changed: Changes) -> bool:
        kept = _with(nodes, changed, grammar)
        return kept is not None and _read(read, kept) in (None, whole)

    def is_idle(path: Path, node: Node) -> bool:
        if node.symbol in (*STRANGE, *UNSHOWN, "scenic"):
            return True
        turned = [{at: (other,)} for at, leaf in _leaves(node, path) for other in _turned(leaf, whole)]
        turned = [one for one in turned if _with(nodes, one, grammar) is not None]
        if (node.symbol == "number") and _with(nodes, {path: ()}, grammar) is None:
            return bool(turned) and all(_read(read, _with(nodes, one, grammar) or []) == whole for one in turned)
        return same({path: ()}) and all(same(one) for one in turned)

    def is_lost(path: Path, noun: Node) -> bool:
        """Whether a noun only changes the meaning of others, so that another noun in its place changes nothing."""
        others = [{path: (other,)} for other in _turned(noun, whole)]
        return bool(others) and all(_with(nodes, one, grammar) is not None and same(one) for one in others)

    idle: Idle = {}

    def visit(path: Path, node: Node) -> None:
        if not node.children and node.get("more"):
            more.append(node)
        if _is_neutral(node):
            more.extend(leaf for _, leaf in _leaves(node, path) if leaf.get("more") and leaf is not node)
            return
        known = bool(node.children) and node.symbol not in STRANGE
        names_road = known and node.get("road") == whole.road.kind != "straight"  # as others may imply it
        if not names_road and is_idle(path, node):
            idle[path] = (node, ())
            return
        if node.symbol == "relation" and same({path: _apart(node)}):
            idle[path] = (node._replace(end=node.children[-1].start), _apart(node))
        if node.symbol in ("kind", "ordinal") and is_lost(path, node):
            more.append(node)
        for index, child in enumerate(node.children):
            if child.symbol != "gait" or len(node.children) == 1:  # "driving towards us": the direction says all
                visit((*path, index), child)

    more: list[Node] = []
    for index, node in enumerate(nodes):
        visit((index,), node)
    _add_runs(nodes, idle, same)
    return [*more, *_without_repeats(nodes, whole, idle, same)]


def _without_repeats(nodes: Sequence[Node], whole: SceneSpec, idle: Idle, same: Same) -> list[Node]:
    """The idle constituents without those that repeat another one."""
    known = [path for path, (node, _) in idle.items() if node.symbol not in STRANGE]
    twice = _said_twice(known, idle, same)
    settled = {path for pair in twice for path in pair}
    settled |= {path for path in known if any(_is_said_by(idle[path][0], one) for one in _beside(nodes, path[0]))}
    settled |= {path for path in known if _names_setting(idle[path][0], whole)}
    numbers = [
        leaf for pair in twice for node in (idle[path][0] for path in pair) for leaf in leaves(node, "number", *STRANGE)
    ]
    more = [leaf for path in settled for _, leaf in _leaves(idle[path][0], path) if leaf.get("more")]
    return [*more, *numbers, *(node for path, (node, _) in idle.items() if path not in settled)]


def _said_twice(paths: Sequence[Path], idle: Idle, same: Same) -> list[tuple[Path, Path]]:
    """The pairs of constituents of which either may be left out, but not both: one repeats the other."""
    return [
        (a, b)
        for a, b in itertools.combinations(paths, 2)
        if _said(idle[a][0]) & _said(idle[b][0]) and not same({a: idle[a][1], b: idle[b][1]})
    ]


def _add_runs(nodes: Sequence[Node], idle: Idle, same: Same) -> None:
    """Add the runs of constituents that change nothing together, although each of them alone does."""
    for run in _runs(nodes):
        paths = [(index,) for index in run]
        others = set().union(*(node.all("kind") for index, node in enumerate(nodes) if index not in run))
        again = any(others.intersection(nodes[index].all("kind")) for index in run)
        gone = {path: kept for path, (_, kept) in idle.items()}
        if (
            len(run) > 1
            and not (again or any(path in idle for path in paths))
            and same(dict.fromkeys(paths, ()))
            and same(gone) is same(gone | dict.fromkeys(paths, ()))
        ):
            idle |= {(index,): (nodes[index], ()) for index in run if not _is_neutral(nodes[index])}


def _runs(nodes: Sequence[Node]) -> Iterator[list[int]]:
    """The numbers of the constituents between two signs, and from each link on: each run has a meaning."""
    for is_end, part in itertools.groupby(range(len(nodes)), lambda index: nodes[index].symbol in (",", ".")):
        run = list(part)
        if not is_end:
            yield run
            yield from (run[n:] for n in range(1, len(run)) if nodes[run[n]].symbol in ("and", "with", "but", "has"))


def gave(nodes: Sequence[Node], index: int, read: Read) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The numbers of the groups, and the other relations of the spec, that would be missing without a constituent.

    For a repeated statement they are those that would be missing without both.
    """
    node, whole = nodes[index], read(nodes)
    for said in ("a scene" if node.get("asks") else "", node.get("anyway", "")):
        if said:
            return (), (said,)
    if node.symbol == "ego":
        return (), ("the ego vehicle",)
    for twin in (index, *range(len(nodes))):
        kept = [one for number, one in enumerate(nodes) if number != twin or twin == index]
        spec, less = _read(read, kept), _read(read, [one for one in kept if one is not node])
        if spec is None or less in (None, spec):
            continue
        assert less is not None
        gone = [group for group in spec.groups if group not in less.groups]
        groups = tuple(number for number, group in enumerate(whole.groups) if group in gone)
        others = tuple(one for one in _of_scene(spec) if one in _of_scene(whole) and one not in _of_scene(less))
        if groups or others:
            return groups, others
    roads = any(leaves(node, "road", "usual", "oneway", "eachway"))
    return (), tuple(one for one in _of_scene(whole) if roads and one.startswith("road"))


def _of_scene(spec: SceneSpec) -> list[str]:
    """The relations of a spec that belong to none of its groups."""
    around = [f"around: {one}" for one in (spec.district, spec.activity) if one]
    return relations(replace(spec, groups=())) + around + [f"around: no {kind}" for kind in spec.not_around]


def says_something(node: Node) -> bool:
    """Whether a constituent is more than words that join others."""
    if node.children and node.symbol not in STRANGE:
        return any(map(says_something, node.children))
    silent = node.symbol in _NEUTRAL and node.symbol not in _CONTENT and not (node.get("act") or node.get("asks"))
    return not (silent or node.symbol.startswith("'") or (node.symbol == "number" and node.get("value") == 1))


def _names_setting(node: Node, whole: SceneSpec) -> bool:
    """Whether it only repeats the name of the road or its area: "fields" beside "a rural road"."""
    plain = all(
        leaf.symbol in ("setting", "road", "the", "a") or leaf.symbol[0] == "'" for _, leaf in _leaves(node, ())
    )
    named = (node.get("district"), whole.district), (node.get("road"), whole.road.kind)
    return plain and any(said is not None and said == one for said, one in named)


def _is_said_by(node: Node, other: Node) -> bool:
    """Whether the constituent beside a verb or a place means the same."""
    said = _said(node)
    if node.symbol == "whereabouts":  # "parked along the kerb"
        return bool(said) and (said <= _said(other) or "heading parked" in said & _said(other))
    return node.symbol in _VERBS and bool(said & _said(other))


def _beside(nodes: Sequence[Node], index: int) -> Sequence[Node]:
    """The constituents before and after one of a sentence."""
    before = [one for one in nodes[:index] if one.symbol not in UNSHOWN]
    after = [one for one in nodes[index + 1 :] if one.symbol not in UNSHOWN]
    return [*before[-1:], *after[:1]]


def _said(node: Node) -> set[str]:
    """The meaning of its words, without their number."""
    positions = (value for _, value in node.features if isinstance(value, Position))
    fields = ((one.name, getattr(at, one.name)) for at in positions for one in dataclasses.fields(at))
    said = (*((name, value) for name, value in node.features if name not in ("plural", "at")), *fields)
    return {  # "crossing" and "from the left" both say that it crosses
        f"{name} {str(value).partition('-')[0] if name == 'heading' else value!r}"
        for name, value in said
        if (name, value) not in _SAYS_NOTHING
    }


def _is_neutral(node: Node) -> bool:
    """Whether all words of a constituent are neutral."""
    if node.symbol in STRANGE or node.get("act"):
        return False
    if node.symbol == "determiner" and node.get("another"):
        return True
    if node.symbol in _NEUTRAL or node.symbol.startswith("'") or any(one in node.features for one in _PLAIN):
        return not node.children or node.symbol in _NEUTRAL or all(map(_is_neutral, node.children))
    if node.symbol == "ellipsis" and any(leaves(node, "number")):
        return False  # "two inside and one outside"
    return (bool(node.children) and all(map(_is_neutral, node.children))) or (
        node.symbol == "number" and node.get("value") == 1
    )


def _leaves(node: Node, path: Path) -> Iterator[tuple[Path, Node]]:
    if not node.children:
        yield path, node
    for index, child in enumerate(node.children):
        yield from _leaves(child, (*path, index))


def _apart(relation: Node) -> tuple[Node, ...]:
    """The targets of a relation, as if they were listed."""
    comma = Node(",", relation.start, relation.start, 0.0)
    targets = [one for child in relation.children if child.symbol == "relative" for one in child.children[0].children]
    return tuple(node for target in targets for node in (comma, target))


def _turned(leaf: Node, spec: SceneSpec) -> list[Node]:
    """A word with other meanings of the same sort, such as "right" for "left", "three" and "four" for "two"."""
    heading = leaf.get("heading")
    if heading and not any(str(group.heading).startswith(heading) for group in spec.groups):
        return []
    found = []
    for further in (1, 2) if leaf.symbol == "number" else (1,):
        said = {name: _other(name, value, further) for name, value in leaf.features}
        features = tuple((name, value if said[name] is None else said[name]) for name, value in leaf.features)
        found += [leaf._replace(features=features)] if features != leaf.features else []
    return found


def _other(name: str, value: Any, further: int) -> Any:
    if isinstance(value, Position):
        places = tuple((_OTHERS.get(fore, fore), _OTHERS.get(side, side)) for fore, side in value.places)
        return replace(value, places=places, heading=_OTHERS.get(str(value.heading), value.heading))
    if name in ("value", "ordinal"):
        return value + further
    if name == "plain":
        return False
    if name == "kind":
        return "car" if value == "person" else "person"
    if name == "heading":
        return _OTHERS.get(value, "parked")
    return _OTHERS.get(value) if isinstance(value, str) else None


def _read(read: Read, nodes: Sequence[Node]) -> SceneSpec | None:
    try:
        return read(nodes)
    except ValueError:
        return None


def _with(nodes: Sequence[Node], changed: Changes, grammar: Grammar, at: Path = ()) -> list[Node] | None:
    """Constituents with replacements in some places, or nothing; None if a rule needs the original."""
    found: list[Node] = []
    for index, node in enumerate(nodes):
        path = (*at, index)
        if path in changed:
            found += changed[path]
            continue
        if any(one[: len(path)] == path for one in changed):
            children = _with(node.children, changed, grammar, path)
            built = _rebuilt(node, children, grammar) if children is not None else None
            if built is None:
                return None
            node = built
        found.append(node)
    return found


def _rebuilt(node: Node, children: list[Node], grammar: Grammar) -> Node | None:
    rule = next(one for one in grammar.rules[node.symbol] if _fits(one, node.children))
    made = node._replace(features=_features(children), children=tuple(children))
    said = (rule.build(made) if rule.build else made.features) if _fits(rule, children) else None
    return None if said is None else made._replace(features=said)


def _features(children: Sequence[Node]) -> Features:
    return tuple(feature for child in children for feature in child.features)


def _fits(rule: Rule, children: Sequence[Node]) -> bool:
    return _pattern(rule.parts).fullmatch("".join(f"{child.symbol};" for child in children)) is not None


@cache
def _pattern(parts: tuple[tuple[str, str], ...]) -> re.Pattern[str]:
    return re.compile("".join(f"(?:{re.escape(symbol)};){times}" for symbol, times in parts))
