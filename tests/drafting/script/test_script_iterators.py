import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "g = (x * x for x in range(4))\nassert next(g) == 0 and next(g) == 1 and list(g) == [4, 9] and list(g) == []",
        "assert next((x for x in [1, 2, 3] if x > 1), None) == 2 and next((x for x in [] if x), 'none') == 'none'",
        "i = iter([1, 2])\nassert next(i) == 1 and sum(i) == 2",
        "assert sorted(x for x in (3, 1, 2)) == [1, 2, 3] and ''.join(c for c in 'ab') == 'ab'",
        "i = iter([1, 2, 3, 4])\nassert list(zip(i, i)) == [(1, 2), (3, 4)]",
        "i = iter([1, 2, 3])\nassert list(zip(range(2), i)) == [(0, 1), (1, 2)] and list(i) == [3]",
        "from itertools import islice\ni = iter(range(9))\n"
        "assert list(islice(i, 2)) == [0, 1] and list(islice(i, 1, 4, 2)) == [3, 5] and next(i) == 6",
        "i = iter([1, 2, 3, 4])\nfor x in i:\n    if x == 2:\n        break\nassert [x for x in i] == [3, 4]",
    ],
)
def test_values_are_handed_out_once(script: str) -> None:
    agrees(script)


def test_what_they_refuse() -> None:
    refuses("len(iter([1]))", "an iterator has no length")
    refuses("from itertools import islice\nislice([1], -1)", "islice: a bound below 0", 2)
    refuses("next([1])", "a list is no iterator")
    refuses("next(x for x in [])", "there is no value left")
    refuses("g = (x for x in [1])\ng.gi_frame", "an iterator has no 'gi_frame'", 2)
