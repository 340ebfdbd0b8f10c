import numpy as np
import pytest

from lidardraft.drafting.sketches.svg_document import Page, read_page
from lidardraft.errors import FormatError


def page(inner: str, head: str = 'width="200" height="100"') -> Page:
    return read_page(f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{inner}</svg>')


SHAPES = """
<rect id="a" x="1" y="2" width="3" height="4"/><circle cx="5" cy="6" r="2"/><ellipse cx="5" cy="6" rx="2" ry="1"/>
<line x1="0" y1="0" x2="9" y2="9"/><polyline points="0,0 1,1 2,0"/><polygon points="0,0 1,1 2,0"/><path d="M0 0 L5 5"/>
"""


def test_every_shape_is_found_with_its_pieces() -> None:
    figures = page(SHAPES).figures
    assert [figure.tag for figure in figures] == ["rect", "circle", "ellipse", "line", "polyline", "polygon", "path"]
    assert [figure.pieces[0][1] for figure in figures] == [True, True, True, False, False, True, False]
    np.testing.assert_array_equal(figures[0].pieces[0][0], [(1, 2), (4, 2), (4, 6), (1, 6)])
    assert figures[0].where == "rect 'a'"
    assert figures[1].where == "a circle without a name"


def test_groups_move_and_name_what_is_in_them() -> None:
    inner = (
        '<g id="cars" transform="translate(10 0) scale(2)"><g id="row"><line id="x" x2="5" stroke-width="1"/></g></g>'
    )
    (figure,) = page(inner).figures
    assert (figure.names, figure.group_names) == (("x",), ("row", "cars"))
    np.testing.assert_allclose(figure.pieces[0][0], [(10, 0), (20, 0)])
    assert figure.stroke_width == 2.0


@pytest.mark.parametrize(
    ("head", "end", "middle"),
    [
        ('width="200" height="100"', (10, 20), (100, 50)),
        ('viewBox="0 0 50 50"', (10, 20), (25, 25)),
        ('width="100" height="100" viewBox="0 0 50 50"', (20, 40), (50, 50)),
        ('width="200" height="100" viewBox="0 0 50 50"', (70, 40), (100, 50)),
        ('width="100%" height="100" viewBox="-10 0 50 50"', (40, 40), (50, 50)),
        ('width="1in" height="1in" viewBox="0 0 48 48"', (20, 40), (48, 48)),
    ],
)
def test_units_of_the_page(head: str, end: tuple[float, float], middle: tuple[float, float]) -> None:
    found = page('<line x2="10" y2="20"/>', head)
    np.testing.assert_allclose(found.figures[0].pieces[0][0][1], end)
    np.testing.assert_allclose(found.middle(), middle)


def test_without_a_size_the_middle_is_that_of_what_is_drawn() -> None:
    np.testing.assert_allclose(page('<line x1="4" x2="10" y2="20"/>', "").middle(), (7, 10))


def test_lines_and_areas() -> None:
    cases = {
        '<path d="M0 0 L9 9" stroke="red"/>': True,
        '<path d="M0 0 L9 9 L0 9 Z" fill="none" stroke="red"/>': True,
        '<path d="M0 0 L9 9 L0 9" fill="blue"/>': False,
        '<path d="M0 0 L9 9 L0 9 Z" stroke="red"/>': False,
        '<line x2="9" fill="blue"/>': True,
    }
    for inner, line in cases.items():
        (figure,) = page(inner).figures
        assert figure.is_line(figure.pieces[0][1]) is line, inner


def test_shapes_that_are_used_again_stand_where_they_are_used() -> None:
    found = page(
        '<g id="cars"><rect id="car" width="2" height="4"/>'
        '<use id="second" href="#car" x="10" y="20"/><use href="#car" transform="rotate(90)"/></g>'
        '<symbol id="tree" viewBox="-1 -1 2 2"><circle r="1"/></symbol><use href="#tree" x="50" width="8" height="8"/>'
    )
    assert [figure.tag for figure in found.figures] == ["rect", "rect", "rect", "circle"]
    assert found.figures[1].all_names == ("car", "second", "cars")
    np.testing.assert_allclose(found.figures[1].pieces[0][0][0], (10, 20))
    np.testing.assert_allclose(found.figures[2].pieces[0][0][2], (-4, 2))
    np.testing.assert_allclose(found.figures[3].pieces[0][0].min(axis=0), (50, 0), atol=0.1)
    assert "tree" in found.figures[3].all_names


def test_what_uses_itself_is_told_and_what_uses_very_much_refused() -> None:
    assert page('<g id="a"><use href="#a"/></g>').ignored == ["use of 'a': it is in itself"]
    groups = '<g id="g0"/>' + "".join(f'<g id="g{k + 1}">{f"""<use href="#g{k}"/>""" * 10}</g>' for k in range(9))
    with pytest.raises(FormatError, match="<use> shows more than"):
        page(groups)


@pytest.mark.parametrize("head", ['width="200" height="100"', 'width="100%" height="100%" viewBox="0 0 200 100"'])
def test_percentages_are_those_of_the_page(head: str) -> None:
    (figure,) = page('<rect x="50%" y="10%" width="25%" height="100%"/>', head).figures
    np.testing.assert_allclose(figure.pieces[0][0][[0, 2]], [(100, 10), (150, 110)])


def test_colours_may_be_said_in_a_style_sheet() -> None:
    (figure,) = page('<style>.st0{fill:#00008e}</style><rect class="st0" width="1" height="1"/>').figures
    assert figure.style.fill == (0, 0, 142)


def test_what_is_not_read_is_told_and_what_shows_nothing_is_not() -> None:
    found = page(
        '<defs><rect width="1" height="1"/></defs><script>alert(1)</script><image href="http://a/b.png"/>'
        '<text id="t">x</text>'
        '<use href="#a"/><g display="none" id="h"><rect width="1" height="1"/></g><rect id="e"/>'
    )
    assert found.figures == []
    assert found.ignored == [
        "script: not read",
        "image: not read",
        "text 't': not read",
        "use of 'a': there is no such shape",
        "g 'h': hidden",
        "rect 'e': empty",
    ]


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        ('<rect id="r" width="3x" height="1"/>', "rect 'r': width is '3x'"),
        ('<g id="g" transform="spin(1)"/>', "g 'g': transform is"),
        ('<path d="M 0"/>', "path: path data that cannot be read at character 3"),
        ("<circle r='1'/>" * 1501, "more than 1500 shapes"),
        ('<path d="M0 0' + "l1 1" * 20_000 + '"/>' + '<path d="M0 0' + "l1 1" * 20_000 + '"/>', "30000 commands"),
    ],
)
def test_what_is_wrong_names_the_element(inner: str, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        page(inner)


def test_other_documents_are_refused() -> None:
    with pytest.raises(FormatError, match="its outermost element is 'html'"):
        read_page("<html/>")
    with pytest.raises(FormatError, match="viewBox is '0 0 0 5'"):
        page("", 'viewBox="0 0 0 5"')


def test_a_polygon_of_one_point_shows_nothing() -> None:
    assert page('<polygon id="car" points="1 2 3"/>').ignored == ["polygon 'car': empty"]
