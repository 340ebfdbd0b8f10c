import pytest

from lidardraft.drafting.sketches.svg_style import Style, names_of
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
    assert names_of(Element("rect", {"id": "r1", "class": "big", "label": "red bus"}, "", children)) == (
        "red bus",
        "a bus",
        "r1",
        "big",
    )
