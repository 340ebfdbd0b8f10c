"""How a shape of an SVG file is painted, by itself and by the groups that it is in, and what it is called."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from lidardraft.drafting.sketches.svg_geometry import length
from lidardraft.drafting.sketches.xml_elements import Element

Colour = tuple[int, int, int]
_NAMES = ("label", "data-name", "id", "class")  # Inkscape's label and Illustrator's name are those that authors gave
_LONGEST_NAME, _LONGEST_ATTRIBUTE = 200, 2000  # characters; a shape may be shown thousands of times


@dataclass(frozen=True, slots=True)
class Style:
    """`fill` and `stroke` are colours, "none", or "" where nothing is said or where it is no plain colour."""

    fill: Colour | str = ""
    stroke: Colour | str = ""
    stroke_width: float = 1.0
    hidden: bool = False

    def inside(self, element: Element, sheet: StyleSheet | None = None) -> Style:
        """The style of an element within what has this style, by its attributes, a style sheet, and its own rules."""
        said = {name: value for name, value in element.attributes.items() if name in _PROPERTIES}
        if sheet is not None:
            said |= sheet.of(element)
        said |= _declarations(_attribute(element, "style"))
        style = self
        for name, value in said.items():
            value = value.strip()
            if name == "fill":
                style = replace(style, fill=_paint(value))
            elif name == "stroke":
                style = replace(style, stroke=_paint(value))
            elif name == "stroke-width":
                style = replace(style, stroke_width=length(value, name))
            elif (name, value) in (("display", "none"), ("visibility", "hidden"), ("visibility", "collapse")):
                style = replace(style, hidden=True)
        return style


@dataclass(slots=True)
class StyleSheet:
    """What the style sheets of a file say of tags, ".classes" and "#ids"; `ignored` are the rules for anything else."""

    rules: dict[str, dict[str, str]] = field(default_factory=dict)
    ignored: list[str] = field(default_factory=list)

    def add(self, text: str) -> None:
        """Add the rules of a sheet; later ones come before earlier ones."""
        first, *others = text.split("/*")
        text = first + "".join(other.partition("*/")[2] for other in others)
        for rule in text.replace("<!--", "").replace("-->", "").split("}"):
            selectors, _, body = rule.rpartition("{")
            said = _declarations(body)
            for selector in map(str.strip, selectors.split(",") if said else ()):
                if _SELECTOR.fullmatch(selector):
                    self.rules.setdefault(selector, {}).update(said)
                else:
                    self.ignored.append(f"style rule {selector!r:.60}: not read")

    def of(self, element: Element) -> dict[str, str]:
        """What the sheets say of an element: an id comes before a class, and that before a tag."""
        said = dict(self.rules.get(element.tag, {}))
        for name in _attribute(element, "class").split():
            said |= self.rules.get(f".{name}", {})
        return said | self.rules.get(f"#{element.attributes.get('id', '')}", {})


_SELECTOR = re.compile(r"[.#]?[\w-]+")
_LIGHT = re.compile(r"light-dark\((.+),[^,()]+(?:\([^()]*\))?\)")  # of draw.io: a colour for light pages, one for dark
_PROPERTIES = ("fill", "stroke", "stroke-width", "display", "visibility")


def _declarations(text: str) -> dict[str, str]:
    """The properties that are read of declarations such as "fill: red; stroke: none"."""
    said = {}
    for rule in text.split(";"):
        name, _, value = rule.partition(":")
        if name.strip() in _PROPERTIES:
            said[name.strip()] = value.replace("!important", "").strip()
    return said


def _attribute(element: Element, name: str) -> str:
    return element.attributes.get(name, "")[:_LONGEST_ATTRIBUTE]


def names_of(element: Element) -> tuple[str, ...]:
    """What its author called an element: its label, title, id and class."""
    titles = [child.text.strip() for child in element.children if child.tag == "title"]
    given = [element.attributes.get("label", ""), *titles, *(element.attributes.get(name, "") for name in _NAMES[1:])]
    return tuple(name[:_LONGEST_NAME] for name in given if name)


def _paint(text: str) -> Colour | str:
    from PIL import ImageColor

    text = text[:200]
    if match := _LIGHT.fullmatch(text):
        text = match[1].strip()
    if text in ("none", "transparent"):
        return "none"
    try:
        return ImageColor.getrgb(text[:40])[:3]
    except ValueError:
        return ""
