"""Scenes with the sentences that say them, at random: what the reader makes of a sentence can be held to its scene."""

import random
from typing import Any

from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.text.lexicon import lexicon
from lidardraft.objects.kinds import SENTENCE_KINDS

Fields = dict[str, Any]
NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
WORDS = {"some": ("some", "several", "a number of"), "many": ("many", "lots of"), "few": ("a few", "a handful of")}
ROADS: tuple[tuple[str, Fields], ...] = (
    ("a crossroads", {"kind": "crossroads"}),
    ("a T-junction", {"kind": "t-junction"}),
    ("a roundabout", {"kind": "roundabout"}),
    ("a left bend", {"kind": "left-bend"}),
    ("a one-way street", {"one_way": True}),
    ("a four-lane road", {"lanes": 2}),
    ("a road without sidewalks", {"sidewalk": False}),
)
RELATIONS = {
    "behind": ("behind",),
    "in-front-of": ("in front of", "ahead of"),
    "beside": ("next to", "beside"),
    "left-of": ("to the left of",),
    "right-of": ("to the right of",),
    "near": ("near", "close to"),
    "opposite": ("opposite", "across from"),
}
# What is said of who walks, of vehicles, and of who cycles.
WALKS: tuple[tuple[str, Fields], ...] = (
    ("waiting", {"speed": 0.0}),
    ("crossing", {"heading": "across"}),
    ("crossing from left to right", {"heading": "across-right"}),
    ("crossing from right to left", {"heading": "across-left"}),
)
DRIVES: tuple[tuple[str, Fields], ...] = (
    ("parked", {"heading": "parked"}),
    ("coming towards us", {"heading": "against"}),
    ("braking", {"motion": "brakes"}),
    ("standing still", {"speed": 0.0}),
)


def nouns() -> list[tuple[str, str, str]]:
    """Kinds, each with one of its words in the singular and in the plural, without those that say more than it."""
    forms: dict[tuple[str, str], dict[Any, str]] = {}
    for entries in lexicon().values():
        for parts, word in entries:
            if word.category == "kind" and set(word.features) == {"kind", "plural", "noun"}:
                forms.setdefault((word.features["kind"], word.features["noun"]), {})[word.features["plural"]] = (
                    " ".join(parts)
                )
    found = [(kind, form[False], form[True]) for (kind, _), form in forms.items() if {False, True} <= form.keys()]
    named = ("noise", "sound", "acoustic", "terrace", "row h", "yard")  # which say more, or are a length
    return [row for row in found if row[0] != "shelter" and not row[1].startswith(named)]  # where who waits would wait


class Writer:
    """Writes scenes of one to three clauses, each of a noun phrase with a place, a manner or a relation."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.nouns: dict[str, list[tuple[str, str, str]]] = {}
        for row in nouns():
            self.nouns.setdefault(row[0], []).append(row)
        self.used: set[str] = set()

    def scene(self) -> tuple[str, SceneSpec]:
        """A sentence and its scene; no kind is named twice."""
        self.used, pick = set(), self.random.choice
        groups, clauses = list[Fields](), list[str]()
        for _ in range(self.random.choice((1, 1, 2, 2, 3))):
            clauses.append(self._clause(groups))
        text = pick((". ", ", ", ", and ")).join(clauses)
        road: Fields = {}
        if self.random.random() < 0.4:
            words, road = pick(ROADS)
            text = f"{words}. {text}"
        return text, SceneSpec(road=RoadSpec(**road), groups=tuple(ObjectGroup(**one) for one in groups))

    def _clause(self, groups: list[Fields]) -> str:
        words, fields = self._phrase()
        groups.append(fields)
        kind, share = SENTENCE_KINDS[fields["kind"]], self.random.random()
        if share < 0.25:
            other, its = self._phrase(single=True)
            fields |= {"relation": self.random.choice(list(RELATIONS)), "references": (len(groups),)}
            groups.append(its)
            there = SENTENCE_KINDS[its["kind"]]
            if kind.cycles and not (there.drives or there.walks):
                fields["heading"] = "parked"  # a bicycle at a wall
            return f"{words} {self.random.choice(RELATIONS[fields['relation']])} {other}"
        manners = WALKS if kind.walks else DRIVES if kind.is_vehicle and not kind.is_ridden else ()
        if share < 0.5 and manners and kind.name not in ("animal", "trailer"):
            said, more = self.random.choice(manners)
            fields |= more
            return f"{words} {said}"
        return f"{words} {self._place(fields)}"

    def _phrase(self, *, single: bool = False) -> tuple[str, Fields]:
        kinds = [kind for kind in self.nouns if kind not in self.used]
        kind = self.random.choice(kinds)
        self.used.add(kind)
        _, one, many = self.random.choice(self.nouns[kind])
        share = self.random.random()
        if single or share < 0.4:
            return f"{'an' if one[0] in 'aeio' else 'a'} {one}", {"kind": kind, "count": 1}
        if share < 0.8:
            count = self.random.randint(2, 12)
            return f"{self.random.choice((str(count), NUMBERS[count]))} {many}", {"kind": kind, "count": count}
        word = self.random.choice(list(WORDS))
        return f"{self.random.choice(WORDS[word])} {many}", {"kind": kind, "count": word}

    def _place(self, fields: Fields) -> str:
        side, metres = self.random.choice(("left", "right")), self.random.randint(8, 40)
        texts: list[tuple[str, Fields]] = [
            (f"on the {side}", {"places": (side,)}),
            (f"on the {side} side of the road", {"places": (side,)}),
            ("ahead of us", {"places": ("front",)}),
            ("behind us", {"places": ("behind",)}),
            (f"{metres} m ahead", {"places": ("front",), "distance": (metres, metres)}),
            (f"{metres} metres behind us", {"places": ("behind",), "distance": (metres, metres)}),
        ]
        text, said = self.random.choice(texts)
        fields |= said
        return text
