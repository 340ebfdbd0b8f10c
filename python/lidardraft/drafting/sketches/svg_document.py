"""The shapes of an SVG file with what they are called and how they are painted, all in CSS pixels of the page."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from lidardraft.drafting.sketches.svg_geometry import ellipse, length, numbers, transform
from lidardraft.drafting.sketches.svg_path import MOST_COMMANDS, PathReader
from lidardraft.drafting.sketches.svg_style import Style, StyleSheet, names_of
from lidardraft.drafting.sketches.xml_elements import Element, read_xml
from lidardraft.errors import FormatError
from lidardraft.files import named

_MOST_FIGURES = 1_500
_SHAPES = ("rect", "circle", "ellipse", "line", "polyline", "polygon", "path")
_GROUPS = ("g", "a", "switch")
_SILENT = (
    *("defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient", "radialGradient", "filter"),
    *("metadata", "namedview", "title", "desc", "style"),
)
_MOST_IGNORED = 200  # lines
_MOST_USED = 10_000  # elements that are shown by <use>
Piece = tuple[np.ndarray, bool]  # points [N, 2] (right, down), and whether it is closed


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """One shape: its own names, those of the groups around it, the innermost first; its pieces, and the width of its
    stroke in the units of the page."""

    names: tuple[str, ...]
    group_names: tuple[str, ...]
    tag: str
    pieces: list[Piece]
    style: Style
    stroke_width: float

    @property
    def all_names(self) -> tuple[str, ...]:
        """Its own names, then those of its groups."""
        return self.names + self.group_names

    @property
    def where(self) -> str:
        """What messages call it."""
        return f"{self.tag} {self.names[0]!r}" if self.names else f"a {self.tag} without a name"

    def is_line(self, closed: bool) -> bool:
        """Whether a piece is a line and no area: it has no fill, or is open and nobody asked for one."""
        if self.tag == "line" or self.style.fill == "none":
            return True
        return not closed and self.style.fill == "" and self.style.stroke != "none"


@dataclass(slots=True, eq=False)
class Page:
    """All shapes of a file in the order of painting, and what of it is not read."""

    figures: list[Figure] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)
    size: np.ndarray | None = None

    def middle(self) -> np.ndarray:
        """The middle [2] of the page, or of what is on it where its size is not known."""
        if self.size is not None:
            return self.size / 2
        points = [points for figure in self.figures for points, _ in figure.pieces]
        if not points:
            return np.zeros(2)
        every = np.concatenate(points)
        middle: np.ndarray = (every.min(axis=0) + every.max(axis=0)) / 2
        return middle


def read_page(text: str) -> Page:
    """The page that the text of an SVG file is. Raises `FormatError` where it is broken or too much."""
    root = read_xml(text)
    if root.tag != "svg":
        raise FormatError(f"no SVG: its outermost element is {root.tag!r:.60}")
    page = Page()
    page.size, matrix = _page_size(root)
    reader = _Reader(page, root)
    reader.read_children(root, matrix, Style().inside(root, reader.sheet), ())
    return page


def _page_size(root: Element) -> tuple[np.ndarray | None, np.ndarray]:
    """The size [2] of the page in CSS pixels, where it is known, and the matrix [3, 3] that brings its units there."""
    given = [root.attributes.get(name, "").strip() for name in ("width", "height")]
    sizes = [length(text, "width or height") if text and text != "auto" and text[-1] != "%" else None for text in given]
    box = numbers(root.attributes["viewBox"], "viewBox") if "viewBox" in root.attributes else None
    if box is None:
        return (np.array(sizes, dtype=np.float64) if None not in sizes else None), np.eye(3)
    if len(box) != 4 or min(box[2:]) <= 0:
        raise FormatError(f"viewBox is {root.attributes['viewBox']!r:.60}; it must be four numbers, the last two > 0")
    shares = [size / extent for size, extent in zip(sizes, box[2:].tolist(), strict=True) if size]
    share = min(shares, default=1.0)
    size = np.array([size or share * extent for size, extent in zip(sizes, box[2:].tolist(), strict=True)])
    move = size / 2 - share * (box[:2] + box[2:] / 2)  # the box is in the middle of the page, as the default has it
    return size, np.array([[share, 0, move[0]], [0, share, move[1]], [0, 0, 1]])


def _extent(root: Element, size: np.ndarray | None) -> np.ndarray | None:
    """How large [2] the page is in the units of what is on it, where that is known."""
    return numbers(root.attributes["viewBox"], "viewBox")[2:] if "viewBox" in root.attributes else size


class _Reader:
    """Goes through the elements of a page."""

    def __init__(self, page: Page, root: Element) -> None:
        self.page = page
        self.commands = 0
        self.sheet = StyleSheet()
        self.by_id: dict[str, Element] = {}
        self.extent = _extent(root, page.size)
        self.used: list[str] = []  # the ids of the elements that <use> shows now, the outermost first
        self.count_of_used = 0
        waiting = [root]
        while waiting:
            element = waiting.pop()
            self.by_id.setdefault(element.attributes.get("id", ""), element)
            if element.tag == "style":
                self.sheet.add(element.text)
            waiting += reversed(element.children)
        for line in dict.fromkeys(self.sheet.ignored):
            self._ignore(line)

    def read(self, element: Element, matrix: np.ndarray, style: Style, groups: tuple[str, ...]) -> None:
        """Read an element and what is in it, under a matrix [3, 3], in a style, and in groups of these names."""
        names = names_of(element)
        if element.tag in _SILENT:
            return
        if self.used:
            self.count_of_used += 1
            if self.count_of_used > _MOST_USED:
                raise FormatError(f"<use> shows more than {_MOST_USED} elements; up to so many are read")
        if element.tag not in (*_SHAPES, *_GROUPS, "use"):
            self._ignore(f"{element.tag}{f' {names[0]!r}' if names else ''}: not read")
            return
        with named(f"{element.tag} {names[0]!r}" if names else element.tag):
            style = style.inside(element, self.sheet)
            if style.hidden:
                self._ignore(f"{element.tag}{f' {names[0]!r}' if names else ''}: hidden")
                return
            if "transform" in element.attributes:
                matrix = matrix @ transform(element.attributes["transform"])
            if element.tag in _SHAPES:
                self._add(element, matrix, style, names, groups)
        if element.tag == "use":
            self._use(element, matrix, style, names + groups)
        elif element.tag in _GROUPS:
            self.read_children(element, matrix, style, names + groups)

    def read_children(self, element: Element, matrix: np.ndarray, style: Style, groups: tuple[str, ...]) -> None:
        """Read what is in an element."""
        for child in element.children:
            self.read(child, matrix, style, groups)

    def _use(self, element: Element, matrix: np.ndarray, style: Style, groups: tuple[str, ...]) -> None:
        """Read the element that a <use> shows once more, in its place."""
        id = element.attributes.get("href", "").strip().removeprefix("#")
        target = self.by_id.get(id) if id else None
        if target is None or id in self.used:
            self._ignore(f"use of {id!r:.60}: {'it is in itself' if target else 'there is no such shape'}")
            return
        x, y = (length(element.attributes.get(name, "0"), name, self._whole(name)) for name in ("x", "y"))
        matrix = matrix @ np.array([[1, 0, x], [0, 1, y], [0, 0, 1]])
        self.used.append(id)
        if target.tag == "symbol":
            sides = {name: element.attributes[name] for name in ("width", "height") if name in element.attributes}
            _, inner = _page_size(Element("symbol", target.attributes | sides))
            self.read_children(target, matrix @ inner, style.inside(target, self.sheet), names_of(target) + groups)
        else:
            self.read(target, matrix, style, groups)
        self.used.pop()

    def _whole(self, name: str) -> float | None:
        """What a length of an attribute is a percentage of."""
        if self.extent is None:
            return None
        if name in ("x", "cx", "rx", "x1", "x2", "width"):
            return float(self.extent[0])
        if name in ("y", "cy", "ry", "y1", "y2", "height"):
            return float(self.extent[1])
        return math.hypot(*self.extent.tolist()) / math.sqrt(2)

    def _add(
        self, element: Element, matrix: np.ndarray, style: Style, names: tuple[str, ...], groups: tuple[str, ...]
    ) -> None:
        pieces = []
        for points, closed in self._pieces(element):
            if len(points) > 1:
                pieces.append((points @ matrix[:2, :2].T + matrix[:2, 2], closed))
        if not pieces:
            self._ignore(f"{element.tag}{f' {names[0]!r}' if names else ''}: empty")
            return
        if len(self.page.figures) >= _MOST_FIGURES:
            raise FormatError(f"more than {_MOST_FIGURES} shapes; sketches of up to so many are read")
        width = style.stroke_width * math.sqrt(abs(float(np.linalg.det(matrix[:2, :2]))))
        self.page.figures.append(Figure(names, groups, element.tag, pieces, style, width))

    def _pieces(self, element: Element) -> list[Piece]:
        def of(name: str) -> float:
            return length(element.attributes.get(name, "0"), name, self._whole(name))

        match element.tag:
            case "rect":
                x, y, across, down = of("x"), of("y"), of("width"), of("height")
                if across <= 0 or down <= 0:
                    return []
                return [(np.array([(x, y), (x + across, y), (x + across, y + down), (x, y + down)]), True)]
            case "circle":
                return [(ellipse(of("cx"), of("cy"), of("r"), of("r")), True)] if of("r") > 0 else []
            case "ellipse":
                small = min(of("rx"), of("ry")) <= 0
                return [] if small else [(ellipse(of("cx"), of("cy"), of("rx"), of("ry")), True)]
            case "line":
                return [(np.array([(of("x1"), of("y1")), (of("x2"), of("y2"))]), False)]
            case "path":
                reader = PathReader(element.attributes.get("d", ""))
                pieces = reader.pieces()
                self.commands += reader.commands
            case _:
                values = numbers(element.attributes.get("points", ""), "points")
                self.commands += len(values) // 8  # a point costs little beside a curve
                pieces = [(values[: len(values) // 2 * 2].reshape(-1, 2), element.tag == "polygon")]
        if self.commands > MOST_COMMANDS:
            raise FormatError(f"paths of more than {MOST_COMMANDS} commands; sketches of up to so many are read")
        return pieces

    def _ignore(self, line: str) -> None:
        if len(self.page.ignored) < _MOST_IGNORED:
            self.page.ignored.append(line)
