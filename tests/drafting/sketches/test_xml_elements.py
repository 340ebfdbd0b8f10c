import pytest

from lidardraft.drafting.sketches.xml_elements import DEEPEST, MOST_BYTES, MOST_ELEMENTS, read_xml
from lidardraft.errors import FormatError

BOMB = '<!DOCTYPE a [<!ENTITY b "bbbbbbbbbb"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]><a>&c;</a>'


def test_tags_and_attributes_lose_their_prefixes() -> None:
    root = read_xml('\ufeff<?xml version="1.0"?>\r\n<a xmlns:i="u"><i:b i:label="x" id="y">one <c/>two</i:b></a>')
    (b,) = root.children
    assert (root.tag, b.tag, b.attributes, b.text) == ("a", "b", {"label": "x", "id": "y"}, "one two")
    assert [child.tag for child in b.children] == ["c"]


@pytest.mark.parametrize("type", ["a", 'svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/1/svg11.dtd"'])
def test_the_document_type_that_programs_write_is_passed_over(type: str) -> None:
    assert read_xml(f"<!DOCTYPE {type}><a/>").tag == "a"


def test_a_style_sheet_is_kept_whole() -> None:
    sheet = ".st0{fill:red}" * 100
    assert read_xml(f"<a><style>{sheet}</style></a>").children[0].text == sheet


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (BOMB, "a document type or an entity"),
        ('<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', "a document type or an entity"),
        ("<a>" * (DEEPEST + 1), "100 deep"),
        ("<a>" + "<b/>" * MOST_ELEMENTS + "</a>", f"more than {MOST_ELEMENTS} elements"),
        ("<a " + " ".join(f'x{k}="1"' for k in range(201)) + "/>", "200 attributes"),
        ("<a>" + " " * MOST_BYTES + "</a>", "characters of XML"),
        ("", "not XML"),
        ("<a><b></a>", "not XML: mismatched tag"),
        ("<a>&nothing;</a>", "not XML: undefined entity"),
        ("car", "not XML"),
    ],
)
def test_what_is_not_read(text: str, said: str) -> None:
    with pytest.raises(FormatError, match=said):
        read_xml(text)
