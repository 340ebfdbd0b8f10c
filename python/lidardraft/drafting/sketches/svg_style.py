"""How a shape of an SVG file is painted, by itself and by the groups that it is in, and what it is called."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lidardraft.drafting.sketches.svg_geometry import length
from lidardraft.drafting.sketches.xml_elements import Element

Colour = tuple[int, int, int]
_NAMES = ("label", "id", "class")  # Inkscape's label is the one that its author gave
_LONGEST_NAME = 200


@dataclass(frozen=True, slots=True)
class Style:
    """`fill` and `stroke` are colours, "none", or "" where nothing is said or where it is no plain colour."""

    fill: Colour | str = ""
    stroke: Colour | str = ""
    stroke_width: float = 1.0
    hidden: bool = False

    def inside(self, element: Element) -> Style:
        """The style of an element within what has this style."""
        said = {name: value for name, value in element.attributes.items() if name in _PROPERTIES}
        for rule in element.attributes.get("style", "").split(";"):
            name, _, value = rule.partition(":")
            if name.strip() in _PROPERTIES:
                said[name.strip()] = value
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


_PROPERTIES = ("fill", "stroke", "stroke-width", "display", "visibility")


def names_of(element: Element) -> tuple[str, ...]:
    """What its author called an element: its label, title, id and class."""
    titles = [child.text.strip() for child in element.children if child.tag == "title"]
    given = [element.attributes.get("label", ""), *titles, *(element.attributes.get(name, "") for name in _NAMES[1:])]
    return tuple(name[:_LONGEST_NAME] for name in given if name)


def _paint(text: str) -> Colour | str:
    from PIL import ImageColor

    if text in ("none", "transparent"):
        return "none"
    try:
        return ImageColor.getrgb(text[:40])[:3]
    except ValueError:
        return ""
