import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "from itertools import product\n"
        "assert list(product([1, 2], 'ab')) == [(1, 'a'), (1, 'b'), (2, 'a'), (2, 'b')]\n"
        "assert len(list(product(range(3), repeat=2))) == 9",
        "from itertools import combinations, permutations\n"
        "assert list(combinations([1, 2, 3], 2)) == [(1, 2), (1, 3), (2, 3)]\n"
        "assert len(list(permutations('abc'))) == 6",
        "from itertools import chain\n"
        "assert list(chain([1], (2, 3))) == list(chain.from_iterable([[1, 2], [3]])) == [1, 2, 3]",
        "from itertools import count, cycle, repeat, islice\n"
        "assert list(zip('ab', count(10, 2))) == [('a', 10), ('b', 12)]\n"
        "assert list(islice(cycle([1, 2]), 5)) == [1, 2, 1, 2, 1] and list(repeat(0, 3)) == [0, 0, 0]\n"
        "c = count(5)\nassert next(c) == 5 and next(c) == 6\nfor k in c:\n    if k > 9:\n        break\nassert k == 10",
        "from itertools import accumulate, pairwise, islice\nassert list(accumulate([1, 2, 3])) == [1, 3, 6]\n"
        "assert list(accumulate([1, 2, 3], lambda a, b: a * b)) == [1, 2, 6] and list(pairwise('abc')) == [('a', "
        "'b'), ('b', 'c')]\n"
        "assert list(islice(range(9), 1, 6, 2)) == [1, 3, 5]",
        "from itertools import accumulate, chain, count, cycle, islice, pairwise\nmade = []\n"
        "def f():\n    for k in count():\n        made.append(k)\n        yield k\n"
        "for part in (islice(f(), 5), chain(f(), [9]), accumulate(f()), pairwise(f()), cycle(f())):\n"
        "    for x in part:\n        break\n    assert len(made) < 3, made\n    made.clear()\n"
        "assert list(islice(chain([7], f()), 3)) == [7, 0, 1] and list(islice(accumulate(f()), 4)) == [0, 1, 3, 6]\n"
        "assert list(islice(pairwise(f()), 2)) == [(0, 1), (1, 2)] and list(accumulate([], initial=4)) == [4]\n"
        "assert list(islice(cycle(x for x in 'ab'), 5)) == list('ababa')",
    ],
)
def test_they_give_what_pythons_do(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("product(range(999), range(999))", "more than 175000 steps"),
        ("permutations(range(17))", "the number of elements at a time is 17; it must be 0 to 16"),
        ("combinations(range(99), 9)", "more than 175000 steps"),
        ("list(islice(count(), 10**9))", "more than 175000 steps"),
        ("list(islice(count(), None))", "more than 175000 steps"),
        ("list(zip(count(), count()))", "more than 175000 steps"),
        ("list(chain(count(), [1]))", "more than 175000 steps"),
        ("list(accumulate(count()))", "more than 175000 steps"),
        ("list(islice(range(10**10), 10**9, None))", "10000000000 elements"),
        ("all(range(1, 10**10))", "9999999999 elements"),
        ("all(count(1))", "more than 175000 steps"),
        ("list(cycle(x for x in [1, 2]))", "more than 175000 steps"),
    ],
)
def test_what_is_too_much_is_refused_before_it_is_made(call: str, said: str) -> None:
    refuses(f"from itertools import *\n{call}", said, 2)
