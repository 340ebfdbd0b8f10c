import pytest

from lidardraft.drafting.sketches.svg_style import Style, StyleSheet, names_of
from lidardraft.drafting.sketches.xml_elements import Element
from lidardraft.errors import FormatError


def test_attributes_and_style_rules_are_inherited() -> None:
    group = Style().inside(Element("g", {"fill": "none", "stroke": "#102030", "stroke-width": "2mm"}))
    assert (group.fill, group.stroke) == ("none", (16, 32, 48))
    assert group.stroke_width == pytest.approx(7.56, abs=0.01)
    inner = group.inside(Element("path", {"style": " fill: rgb(1, 2, 3); stroke:url(#x) ;opacity:1"}))
    assert (inner.fill, inner.stroke, inner.stroke_width) == ((1, 2, 3), "", group.stroke_width)


@pytest.mark.parametrize("attributes", [{"display": "none"}, {"style": "visibility:hidden"}])
def test_what_is_hidden_stays_so(attributes: dict[str, str]) -> None:
    assert Style().inside(Element("g", attributes)).inside(Element("rect", {"visibility": "visible"})).hidden


def test_a_width_that_is_none() -> None:
    with pytest.raises(FormatError, match="stroke-width is 'thick'"):
        Style().inside(Element("g", {"stroke-width": "thick"}))


def test_names_come_label_first() -> None:
    children = [Element("title", {}, " a bus ")]
    assert names_of(
        Element("rect", {"id": "r1", "class": "big", "label": "red bus", "data-name": "bus 3"}, "", children)
    ) == (
        "red bus",
        "a bus",
        "bus 3",
        "r1",
        "big",
    )


def test_style_sheets_come_between_attributes_and_the_style_of_an_element() -> None:
    sheet = StyleSheet()
    sheet.add("<!-- rect{stroke:blue} .st0, .st1 {fill:none; stroke-width:3px} /* .st1{fill:red} */ #a{fill:lime}-->")
    rect = Element("rect", {"class": "st0 other", "fill": "black"})
    style = Style().inside(rect, sheet)
    assert (style.fill, style.stroke, style.stroke_width) == ("none", (0, 0, 255), 3.0)
    rect.attributes |= {"id": "a"}
    assert Style().inside(rect, sheet).fill == (0, 255, 0)
    rect.attributes |= {"style": "fill:#010203"}
    assert Style().inside(rect, sheet).fill == (1, 2, 3)
    assert sheet.ignored == []


def test_of_endless_attributes_the_begin_counts() -> None:
    """A shape with them may be shown thousands of times by <use>."""
    sheet = StyleSheet()
    sheet.add(".first{fill:red} .last{stroke:blue}")
    rect = Element("rect", {"class": "first" + " x" * 400_000 + " last"})
    assert (Style().inside(rect, sheet).fill, Style().inside(rect, sheet).stroke) == ((255, 0, 0), "")
    rect = Element("rect", {"style": "fill:red" + ";x" * 400_000 + ";stroke:blue"})
    assert (Style().inside(rect).fill, Style().inside(rect).stroke) == ((255, 0, 0), "")


def test_rules_for_more_than_an_element_are_told() -> None:
    sheet = StyleSheet()
    sheet.add(".car rect{fill:red} @media print{.b{fill:red}} .c{color:red} .d{fill:red !important}")
    assert sheet.ignored == ["style rule '.car rect': not read", "style rule '@media print{.b': not read"]
    assert list(sheet.rules) == [".d"]
    assert Style().inside(Element("g", {"class": "d"}), sheet).fill == (255, 0, 0)


@pytest.mark.parametrize("text", ["/*" * 90_000, "{" * 200_000, "," * 200_000 + "{fill:red}", ".a" * 90_000])
def test_a_spoiled_style_sheet_is_read_at_once(text: str) -> None:
    sheet = StyleSheet()
    sheet.add(text)
    assert sheet.rules == {}


def test_of_two_colours_for_light_and_dark_pages_the_light_one_counts() -> None:
    element = Element(
        "rect", {"style": "fill: light-dark(rgb(0, 0, 142), rgb(200, 200, 255)); stroke: light-dark(#fff, #000)"}
    )
    style = Style().inside(element)
    assert (style.fill, style.stroke) == ((0, 0, 142), (255, 255, 255))
