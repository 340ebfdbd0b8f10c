import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "from collections import defaultdict\nd = defaultdict(list)\nd['a'].append(1)\nd['a'].append(2)\n"
        "assert d['a'] == [1, 2] and 'b' not in d and d.get('b') is None and len(d) == 1",
        "from collections import Counter, OrderedDict\nc = Counter('abca')\nc['d'] += 1\n"
        "assert c['a'] == 2 and c['d'] == 1\n"
        "assert list(OrderedDict([('x', 1)]).items()) == [('x', 1)]",
        "from collections import namedtuple\nP = namedtuple('P', 'x y')\np = P(1, y=2)\na, b = p\n"
        "assert p.x + p[1] == a + b == 3",
        "from functools import partial, reduce\nf = partial(max, 5, key=abs)\nassert f(3) == 5\n"
        "assert reduce(lambda a, b: a * b, [2, 3, 4]) == 24 and reduce(lambda a, b: a + b, [], 7) == 7",
        "from collections import Counter\nc = Counter({'a': 2})\nc.update(['a', 'b'])\nc.update({'b': 5})\n"
        "assert c['a'] == 3 and c['b'] == 6 and c['none'] == 0 and 'none' not in c\n"
        "assert c.most_common(1) == [('b', 6)] and c.most_common() == [('b', 6), ('a', 3)] and sum(c.values()) == 9",
        "from collections import deque\nd = deque([1, 2, 3])\nd.append(4)\nd.appendleft(0)\n"
        "assert d.popleft() == 0 and d.pop() == 4 and len(d) == 3 and list(d) == [1, 2, 3] and d[-1] == 3",
        "from functools import cache, lru_cache\nmade = []\n@lru_cache(maxsize=None)\ndef f(x, y=1):\n"
        "    made.append(x)\n    return x + y\n@cache\ndef g(x):\n    made.append(x)\n    return -x\n"
        "assert f(1) == f(1) == 2 and f(1, y=2) == 3 and g(5) == g(5) == -5 and made == [1, 1, 5]",
        "from abc import ABC, abstractmethod\nclass A(ABC):\n    @abstractmethod\n    def f(self):\n        pass\n"
        "class B(A):\n    def f(self):\n        return 1\nassert B().f() == 1",
    ],
)
def test_they_give_what_python_gives(script: str) -> None:
    agrees(script)


def test_what_they_refuse() -> None:
    refuses("[1].popleft()", "a list has no 'popleft' that is supported")
    refuses("from functools import singledispatch\nsingledispatch(1)", "a call of functools.singledispatch", 2)
    refuses("from functools import cache\n@cache\ndef f(x):\n    pass\nf([])", "of what cannot be a key", 5)
    refuses("from collections import namedtuple\nnamedtuple('A', '_x')", "namedtuple of '_x' is not supported", 2)
    refuses("from functools import reduce\nreduce(max, [])", "reduce of nothing", 2)
