from lark import Token

from lidardraft.drafting.text.positions import Position, read_position


def at(*places: tuple[str, str], **fields: object) -> Position:
    return Position(places=places or (("", ""),), **fields)  # type: ignore[arg-type]


def said(*words: tuple[str, str], beside_road: bool = False) -> Position:
    return read_position([Token(type, text) for type, text in words], beside_road=beside_road)


def test_words_that_fit_together_narrow_a_place() -> None:
    assert said(("FRONT", "ahead"), ("LEFT", "left")).places == (("front", "left"),)
    assert said(("FRONT", "ahead"), ("SIDES", "both sides")).places == (("front", "left"), ("front", "right"))


def test_words_that_contradict_each_other_are_alternatives() -> None:
    assert at(("front", "")).narrowed(at(("behind", ""))).places == (("front", ""), ("behind", ""))


def test_lengths_and_surfaces() -> None:
    near = said(("NEAR", "nearby"), ("SIDEWALK", "sidewalk"))
    assert (near.distance, near.sidewalk) == ((8.0, 18.0), True)
    assert said(("SPACING", "every 8 metres")).spacing == 8.0
    assert said(("DISTANCE", "10 to 20 m"), ("BEHIND", "behind")) == at(("behind", ""), distance=(10.0, 20.0))


def test_beside_a_road_is_no_place_beside_the_ego() -> None:
    assert said(("BESIDE", "next to"), beside_road=True) == at(beside_road=True)
    assert said(("BESIDE", "next to")) == at(("beside", ""))


def test_and_or_without() -> None:
    both = at(("front", "")).or_at(at(("behind", "")))
    assert both.places == (("front", ""), ("behind", ""))
    assert both.without(at(("front", ""))).places == (("behind", ""),)
    assert at(("front", "")).without(at(("front", ""))).places == (("front", ""),)
