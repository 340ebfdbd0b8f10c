"""Files of named shapes: what of SVG is read, what is refused, and which blobs and strokes the shapes are."""

import math
import time

import numpy as np
import pytest

from lidardraft.drafting.sketch.figures import read_svg
from lidardraft.drafting.sketch.shapes import Blob, Sketch, Stroke
from lidardraft.drafting.sketch.svg import Figure, Page, length, path_pieces, read_page, transform
from lidardraft.errors import FormatError, LayoutError

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="i" xmlns:xlink="http://www.w3.org/1999/xlink"'
SCALE = '<line id="scale-10m" x1="0" y1="195" x2="20" y2="195"/>'  # half a metre a unit


def page(inner: str, head: str = 'width="200" height="100"') -> Page:
    return read_page(f"{HEAD} {head}>{inner}</svg>")


def only_figure(inner: str) -> Figure:
    (figure,) = page(inner).figures
    return figure


def sketch(inner: str, metres: float | None = None) -> Sketch:
    return read_svg(f'{HEAD} width="200" height="200">{inner}{"" if metres else SCALE}</svg>', metres)


def only_blob(inner: str) -> Blob:
    (blob,) = sketch(inner).blobs
    return blob


def only_stroke(inner: str) -> Stroke:
    (stroke,) = sketch(inner).strokes
    return stroke


# XML


@pytest.mark.parametrize("type", ["svg", 'svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/1/svg11.dtd"'])
def test_a_document_type_is_passed_over_and_never_fetched(type: str) -> None:
    assert read_page(f'\ufeff<?xml version="1.0" encoding="latin-1"?>\r\n<!DOCTYPE {type}><svg/>').figures == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('<!DOCTYPE svg [<!ENTITY b "bb"><!ENTITY c "&b;&b;&b;&b;">]><svg>&c;</svg>', "XML with an entity"),
        ('<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]><svg>&x;</svg>', "XML with an entity"),
        ("<svg>" + "<g>" * 100, "more XML than is read; that is 50000 elements, 100 deep"),
        ("<svg>" + "<g/>" * 50_000 + "</svg>", "50000 elements"),
        ("<svg " + " ".join(f'x{k}="1"' for k in range(201)) + "/>", "200 attributes"),
        ("<svg>" + " " * 2**24 + "</svg>", "characters of XML"),
        ("", "not XML"),
        ("<svg><g></svg>", "not XML: mismatched tag"),
        ("<svg>&nothing;</svg>", "not XML: undefined entity"),
        ("car", "not XML"),
        ("<html/>", "its outermost element is 'html'"),
        ('<svg viewBox="0 0 0 5"/>', "viewBox is '0 0 0 5'"),
    ],
)
def test_documents_that_are_not_read(text: str, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        read_page(text)


# Numbers


@pytest.mark.parametrize(
    ("text", "pixels"),
    [
        *(("12.5", 12.5), (" -3px ", -3), ("25.4mm", 96), ("1in", 96), ("1e1", 10), (".5cm", 18.9), ("4q", 3.78)),
        *(("40%", 20), ("2em", 40), ("1ex", 10)),
    ],
)
def test_lengths(text: str, pixels: float) -> None:
    assert length(text, "x", 50.0, 20.0) == pytest.approx(pixels, rel=1e-3)


@pytest.mark.parametrize("text", ["", "50%", "3 m", "nan", "1e99", "2vw", "--1", "9e6in", "9" * 400, "1e308%", "1e9%"])
def test_what_is_no_length(text: str) -> None:
    for whole in (200.0, None) if text != "50%" else (None,):
        with pytest.raises(FormatError, match=r"x is .*; it must be a length of up to 1e\+07 pixels"):
            length(text, "x", whole)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("translate(10)", (12, 1)),
        ("scale(2)", (4, 2)),
        ("rotate(90 2 0)", (1, 0)),
        ("skewY(45)", (2, 3)),
        ("translate(10,0) scale(2)", (14, 2)),
        ("scale(2),translate(10 0)", (24, 2)),
        ("", (2, 1)),
    ],
)
def test_transforms(text: str, place: tuple[float, float]) -> None:
    np.testing.assert_allclose((transform(text) @ (2, 1, 1))[:2], place, atol=1e-9)


@pytest.mark.parametrize(
    "text",
    ["spin(3)", "rotate(1 2)", "scale()", "matrix(1 2 3)", "translate(1", "translate(1e300)", "scale(1e6) scale(1e6)"],
)
def test_transforms_that_are_none(text: str) -> None:
    with pytest.raises(FormatError, match="transform is "):
        transform(text)


# Paths


def pieces(data: str) -> list[tuple[list[list[float]], bool]]:
    return [(np.round(points, 6).tolist(), closed) for points, closed in path_pieces(data)[0]]


@pytest.mark.parametrize(
    ("data", "points"),
    [
        ("M1 2 L3 4", [[1, 2], [3, 4]]),
        ("m1,2 3,4", [[1, 2], [4, 6]]),
        ("M1 2 3 4 5 6", [[1, 2], [3, 4], [5, 6]]),
        ("M0 0H5V3h-1v-1", [[0, 0], [5, 0], [5, 3], [4, 3], [4, 2]]),
        ("M0-1L.5.5", [[0, -1], [0.5, 0.5]]),
        ("M5.,2. 3.e0.5", [[5, 2], [3, 0.5]]),
    ],
)
def test_lines_of_paths(data: str, points: list[list[float]]) -> None:
    assert pieces(data) == [(points, False)]


def test_pieces_are_closed_and_go_on_where_they_began() -> None:
    assert pieces("M2 0 L4 0 L4 3 Z L1 1 M9 9 l1 0 z m1 1 l1 0") == [
        ([[2, 0], [4, 0], [4, 3]], True),
        ([[2, 0], [1, 1]], False),
        ([[9, 9], [10, 9]], True),
        ([[10, 10], [11, 10]], False),
    ]
    assert pieces(" ") == pieces("M1 1") == []


def test_curves_go_through_their_ends_and_mirror_their_controls() -> None:
    curve = path_pieces("M0 0 C0 10 10 10 10 0")[0][0][0]
    t = np.linspace(0, 1, len(curve))[:, None]
    np.testing.assert_allclose(curve, 3 * t * (1 - t) ** 2 * (0, 10) + 3 * t**2 * (1 - t) * (10, 10) + t**3 * (10, 0))
    for short, long in (("S10 -5 10 0", "C5 -5 10 -5 10 0"), ("t10 0", "q5 -5 10 0")):
        begin = "C0 5 5 5 5 0" if short[0] == "S" else "q5 5 10 0"
        assert pieces(f"M0 0 {begin} {short}") == pieces(f"M0 0 {begin} {long}")


@pytest.mark.parametrize("large", [0, 1])
@pytest.mark.parametrize("sweep", [0, 1])
def test_arcs_lie_on_their_circle(large: int, sweep: int) -> None:
    ((points, _),), _ = path_pieces(f"M10 0 A10 10 0 {large}{sweep}0 10")
    np.testing.assert_allclose(points[-1], (0, 10), atol=1e-9)
    center = np.array([0.0, 0.0] if large != sweep else [10.0, 10.0])
    np.testing.assert_allclose(np.linalg.norm(points - center, axis=1), 10, atol=1e-9)
    assert (len(points) > 20) == bool(large)


@pytest.mark.parametrize(
    "data",
    [
        *(
            "L1 2",
            "M1",
            "M1 2 b3",
            "M1 2 L",
            "M1 2 Z 3",
            "M1 2 A1 1 0 2 0 3 3",
            "M1e99 0",
            "é",
            "M0 0 H",
            "M0 0L nan 1",
        ),
        *("M0 0" + "l9999999 0" * 3, "M0 0 A1e6 1e-300 30 1 0 5 5", "M0 0" + "z" * 40_000),
    ],
)
def test_path_data_that_cannot_be_read(data: str) -> None:
    with pytest.raises(FormatError, match="path data are "):
        path_pieces(data)


def test_a_path_of_very_many_pieces_is_read_at_once() -> None:
    begun = time.process_time()
    assert len(path_pieces("M0 0" + "l1 1z" * 14_000)[0]) == 14_000
    assert time.process_time() - begun < 5  # svgelements by itself takes half a minute


# Styles


@pytest.mark.parametrize(
    ("inner", "fill", "stroke"),
    [
        ('<rect style=" fill: rgb(1, 2, 3); stroke:url(#x) ;opacity:1"/>', (1, 2, 3), ""),
        ('<rect style="fill: light-dark(rgb(0, 0, 142), #ccf); stroke: #fff"/>', (0, 0, 142), (255, 255, 255)),
        ('<rect class="st0 other" fill="black"/>', "none", (0, 0, 255)),
        ('<rect class="st0" id="a"/>', (0, 255, 0), (0, 0, 255)),
        ('<rect class="st0" id="a" style="fill:#010203"/>', (1, 2, 3), (0, 0, 255)),
        ('<rect class="d"/>', (255, 0, 0), (0, 0, 255)),
        ('<g fill="red"><rect style="fill:inherit" fill="lime" stroke="unset"/></g>', (255, 0, 0), (0, 0, 255)),
        ('<rect fill="#fff0" stroke-opacity="50%"/>', "clear", (0, 0, 255)),
    ],
)
def test_styles_come_from_groups_attributes_sheets_and_elements(inner: str, fill: object, stroke: object) -> None:
    sheet = (
        "<!-- rect{stroke:blue} .st0, .st1 {fill:none; stroke-width:3px} /* .st1{fill:red} */ #a{fill:lime}-->"
        ".d{fill:red !important}"
    )
    figure = only_figure(f"<style><![CDATA[{sheet}]]></style>" + inner.replace("<rect", '<rect width="9" height="9"'))
    assert (figure.fill, figure.stroke) == (fill, stroke)


@pytest.mark.parametrize(
    ("inner", "width"),
    [
        ('<g stroke-width="2mm"><line x2="9"/></g>', 7.56),
        ('<g stroke-width="3"><line x2="9" stroke-width="inherit"/></g>', 3),
        ('<line x2="9" stroke-width="1%"/>', 1.58),  # of the mean diagonal of 200 x 100
        ('<g font-size="20"><line x2="9" style="font-size:50%; stroke-width:.5em"/></g>', 5),
        ('<g style="font-size:2em"><line x2="9" style="font-size:medium" stroke-width="1ex"/></g>', 16),
        ('<g stroke-width="1em"><line x2="9" font-size="99"/></g>', 16),
        ('<g transform="scale(2)"><line x2="9"/></g>', 2),
    ],
)
def test_widths_of_strokes(inner: str, width: float) -> None:
    assert only_figure(inner).stroke_width == pytest.approx(width, abs=0.01)


@pytest.mark.parametrize(
    "style",
    [
        *("display:none", "visibility:hidden", "visibility:collapse", "opacity:0", "opacity: 0%", "fill-opacity:0"),
        *("fill:none;stroke:none", "fill:transparent", "fill:#12345600;stroke-opacity:0", "fill:none; stroke:#0000"),
    ],
)
def test_what_does_not_show_is_not_read(style: str) -> None:
    shape = '<rect id="car" width="9" height="9"/>'
    for inner in (f'<g style="{style}">{shape}</g>', shape.replace("<rect", f'<rect style="{style}"')):
        found = page(inner)
        assert found.figures == []
        assert len(found.ignored) == 1
        assert found.ignored[0].endswith(": hidden")


def test_in_a_group_that_is_not_visible_a_shape_may_be_visible() -> None:
    shapes = '<rect visibility="visible" width="9" height="9"/><rect width="9" height="9"/>'
    assert len(page(f'<g visibility="hidden">{shapes}</g>').figures) == 1
    assert page(f'<g display="none">{shapes}</g>').figures == []


def test_of_endless_attributes_the_begin_counts() -> None:
    """A shape with them may be shown thousands of times by <use>."""
    sheet = "<style>.first{fill:red} .last{stroke:blue}</style>"
    for attribute in (f'class="first{" x" * 400_000} last"', f'style="fill:red{";x" * 400_000};stroke:blue"'):
        figure = only_figure(f'{sheet}<rect {attribute} width="9" height="9"/>')
        assert (figure.fill, figure.stroke) == ((255, 0, 0), "")


def test_rules_for_more_than_an_element_are_told() -> None:
    sheet = ".car rect{fill:red} @media print{.b{fill:red}} .c{color:red} .d{fill:red !important}"
    assert page(f"<style>{sheet}</style>").ignored == [
        "style rule '.car rect': not read",
        "style rule '@media print{.b': not read",
    ]


@pytest.mark.parametrize("text", ["/*" * 90_000, "{" * 200_000, "," * 200_000 + "{fill:red}", ".a" * 90_000])
def test_a_spoiled_style_sheet_is_read_at_once(text: str) -> None:
    assert only_figure(f'<style>{text}</style><rect class="a" width="1" height="1"/>').fill == ""


# Shapes


def test_every_shape_is_found_with_its_pieces() -> None:
    figures = page(
        '<rect id="a" x="1" y="2" width="3" height="4"/><circle cx="5" cy="6" r="2"/>'
        '<ellipse cx="5" cy="6" rx="2" ry="1"/><line x2="9" y2="9"/><polyline points="0,0 1,1 2,0"/>'
        '<polygon points="0,0 1,1 2,0"/><path d="M0 0 L5 5"/>'
    ).figures
    assert [figure.tag for figure in figures] == ["rect", "circle", "ellipse", "line", "polyline", "polygon", "path"]
    assert [figure.pieces[0][1] for figure in figures] == [True, True, True, False, False, True, False]
    np.testing.assert_array_equal(figures[0].pieces[0][0], [(1, 2), (4, 2), (4, 6), (1, 6)])
    np.testing.assert_allclose((((figures[2].pieces[0][0] - (5, 6)) / (2, 1)) ** 2).sum(axis=1), 1)
    assert figures[0].where == "rect 'a'"
    assert figures[1].where == "a circle without a name"


def test_groups_move_and_name_what_is_in_them() -> None:
    names = 'id="r1" class="big" inkscape:label="red bus" data-name="bus 3"'
    line = f'<line {names} x2="5"><title> a bus </title></line>'
    figure = only_figure(f'<g id="cars" transform="translate(10 0) scale(2)"><g id="row">{line}</g></g>')
    assert figure.names == ("red bus", "a bus", "bus 3", "r1", "big")
    assert figure.group_names == ("row", "cars")
    np.testing.assert_allclose(figure.pieces[0][0], [(10, 0), (20, 0)])


@pytest.mark.parametrize(
    ("head", "end", "middle"),
    [
        ('width="200" height="100"', (10, 20), (100, 50)),
        ('viewBox="0 0 50 50"', (10, 20), (25, 25)),
        ('width="100" height="100" viewBox="0 0 50 50"', (20, 40), (50, 50)),
        ('width="200" height="100" viewBox="0 0 50 50"', (70, 40), (100, 50)),
        ('width="100%" height="100" viewBox="-10 0 50 50"', (40, 40), (50, 50)),
        ('width="1in" height="6em" viewBox="0 0 48 48"', (20, 40), (48, 48)),
        ("", (10, 20), (5, 10)),  # of what is drawn
    ],
)
def test_units_of_the_page(head: str, end: tuple[float, float], middle: tuple[float, float]) -> None:
    found = page('<line x2="10" y2="20"/>', head)
    np.testing.assert_allclose(found.figures[0].pieces[0][0][1], end)
    np.testing.assert_allclose(found.middle(), middle)


@pytest.mark.parametrize("head", ['width="200" height="100"', 'width="100%" height="100%" viewBox="0 0 200 100"'])
def test_percentages_are_those_of_the_page(head: str) -> None:
    (figure,) = page('<rect x="50%" y="10%" width="25%" height="100%"/>', head).figures
    np.testing.assert_allclose(figure.pieces[0][0][[0, 2]], [(100, 10), (150, 110)])


@pytest.mark.parametrize(
    ("inner", "line"),
    [
        ('<path d="M0 0 L9 9" stroke="red"/>', True),
        ('<path d="M0 0 L9 9 L0 9 Z" fill="none" stroke="red"/>', True),
        ('<path d="M0 0 L9 9 L0 9 Z" fill-opacity="0" stroke="red"/>', True),
        ('<path d="M0 0 L9 9 L0 9" fill="blue"/>', False),
        ('<path d="M0 0 L9 9 L0 9" stroke-opacity="0"/>', False),
        ('<path d="M0 0 L9 9 L0 9 Z" stroke="red"/>', False),
        ('<line x2="9" fill="blue"/>', True),
    ],
)
def test_lines_and_areas(inner: str, line: bool) -> None:
    figure = only_figure(inner)
    assert figure.is_line(figure.pieces[0][1]) is line


def test_shapes_that_are_used_again_stand_where_they_are_used() -> None:
    found = page(
        '<g id="cars"><rect id="car" width="2" height="4"/>'
        '<use id="second" xlink:href="#car" x="10" y="20"/><use href="#car" transform="rotate(90)"/></g>'
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


def test_what_is_not_read_is_told_and_what_shows_nothing_is_not() -> None:
    found = page(
        '<defs><rect width="1" height="1"/></defs><script>alert(1)</script><image href="http://a/b.png"/>'
        '<text id="t">x</text><use href="#a"/><rect id="e"/><polygon id="car" points="1 2 3"/>'
    )
    assert found.figures == []
    assert found.ignored == [
        *("script: not read", "image: not read", "text 't': not read", "use of 'a': there is no such shape"),
        *("rect 'e': empty", "polygon 'car': empty"),
    ]


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        ('<rect id="r" width="3x" height="1"/>', "rect 'r': width is '3x'"),
        ('<g stroke-width="thick"/>', "g: stroke-width is 'thick'"),
        ('<g id="g" transform="spin(1)"/>', "g 'g': transform is"),
        ('<path d="M 0"/>', "path: path data are 'M 0'; they must be up to 30000 commands"),
        ("<circle r='1'/>" * 1501, "more than 1500 shapes"),
        (f'<path d="M0 0{"l1 1" * 20_000}"/>' * 2, "paths of more than 30000 commands"),
        ('<path d="M0 0' + "c1 1 2 2 3 3" * 300_000 + '"/>', "path data are .* up to 30000 commands"),
    ],
)
def test_what_is_wrong_names_the_element(inner: str, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        page(inner)


# Blobs and strokes


def test_a_named_rectangle_is_an_object_in_its_place() -> None:
    car = only_blob('<rect id="car-7" x="96" y="50" width="4" height="9" transform="rotate(-30 98 54.5)"/>')
    assert (car.label, car.names, car.where, car.points) == ("car", ("car-7",), "rect 'car-7'", False)
    np.testing.assert_allclose(car.center, (22.75, 1.0), atol=0.03)
    assert (car.length, car.width) == pytest.approx((4.5, 2.0), abs=0.03)
    assert math.remainder(car.yaw - math.radians(30), math.pi) == pytest.approx(0, abs=0.01)


def test_a_line_of_a_car_says_where_its_front_is() -> None:
    car = only_blob('<line class="car" x1="100" y1="60" x2="100" y2="69" stroke="blue" stroke-width="4"/>')
    assert car.points
    assert car.yaw == pytest.approx(math.pi)
    assert (car.length, car.width) == (4.5, 2.0)


def test_strokes_are_lines_with_a_width() -> None:
    road = only_stroke('<path id="street" d="M100 200 V0" stroke-width="14" stroke="gray"/>')
    assert (road.label, road.width, road.closed) == ("road", 7.0, False)
    np.testing.assert_allclose(road.line, [(-50, 0), (50, 0)])
    fence = only_stroke('<path id="fence" d="M0 0 h50 v50 z" fill="none" stroke="gray"/>')
    assert fence.closed
    np.testing.assert_allclose(fence.line[0], fence.line[-1])


def test_a_filled_area_of_a_road_is_its_stroke() -> None:
    road = only_stroke('<rect id="road" x="93" y="0" width="14" height="200"/>')
    assert road.width == pytest.approx(7, abs=0.15)
    assert np.ptp(road.line[:, 0]) == pytest.approx(100, abs=1.2)


@pytest.mark.parametrize(
    ("inner", "rule", "hole"), [("1 -", "nonzero", True), ("0 ", "nonzero", False), ("0 ", "evenodd", True)]
)
def test_a_hole_runs_the_other_way_or_counts_as_even(inner: str, rule: str, hole: bool) -> None:
    d = f"M100 40 a60 60 0 1 0 .01 0 z M100 56 a44 44 0 1 {inner}.01 0 z"
    found = sketch(f'<path id="roundabout" fill-rule="{rule}" d="{d}"/>')
    assert (len(found.strokes), len(found.blobs)) == ((1, 0) if hole else (0, 1))
    if hole:
        assert found.strokes[0].closed
        assert found.strokes[0].width == pytest.approx(8, abs=0.3)


def test_a_star_that_crosses_itself_is_filled_in_its_middle() -> None:
    turns = 4 * math.pi / 5 * np.arange(5)
    points = " ".join(f"{100 + 60 * math.cos(t):.3f},{100 + 60 * math.sin(t):.3f}" for t in turns)
    star = f'<polygon id="trees" points="{points}" fill-rule='
    one, other = (sketch(f"{star}{rule}/>") for rule in ('"nonzero"', '"evenodd"'))
    (blob,) = one.blobs
    np.testing.assert_allclose(blob.center, 0.0, atol=0.3)
    assert other.strokes  # around the middle


@pytest.mark.parametrize("others", [0, 200])
@pytest.mark.parametrize("width", [0.1, 0.4, 1.5])
def test_a_filled_wall_is_as_wide_as_drawn_however_much_else_there_is(width: float, others: int) -> None:
    """A thin one used to fall apart where many shapes shared the pixels of the masks."""
    wall = f'<rect id="wall" x="30" y="40" width="120" height="{width}" transform="rotate(20)"/>'
    found = sketch(wall + '<circle class="tree" cx="9" cy="150" r="2"/>' * others)
    (stroke,) = found.strokes
    assert stroke.width == pytest.approx(width / 2, abs=0.06)
    assert np.linalg.norm(stroke.line[-1] - stroke.line[0]) == pytest.approx(60, abs=0.5)


def test_names_of_groups_and_colours_say_the_class_where_the_shape_does_not() -> None:
    inner = (
        '<g id="trees"><circle id="c1" cx="50" cy="50" r="4" fill="rgb(0,0,142)"/></g>'
        '<circle cx="80" cy="50" r="4" fill="#00008e"/><circle id="odd" cx="90" cy="50" r="4" fill="orange"/>'
        '<g id="roads"><g id="lane markings"><line id="l1" x2="90" stroke="white"/></g></g>'
    )
    found = sketch(inner)
    assert [blob.label for blob in found.blobs] == ["vegetation", "car"]
    assert found.ignored == [
        "circle 'odd': neither its name nor its colour gives a class",
        "line 'l1': markings are not read",
    ]
    assert not found.strokes


def test_the_ego_vehicle_and_the_scale() -> None:
    found = sketch('<g id="ego"><circle cx="100" cy="150" r="3"/></g><circle class="tree" cx="100" cy="130" r="4"/>')
    assert found.ego_marked
    assert found.metres_per_unit == 0.5
    np.testing.assert_allclose(found.blobs[0].center, (10, 0), atol=0.03)
    found = sketch('<circle class="tree" cx="100" cy="80" r="4"/>' + SCALE, metres=0.2)
    assert (found.metres_per_unit, found.ego_marked) == (0.2, False)
    np.testing.assert_allclose(found.blobs[0].center, (4, 0), atol=0.02)
    assert found.ignored == ["the scale bar: the scale is given in metres per pixel"]


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        ('<rect id="car" width="3" height="3"/>', 'name a line of it "scale 10 m"'),
        ('<circle id="scale 0 m" r="4"/>', "a scale of 0.0 m"),
        ('<line id="scale 5 m"/>', "that is 0.0 units long"),
        ('<line id="scale 10 m" x2="0.01"/><rect id="car" width="30" height="30"/>', "reaches further than 2000 m"),
        (f'<path id="car" d="{"M0 0h1v1h-1z" * 2000}"/><line id="scale 9 m" x2="9"/>', "more than 1500 shapes"),
    ],
)
def test_sketches_that_cannot_be(inner: str, said: str) -> None:
    with pytest.raises((LayoutError, FormatError), match=said):
        read_svg(f'<svg width="200" height="200">{inner}</svg>', None)
