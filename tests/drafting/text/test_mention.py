from lidardraft.drafting.text.mention import Mention, keep_away
from lidardraft.drafting.text.positions import Position

LEFT, RIGHT = ("", "left"), ("", "right")


def test_vehicles_along_the_sides_of_a_road_are_parked() -> None:
    assert Mention("car", 2, Position(places=(LEFT, RIGHT), both_sides=True)).group().heading == "parked"
    assert Mention("car", 2, Position(places=(LEFT,))).group().heading is None


def test_what_queues_stands_in_the_ego_lane_with_gaps() -> None:
    queue = Mention("car", 3, in_queue=True).group()
    assert (queue.lane, queue.places, queue.heading) == ("own", ("front",), "with")
    assert queue.spacing is not None
    assert queue.spacing > 5.0


def test_places_are_left_out_of_those_that_a_mention_names_or_of_all() -> None:
    both, anywhere = Mention("tree", "some", Position(places=(LEFT, RIGHT))), Mention("tree", "some")
    for mention in (both, anywhere):
        keep_away(mention, Position(places=(LEFT,)))
    assert both.at.places == (RIGHT,)
    assert anywhere.not_at == [LEFT]
