"""The shapes of an SVG file with their names and paint, all in CSS pixels of the page.

As in the W3C's recommendation "Scalable Vector Graphics 1.1"; points are (right, down).
"""

from __future__ import annotations

import math
import re
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple
from xml.etree.ElementTree import Element, TreeBuilder

import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import ParseError, XMLParser
from PIL import ImageColor
from svgelements import Arc, Close, Curve, Line, Matrix, Move, Path

from lidardraft.errors import FormatError
from lidardraft.files import named

_MOST_CHARACTERS, _MOST_ELEMENTS, _DEEPEST, _MOST_ATTRIBUTES = 2**24, 50_000, 100, 200
_MOST_FIGURES = 1_500
_MOST_USED = 10_000  # elements shown by <use>
_MOST_COMMANDS = 30_000  # of all paths of a file
_MOST_NUMBERS = 7 * _MOST_COMMANDS  # of one path or polygon
_MOST_IGNORED = 200  # lines
_LONGEST_NAME, _LONGEST_ATTRIBUTE, _LONGEST_SHEET = 200, 2_000, 200_000  # characters; <use> repeats a shape
LARGEST = 1e7  # units, the limit of a sketch

_SHAPES = ("rect", "circle", "ellipse", "line", "polyline", "polygon", "path")
_GROUPS = ("g", "a", "switch")
_SILENT = (
    *("defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient", "radialGradient", "filter"),
    *("metadata", "namedview", "title", "desc", "style"),
)
_PAINTS = ("fill", "stroke")
_PROPERTIES = {*_PAINTS, "fill-opacity", "stroke-opacity", "fill-rule", "stroke-width", "font-size"}
_PROPERTIES |= {"display", "opacity", "visibility"}
_NAMES = ("data-name", "id", "class")  # Illustrator's name comes first, and Inkscape's label before it
_SELECTOR = re.compile(r"[.#]?[\w-]+")
_LIGHT = re.compile(r"light-dark\((.+),[^,()]+(?:\([^()]*\))?\)")  # of draw.io: a colour for light pages, one for dark
# Pixels of CSS; an inch has 96.
_PIXELS = {"": 1.0, "px": 1.0, "in": 96.0, "cm": 96 / 2.54, "mm": 96 / 25.4, "pt": 96 / 72, "pc": 16.0, "q": 96 / 101.6}
_EM = 16.0  # pixels, the size of letters if a file does not set it
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([a-zA-Z%]*)\s*")
_NUMBERS = re.compile(_NUMBER)
_TRANSFORMS = {"matrix": (6,), "translate": (1, 2), "scale": (1, 2), "rotate": (1, 3), "skewX": (1,), "skewY": (1,)}
_COMMAND = re.compile("[MmZzLlHhVvCcSsQqTtAa]")
_PLACES = {"Min": 0.0, "Max": 1.0}
_TO_CLOSE = re.compile("[^Zz]*[Zz]?")
_BARE_POINT = re.compile(r"(?<=\d)\.(?!\d)")  # "5." is a number, but not to svgelements
_ARC_STEP, _CURVE_STEPS = math.radians(10), 12

Piece = tuple[np.ndarray, bool]  # points [N, 2], and whether it is closed
Paint = tuple[int, int, int] | str  # "none"; "clear" if invisible; "" if unset, or not a plain colour
Style = dict[str, str]  # properties; those of lengths in pixels


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """One shape: its own names, those of the groups around it, the innermost first; its pieces, their paint, and the
    width of its stroke. Holes follow from the direction of the pieces if `nonzero`, else from their number.
    """

    names: tuple[str, ...]
    group_names: tuple[str, ...]
    tag: str
    pieces: list[Piece]
    fill: Paint
    stroke: Paint
    stroke_width: float
    nonzero: bool

    @property
    def all_names(self) -> tuple[str, ...]:
        """Its own names, then those of its groups."""
        return self.names + self.group_names

    @property
    def where(self) -> str:
        """Its name in messages."""
        return f"{self.tag} {self.names[0]!r}" if self.names else f"a {self.tag} without a name"

    def is_line(self, closed: bool) -> bool:
        """Whether a piece is a line and not an area: it has no fill, or it is open and no fill is set."""
        if self.tag == "line" or self.fill in ("none", "clear"):
            return True
        return not closed and self.fill == "" and self.stroke not in ("none", "clear")


@dataclass(slots=True, eq=False)
class Page:
    """All shapes of a file in the order of painting, and a line for each ignored item."""

    figures: list[Figure] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)
    size: np.ndarray | None = None

    def middle(self) -> np.ndarray:
        """The middle [2] of the page, or of its content if its size is not known."""
        return self.size / 2 if self.size is not None else middle_of(self.figures)


def middle_of(figures: list[Figure]) -> np.ndarray:
    """The middle [2] of the rectangle around figures."""
    points = np.concatenate([points for figure in figures for points, _ in figure.pieces] or [np.zeros((1, 2))])
    middle: np.ndarray = (points.min(axis=0) + points.max(axis=0)) / 2
    return middle


def read_page(text: str) -> Page:
    """The page of the text of an SVG file. Raises `FormatError` if it is broken or exceeds a limit."""
    root = _outermost(text)
    if root.tag != "svg":
        raise FormatError(f"no SVG: its outermost element is {root.tag!r:.60}")
    return _Reader(root).page


class _Tree(TreeBuilder):
    """Builds elements, up to a number of them; tags and attributes lose their namespaces."""

    count = depth = 0

    def start(self, tag: str, attributes: dict[str, str], /) -> Element:
        self.count, self.depth = self.count + 1, self.depth + 1
        if self.count > _MOST_ELEMENTS or self.depth > _DEEPEST or len(attributes) > _MOST_ATTRIBUTES:
            limits = f"{_MOST_ELEMENTS} elements, {_DEEPEST} deep, with {_MOST_ATTRIBUTES} attributes each"
            raise FormatError(f"more XML than is read; that is {limits}")
        return super().start(_local(tag), {_local(name): value for name, value in attributes.items()})

    def end(self, tag: str, /) -> Element:
        self.depth -= 1
        return super().end(_local(tag))


def _local(name: str) -> str:
    return name.rpartition("}")[2]


def _outermost(text: str) -> Element:
    """The outermost element of a text of XML."""
    if len(text) > _MOST_CHARACTERS:
        raise FormatError(f"{len(text)} characters of XML; up to {_MOST_CHARACTERS} are read")
    parser = XMLParser(target=_Tree())
    try:
        parser.feed(text.removeprefix("\ufeff"))
        outermost: Element = parser.close()
    except ParseError as error:
        raise FormatError(f"not XML: {error}") from None
    except DefusedXmlException:
        raise FormatError("XML with an entity, or with something from outside the file; neither is read") from None
    return outermost


def length(text: str, name: str, whole: float | None = None, em: float = _EM) -> float:
    """A length in pixels, such as "12.5", "3mm", "2em" of letters `em` high, or "40%" of a `whole`.

    Raises `FormatError` naming the attribute.
    """
    match = _LENGTH.fullmatch(text[:100])
    if match:
        share = {} if whole is None else {"%": whole / 100}
        unit = (_PIXELS | {"em": em, "ex": em / 2} | share).get(match[2].lower())
        if unit is not None and abs(value := float(match[1]) * unit) < LARGEST:
            return value
    units = ", ".join(filter(None, (*_PIXELS, "em", "ex", "" if whole is None else "%")))
    raise FormatError(f"{name} is {text!r:.60}; it must be a length of up to {LARGEST:g} pixels in {units} or none")


def numbers(text: str, name: str) -> np.ndarray:
    """The numbers of a list, f64 [N]; raises `FormatError` naming the attribute."""
    found = (float(match[0]) for match in islice(_NUMBERS.finditer(text), _MOST_NUMBERS + 1))
    values = np.fromiter(found, np.float64)
    if len(values) > _MOST_NUMBERS:
        raise FormatError(f"{name} has more than {_MOST_NUMBERS} numbers; so many are read")
    if _NUMBERS.sub("", text).strip(", \t\r\n") or not (np.abs(values) < LARGEST).all():
        raise FormatError(f"{name} is {text!r:.60}; it must be a list of numbers of up to {LARGEST:g}")
    return values


def transform(text: str) -> np.ndarray:
    """The matrix [3, 3] of a list of transforms, for columns (right, down, 1)."""
    matrix = Matrix()
    *parts, rest = text.split(")")
    for name, _, inside in (part.strip(", \t\r\n").partition("(") for part in parts):
        values = numbers(inside, "transform").tolist()
        if len(values) not in _TRANSFORMS.get(name.strip(), ()):
            raise FormatError(f"transform is {text!r:.60}; a part of it is not known")
        matrix.pre_cat(Matrix(f"{name}({','.join(map(repr, values))})"))
    if rest.strip():
        raise FormatError(f"transform is {text!r:.60}; a part of it is not known")
    found = np.array([[matrix.a, matrix.c, matrix.e], [matrix.b, matrix.d, matrix.f], [0, 0, 1]])
    if not (np.abs(found) < LARGEST).all():
        raise FormatError(f"transform is {text!r:.60}; it moves too far")
    return found


def path_pieces(data: str) -> tuple[list[Piece], int]:
    """The polylines of path data, and the number of its commands. Raises `FormatError` if the data are invalid."""
    text, letters = _COMMAND.subn(" ", data)
    points: list[list[np.ndarray]] = []
    closed: list[bool] = []
    count = 0
    try:
        if letters > _MOST_COMMANDS or data.lstrip()[:1] not in ("", *"Mm"):
            raise ValueError
        numbers(text, "d")
        for chunk in _TO_CLOSE.findall(_BARE_POINT.sub(".0", data)):  # at each "z" svgelements searches back to the "m"
            x, y = points[-1][0][0] if points else (0.0, 0.0)
            for segment in Path(f"M{x} {y}{chunk}"):
                count += 1
                if isinstance(segment, Move):
                    points.append([np.array([[segment.end.x, segment.end.y]])])
                    closed.append(False)
                elif isinstance(segment, Close):
                    closed[-1] = True
                else:
                    points[-1].append(_flattened(segment))
        pieces = [(np.concatenate(each), end) for each, end in zip(points, closed, strict=True) if len(each) > 1]
        if not all((np.abs(piece) < LARGEST).all() for piece, _ in pieces):
            raise ValueError
    except (ValueError, TypeError, ArithmeticError, AttributeError, LookupError):
        limits = f"up to {_MOST_COMMANDS} commands of SVG 1.1 that reach up to {LARGEST:g} pixels"
        raise FormatError(f"path data are {data!r:.60}; they must be {limits}") from None
    return pieces, count


def _flattened(segment: Line | Curve) -> np.ndarray:
    """Places [N, 2] on a segment of a path, without its start."""
    if isinstance(segment, Line):
        return np.array([[segment.end.x, segment.end.y]])
    steps = max(2, math.ceil(abs(segment.sweep) / _ARC_STEP)) if isinstance(segment, Arc) else _CURVE_STEPS
    with np.errstate(all="ignore"):
        places: np.ndarray = segment.npoint(np.linspace(0.0, 1.0, steps + 1)[1:])
    return places


class _Within(NamedTuple):
    """The context of an element: a matrix [3, 3] to the page, a style, and the names of groups, the innermost first."""

    matrix: np.ndarray
    style: Style
    groups: tuple[str, ...]


class _Reader:
    """Goes through the elements of a page."""

    def __init__(self, root: Element) -> None:
        self.page = Page()
        self.page.size, matrix = _page_size(root)
        self.extent = self.page.size  # of the page in the units of its content
        if "viewBox" in root.attrib:
            self.extent = numbers(root.attrib["viewBox"], "viewBox")[2:]
        self.commands = self.count_of_used = 0
        self.used: list[str] = []  # the ids of the elements inside <use> now, the outermost first
        self.rules: dict[str, Style] = {}  # of style sheets, for tags, ".classes" and "#ids"
        self.by_id: dict[str, Element] = {}
        for element in root.iter():
            self.by_id.setdefault(element.get("id", ""), element)
            if element.tag == "style":
                self._read_sheet((element.text or "")[:_LONGEST_SHEET])
        self.read_children(root, _Within(matrix, self._inside({}, root), ()))

    def _read_sheet(self, text: str) -> None:
        """Add the rules of a style sheet; later ones override earlier ones."""
        first, *others = text.split("/*")
        text = first + "".join(other.partition("*/")[2] for other in others)
        for rule in text.replace("<!--", "").replace("-->", "").split("}"):
            selectors, _, body = rule.rpartition("{")
            said = _declarations(body)
            for selector in dict.fromkeys(map(str.strip, selectors.split(",") if said else ())):
                if _SELECTOR.fullmatch(selector):
                    self.rules.setdefault(selector, {}).update(said)
                else:
                    self._ignore(f"style rule {selector!r:.60}: not read")

    def read(self, element: Element, within: _Within) -> None:
        """Read an element and its content."""
        if element.tag in _SILENT:
            return
        if self.used:
            self.count_of_used += 1
            if self.count_of_used > _MOST_USED:
                raise FormatError(f"<use> shows more than {_MOST_USED} elements; up to so many are read")
        if element.tag not in (*_SHAPES, *_GROUPS, "use"):
            self._ignore(f"{_called(element)}: not read")
            return
        with named(_called(element)):
            matrix, style = within.matrix, self._inside(within.style, element)
            if style.get("display") == "none" or _is_zero(style.get("opacity")):
                self._ignore(f"{_called(element)}: hidden")
                return
            if "transform" in element.attrib:
                matrix = matrix @ transform(element.attrib["transform"])
            if element.tag in _SHAPES:
                self._add(element, _Within(matrix, style, within.groups))
        inner = _Within(matrix, style, _names_of(element) + within.groups)
        if element.tag == "use":
            self._use(element, inner)
        elif element.tag in _GROUPS:
            self.read_children(element, inner)

    def read_children(self, element: Element, within: _Within) -> None:
        """Read the content of an element."""
        for child in element:
            self.read(child, within)

    def _inside(self, style: Style, element: Element) -> Style:
        """The style of an element inside another style: from its attributes, the style sheets, and its own rules."""
        said = {name: value.strip() for name, value in element.attrib.items() if name in _PROPERTIES}
        said |= self.rules.get(element.tag, {})
        for name in element.get("class", "")[:_LONGEST_ATTRIBUTE].split():
            said |= self.rules.get(f".{name}", {})
        said |= self.rules.get(f"#{element.get('id', '')}", {})
        said |= _declarations(element.get("style", "")[:_LONGEST_ATTRIBUTE])
        said = {name: value for name, value in said.items() if value not in ("inherit", "unset")}
        em = _em(style)
        if "font-size" in said:
            with suppress(FormatError):  # a word, such as "medium"
                em = length(said["font-size"], "font-size", em, em)
            said["font-size"] = repr(em)
        if "stroke-width" in said:
            said["stroke-width"] = repr(length(said["stroke-width"], "stroke-width", self._whole("stroke-width"), em))
        return style | said

    def _use(self, element: Element, within: _Within) -> None:
        """Read the element that a <use> shows again, in its place."""
        id = element.get("href", "").strip().removeprefix("#")
        target = self.by_id.get(id) if id else None
        if target is None or id in self.used:
            self._ignore(f"use of {id!r:.60}: {'there is no such shape' if target is None else 'it is in itself'}")
            return
        x, y = (self._length(element, name, within.style) for name in ("x", "y"))
        matrix = within.matrix @ np.array([[1, 0, x], [0, 1, y], [0, 0, 1]])
        self.used.append(id)
        if target.tag == "symbol":
            sides = {name: element.attrib[name] for name in ("width", "height") if name in element.attrib}
            matrix = matrix @ _page_size(Element("symbol", target.attrib | sides))[1]
            style, groups = self._inside(within.style, target), _names_of(target) + within.groups
            self.read_children(target, _Within(matrix, style, groups))
        else:
            self.read(target, within._replace(matrix=matrix))
        self.used.pop()

    def _length(self, element: Element, name: str, style: Style) -> float:
        return length(element.get(name, "0"), name, self._whole(name), _em(style))

    def _whole(self, name: str) -> float | None:
        """The length of which a percentage of an attribute is a part."""
        if self.extent is None:
            return None
        across, down = self.extent.tolist()
        if name in ("x", "cx", "rx", "x1", "x2", "width"):
            return across
        return down if name in ("y", "cy", "ry", "y1", "y2", "height") else math.hypot(across, down) / math.sqrt(2)

    def _add(self, element: Element, within: _Within) -> None:
        matrix, style, groups = within
        fill, stroke = (_paint(style, name) for name in _PAINTS)
        hidden = {fill, stroke} <= {"none", "clear"} or (fill == "clear" and stroke == "")
        if hidden or style.get("visibility") in ("hidden", "collapse"):
            self._ignore(f"{_called(element)}: hidden")
            return
        pieces = [(points, closed) for points, closed in self._pieces(element, style) if len(points) > 1]
        if not pieces:
            self._ignore(f"{_called(element)}: empty")
            return
        if len(self.page.figures) >= _MOST_FIGURES:
            raise FormatError(f"more than {_MOST_FIGURES} shapes; sketches of up to so many are read")
        linear, steps = matrix[:2, :2], np.concatenate([np.diff(points, axis=0) for points, _ in pieces])
        pieces = [(points @ linear.T + matrix[:2, 2], closed) for points, closed in pieces]
        width = float(style.get("stroke-width", "1")) * math.sqrt(area := abs(float(np.linalg.det(linear))))
        if np.abs(linear @ linear.T - area * np.eye(2)).max() > 1e-6 * area > 0:  # a uniform scale
            long, drawn = (float(np.linalg.norm(each, axis=1).sum()) for each in (steps, steps @ linear.T))
            width *= math.sqrt(area) * long / (drawn or 1.0)
        nonzero = style.get("fill-rule") != "evenodd"
        self.page.figures.append(Figure(_names_of(element), groups, element.tag, pieces, fill, stroke, width, nonzero))

    def _pieces(self, element: Element, style: Style) -> list[Piece]:
        def of(*attributes: str) -> list[float]:
            return [self._length(element, name, style) for name in attributes]

        match element.tag:
            case "rect":
                x, y, across, down = of("x", "y", "width", "height")
                corners = np.array([(x, y), (x + across, y), (x + across, y + down), (x, y + down)])
                return [(corners, True)] if min(across, down) > 0 else []
            case "circle" | "ellipse":
                x, y, across, down = of("cx", "cy", *(("r", "r") if element.tag == "circle" else ("rx", "ry")))
                turns = np.linspace(0.0, math.tau, 33)
                outline = np.stack([x + across * np.cos(turns), y + down * np.sin(turns)], axis=1)
                return [(outline, True)] if min(across, down) > 0 else []
            case "line":
                return [(np.array(of("x1", "y1", "x2", "y2")).reshape(2, 2), False)]
            case "path":
                pieces, count = path_pieces(element.get("d", ""))
            case _:
                values = numbers(element.get("points", ""), "points")
                count = len(values) // 8  # a point costs little compared with a curve
                pieces = [(values[: len(values) // 2 * 2].reshape(-1, 2), element.tag == "polygon")]
        self.commands += count
        if self.commands > _MOST_COMMANDS:
            raise FormatError(f"paths of more than {_MOST_COMMANDS} commands; sketches of up to so many are read")
        return pieces

    def _ignore(self, line: str) -> None:
        if len(self.page.ignored) < _MOST_IGNORED:
            self.page.ignored.append(line)


def _page_size(root: Element) -> tuple[np.ndarray | None, np.ndarray]:
    """The size [2] of the page in CSS pixels, None if unknown, and the matrix [3, 3] that converts its units to
    them."""
    given = [root.get(name, "").strip() for name in ("width", "height")]
    sizes = [length(text, "width or height") if text and text != "auto" and text[-1] != "%" else None for text in given]
    if "viewBox" not in root.attrib:
        return (np.array(sizes, dtype=np.float64) if None not in sizes else None), np.eye(3)
    box = numbers(root.attrib["viewBox"], "viewBox")
    if len(box) != 4 or min(box[2:]) <= 0:
        raise FormatError(f"viewBox is {root.attrib['viewBox']!r:.60}; it must be four numbers, the last two > 0")
    shares = [size / extent for size, extent in zip(sizes, box[2:].tolist(), strict=True) if size]
    said = root.get("preserveAspectRatio", "")
    share = np.full(2, (max if "slice" in said else min)(shares, default=1.0))
    if "none" in said and len(shares) == 2:
        share = np.array(shares)
    size = np.array([given or each for given, each in zip(sizes, share * box[2:], strict=True)])
    # the place of the box on a page of other proportions, as shares of the excess; centred by default
    place = np.array([next((at for word, at in _PLACES.items() if axis + word in said), 0.5) for axis in "xY"])
    move = size * place - share * (box[:2] + place * box[2:])
    return size, np.array([[share[0], 0, move[0]], [0, share[1], move[1]], [0, 0, 1]])


def _names_of(element: Element) -> tuple[str, ...]:
    """The author's names for an element: its label, title, Illustrator's name, id and class."""
    titles = [(child.text or "").strip() for child in element if child.tag == "title"]
    given = [element.get("label", ""), *titles, *(element.get(name, "") for name in _NAMES)]
    return tuple(name[:_LONGEST_NAME] for name in given if name)


def _called(element: Element) -> str:
    """The name of an element in messages."""
    return " ".join([element.tag, *(repr(name) for name in _names_of(element)[:1])])


def _declarations(text: str) -> Style:
    """The properties that are used, from declarations such as "fill: red; stroke: none"."""
    said = {}
    for rule in text.split(";"):
        name, _, value = rule.partition(":")
        if name.strip() in _PROPERTIES:
            said[name.strip()] = value.replace("!important", "").strip()
    return said


def _em(style: Style) -> float:
    """The height of letters [pixels]."""
    return float(style.get("font-size", _EM))


def _is_zero(opacity: str | None) -> bool:
    match = _LENGTH.fullmatch((opacity or "1")[:100])
    return match is not None and float(match[1]) <= 0


def _paint(style: Style, name: str) -> Paint:
    """The fill or the stroke of a style."""
    text = style.get(name, "")[:200]
    if match := _LIGHT.fullmatch(text):
        text = match[1].strip()
    if text == "none":
        return text
    if text == "transparent" or _is_zero(style.get(f"{name}-opacity")):
        return "clear"
    try:
        red, green, blue, *alpha = ImageColor.getrgb(text[:40])
    except ValueError:
        return ""
    return "clear" if alpha == [0] else (red, green, blue)
