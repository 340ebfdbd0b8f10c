"""XML from others, read within limits: no entities, nothing from outside the text."""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.parsers import expat

from lidardraft.errors import FormatError

MOST_BYTES, MOST_ELEMENTS, DEEPEST, MOST_ATTRIBUTES = 2**24, 50_000, 100, 200
_KNOWN_TYPES = ("http://www.w3.org/", "https://www.w3.org/")  # which older programs name; they are not fetched
_LONGEST_TEXT, _LONGEST_STYLE = 500, 200_000  # characters that are kept of an element, and of a style sheet


@dataclass(slots=True, eq=False)
class Element:
    """A tag without its namespace, attributes whose prefixes are left out too, the text in it, and its children."""

    tag: str
    attributes: dict[str, str]
    text: str = ""
    children: list[Element] = field(default_factory=list)


def read_xml(text: str) -> Element:
    """The outermost element of a text. Raises `FormatError` where it is no XML, or more than the limits allow."""
    if len(text) > MOST_BYTES:
        raise FormatError(f"{len(text)} characters of XML; up to {MOST_BYTES} are read")
    reader = _Reader()
    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.CharacterDataHandler = reader.data
    parser.StartDoctypeDeclHandler = reader.doctype
    parser.EntityDeclHandler = reader.refuse
    try:
        parser.Parse(text.removeprefix("\ufeff").encode("utf-8", "replace"), True)
    except expat.ExpatError as error:
        raise FormatError(f"not XML: {error}") from None
    assert reader.root is not None
    return reader.root


class _Reader:
    def __init__(self) -> None:
        self.root: Element | None = None
        self.open: list[Element] = []
        self.count = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.count += 1
        if self.count > MOST_ELEMENTS or len(self.open) >= DEEPEST or len(attributes) > MOST_ATTRIBUTES:
            limits = f"{MOST_ELEMENTS} elements, {DEEPEST} deep, with {MOST_ATTRIBUTES} attributes each"
            raise FormatError(f"more than {limits}, are not read")
        element = Element(_local(tag), {_local(name): value for name, value in attributes.items()})
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, _tag: str) -> None:
        self.open.pop()

    def data(self, text: str) -> None:
        element = self.open[-1]
        longest = _LONGEST_STYLE if element.tag == "style" else _LONGEST_TEXT
        if len(element.text) < longest:
            element.text += text[:longest]

    def doctype(self, _name: str, system: str | None, _public: str | None, has_subset: int) -> None:
        if has_subset or not (system or _KNOWN_TYPES[0]).startswith(_KNOWN_TYPES):
            raise FormatError("a document type or an entity that is not SVG's own; neither is read")

    def refuse(self, *_: object) -> None:
        raise FormatError("an entity; none is read")


def _local(name: str) -> str:
    return name.rpartition(":")[2]
