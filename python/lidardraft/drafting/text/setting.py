"""What a sentence says of the district that its road lies in, and of how much goes on there."""

from __future__ import annotations

import dataclasses
import re

from lidardraft.drafting.solver.scene_spec import SceneSpec

_DISTRICTS = {
    "roadworks": r"(road ?works|construction( sites?| zones?| work)?|work zones?)",
    "school": r"(schools?|kindergartens?)( zones?| yards?)?",
    "alley": r"(alleys?|alleyways?|back streets?)",
    "industrial": r"(industrial|warehouses?|factory|factories|docks?|harbou?r|business park)( area| estate| zone)?",
    "retail": r"(retail|shopping|supermarkets?|malls?)( area| centre| center| park| street)?",
    "forest": r"(forests?|woods|woodland|wooded)",
    "village": r"(villages?|hamlets?)",
    "residential": r"(residential|suburban|suburbs?|neighbou?rhoods?|housing estate)( area| district)?",
    "country": r"(rural|countryside|country|farms?|farmland|fields)",
    "motorway": r"(motorways?|highways?|freeways?|autobahn|expressways?|interstate)",
    "avenue": r"(avenues?|boulevards?)",
    "urban": r"(downtown|urban|inner city|city|town cent(re|er)|stadium|tall buildings)",
}
_TIMES = r"(night|midnight|sunday|early morning)"
_ACTIVITIES = {
    "empty": r"(empty|deserted)",
    "quiet": rf"(quiet|calm|sleepy|{_TIMES})",
    "busy": r"(busy|crowded|rush hour|heavy traffic|market day|bustling)",
}


def with_setting(spec: SceneSpec, text: str) -> SceneSpec:
    """The spec with the district and the activity that a text speaks of first; their words are understood then."""
    district, activity = _first(_DISTRICTS, text), _first(_ACTIVITIES, text)
    known = re.compile(rf"(({'|'.join([*_DISTRICTS.values(), _TIMES])})\b ?)+")
    left = tuple(part for part in spec.not_understood if not known.fullmatch(part.replace("-", " ")))
    return dataclasses.replace(spec, not_understood=left, district=district, activity=activity)


def _first(table: dict[str, str], text: str) -> str | None:
    found = ((match.start(), name) for name, words in table.items() if (match := re.search(rf"\b{words}\b", text)))
    return min(found, default=(0, None))[1]
