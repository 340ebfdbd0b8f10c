"""Names of modelled objects, materials and collections: which class they name, and which are parts of one object."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from lidardraft.errors import LayoutError, check_type, one_of, printable
from lidardraft.semantics import BY_NAME

# Words that name a class, and some of them its kind too (`objects/kinds.py`). If a name has two, the last one counts
# ("street lamp").
_WORDS = {
    "road": "road street asphalt tarmac lane highway motorway carriageway driveway intersection junction crossroads "
    "crossroad roundabout crosswalk zebra marking markings crossing",
    "sidewalk": "sidewalk pavement footpath footway walkway curb kerb",
    "building": "building shop store school warehouse hut barn facade",
    "building building": "tower skyscraper apartment apartments office church",
    "building house": "house garage shed cottage villa",
    "wall": "wall",
    "fence": "fence railing guardrail barrier gate",
    "pole": "pole post bollard pillar mast pylon",
    "pole street-light": "lamp lamppost streetlight streetlamp",
    "traffic-light": "trafficlight trafficlights stoplight signal semaphore",
    "traffic-sign": "sign signpost signboard trafficsign roadsign stopsign",
    "vegetation": "vegetation plant foliage leaves crown canopy treetop forest",
    "vegetation tree": "tree",
    "vegetation bush": "bush shrub",
    "vegetation hedge": "hedge",
    "terrain": "terrain ground grass lawn soil meadow field earth verge",
    "person": "person pedestrian human man woman child people boy girl walker",
    "rider": "rider cyclist biker motorcyclist bicyclist",
    "car": "vehicle automobile pickup",
    "car car": "car suv taxi sedan hatchback",
    "car van": "van minivan",
    "truck": "truck lorry trailer",
    "bus": "bus coach minibus",
    "train": "train tram trolley locomotive streetcar",
    "motorcycle": "motorcycle motorbike scooter moped",
    "bicycle": "bicycle bike",
    "trunk": "trunk bark",
    "other": "other mailbox hydrant rock bridge",
    "other bench": "bench",
    "other bin": "bin",
    "other cone": "cone",
}
_MEANING = {word: meaning for meaning, words in _WORDS.items() for word in words.split()}
# Pairs of words with another meaning than their last word.
_PAIRS = {
    ("traffic", "light"): "traffic-light",
    ("traffic", "lights"): "traffic-light",
    ("stop", "light"): "traffic-light",
    ("street", "light"): "pole street-light",
    ("bus", "stop"): "other",
    ("bus", "shelter"): "building",
    ("parking", "lot"): "road",
    ("car", "park"): "road",
    ("car", "trunk"): "car",
    ("tree", "top"): "vegetation",
    ("guard", "rail"): "fence",
    ("fire", "hydrant"): "other",
    ("traffic", "cone"): "other cone",
}
# Words for parts, and the words that they add nothing to: the wall of a house is a building.
_PARTS = {"wall": ("building", "house", "garage", "shop", "office", "tower"), "gate": ("house",), "post": ("sign",)}
_MANY = ("people",)  # plurals without -s
_PLURAL = re.compile(r"(?<=[a-z]{2})(?:(?<=ch|sh|ss)es|(?<!s)s)$")
_NUMBERED = re.compile(r"(?<![A-Za-z])([A-Za-z]+)[\d._ -]*\d(?=[._ -]+\D)")  # a word, its number, and more behind
OUTRIGHT = "class:"  # before the class, in a name that says nothing else


def check_classes(classes: Mapping[str, str]) -> None:
    """Raises `LayoutError` if `classes` maps a name to an unknown class."""
    check_type("classes", classes, Mapping)
    for key, value in classes.items():
        if value not in BY_NAME or value == "none":
            raise LayoutError(f"classes[{key!r}] is {value!r}; it must be {one_of(list(BY_NAME)[1:], value)}")


def class_of(names: Iterable[str], classes: Mapping[str, str]) -> str | None:
    """The class of the first name that has one; None if none has.

    `classes` maps whole names, with or without Blender's number suffix, and takes precedence over all words. Next come
    names that state a class outright, "class:car".
    """
    known = list(names)
    for name in known if classes else ():
        for whole in (name, without_number(name)):
            if whole in classes:
                return classes[whole]
    for name in known:
        if name.startswith(OUTRIGHT) and without_number(name).removeprefix(OUTRIGHT) in BY_NAME:
            return without_number(name).removeprefix(OUTRIGHT)
    return next((found for name in known if (found := _class_of_words(name))), None)


def kind_of(names: Iterable[str], label: str) -> str | None:
    """The kind of class `label` in the first of the names that has one; None if none has."""
    meanings = [_meaning(name).partition(" ") for name in names]
    return next((kind for found, _, kind in meanings if found == label and kind), None)


def words_of(name: str) -> list[str]:
    """The words of a name in lower case: "ParkedCar_01.002" is parked and car."""
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", name[:200])
    return re.findall(r"[a-z]+", parted.lower())


def without_number(name: str) -> str:
    """The name without the number that Blender appends to a name in use: "Car.001" is Car."""
    return re.sub(r"\.\d+$", "", name[:500])


def id_of(name: str) -> str:
    """The id of an object with that name. Control characters are spelled out, and a dot before a number becomes "_":
    "Car.001" is another car, not a part of one."""
    return re.sub(r"\.(?=\d+$)", "_", printable(name))


def whole_and_part(name: str) -> tuple[str, str]:
    """The object that a name makes this a part of, and the part; the name itself and "" if there is none: "car_1.body"
    and "car_1_wheel" are parts of car_1.

    "Lane1_Car_a" names another class than a lane, so it is not a part of it; A4 in "car_A4_red" does not number a car.
    """
    numbered = [match for match in _NUMBERED.finditer(name[:200]) if class_of_last_word(match[1])]
    if numbered:
        end = numbered[-1].end()
        label = _class_of_words(name[:end])
        if _class_of_words(name) == label != _class_of_words(name[end:]):
            return name[:end], name[end:].lstrip("._ -")
    whole, *part = re.split(r"\.(?=\D)", name, maxsplit=1)
    return whole, "".join(part)


def says_many(name: str) -> bool:
    """Whether a word of the name is the plural of a class: "Parked cars", "People"."""
    return any(word in _MANY or (word not in _MEANING and _singular(word) in _MEANING) for word in words_of(name))


def class_of_last_word(name: str) -> str | None:
    """The class that the last word of a name gives to one object: "Red car_2" is a car, "Car_body" may be a part."""
    *_, last = words_of(name) or [""]
    return None if last in _MANY else _MEANING.get(last, "").partition(" ")[0] or None


def _class_of_words(name: str) -> str | None:
    return _meaning(name).partition(" ")[0] or None


def _meaning(name: str) -> str:
    """The class that the words of a name mean, then a space and its kind, if any; "" if they mean none."""
    words = [_singular(word) for word in words_of(name)]
    found = ""
    for before, word in zip(["", *words], words, strict=False):
        if (before, word) in _PAIRS:
            found = _PAIRS[before, word]
        elif word in _MEANING and not (found and before in _PARTS.get(word, ())):
            found = _MEANING[word]
    return found


def _singular(word: str) -> str:
    forms = (word, word.removesuffix("es"), word.removesuffix("s"))
    return next((form for form in forms if form in _MEANING), _PLURAL.sub("", word))
