from lidardraft.drafting.text.mention import Mention
from lidardraft.drafting.text.mention_parts import is_one_of, lanes_filled, parted
from lidardraft.drafting.text.positions import Position

LEFT, RIGHT = ("", "left"), ("", "right")


def test_one_of_them_is_counted_once() -> None:
    whole = Mention("car", 3, Position(places=(LEFT,)), placed=True)
    part = Mention("car", 1, heading="parked", same_as=whole, of_them=True)
    assert [(one.count, one.at.places) for one in parted([whole, part])] == [(2, (LEFT,)), (1, (LEFT,))]


def test_one_more_is_counted_again() -> None:
    first = Mention("car", 2, Position(places=(LEFT,)), placed=True)
    assert [one.count for one in parted([first, Mention("car", 1, same_as=first)])] == [2, 1]


def test_a_sum_is_no_mention_of_its_own() -> None:
    whole = Mention("vehicle", 3)
    parts = [Mention("car", 2), Mention("bus", 1)]
    wanted = parted([whole, *parts])
    assert wanted == parts
    assert all(is_one_of(part, whole, wanted) for part in parts)


def test_the_others_are_what_is_left() -> None:
    whole = Mention("car", 5)
    others = Mention("car", "some", same_as=whole, of_them=True)
    assert [one.count for one in parted([whole, Mention("car", 1, same_as=whole, of_them=True), others])] == [1, 4]


def test_what_each_has_is_as_many() -> None:
    houses = Mention("house", 4)
    tree = Mention("tree", 2, host=houses)
    assert parted([houses, tree])[1] is tree
    assert (tree.count, tree.relation, tree.references) == (8, "near", [houses])


def test_three_abreast_stand_beside_each_other() -> None:
    bikes = Mention("bicycle", 3, abreast=True)
    wanted = parted([bikes])
    assert [one.count for one in wanted] == [1, 1, 1]
    assert [one.relation for one in wanted] == ["beside", "beside", None]


def test_a_number_at_both_sides_is_shared() -> None:
    for count, each in ((5, [3, 2]), ((10, 20), [(5, 10), (5, 10)]), ("some", ["some"]), (1, [1])):
        trees = Mention("tree", count, Position(places=(LEFT, RIGHT), shared=True))
        assert [one.count for one in parted([trees])] == each


def test_lanes_that_one_each_fills() -> None:
    whole = Mention("car", 3)
    assert lanes_filled([whole, Mention("car", 1, Position(lane="each"), same_as=whole)]) == 3
    assert lanes_filled([whole]) == 0
