import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "import copy\na = {'x': [1, 2], 'y': (3, [4])}\nb = copy.deepcopy(a)\nc = copy.copy(a)\na['x'].append(5)\n"
        "a['y'][1].append(6)\nassert b == {'x': [1, 2], 'y': (3, [4])} and c['x'] is a['x'] and c is not a",
        "from copy import deepcopy\nx = []\na = [x, x]\nb = deepcopy(a)\nassert b[0] is b[1] and b[0] is not x",
        "from copy import copy, deepcopy\nfrom dataclasses import dataclass\n@dataclass\nclass A:\n    x: list\n"
        "a = A([1])\nb, c = copy(a), deepcopy(a)\nb.x.append(2)\nassert a.x == [1, 2] and c.x == [1] and c is not a",
        "from copy import deepcopy\nfrom collections import defaultdict\nd = defaultdict(list)\nd[1].append(2)\n"
        "e = deepcopy(d)\ne[3].append(4)\nassert e == {1: [2], 3: [4]} and d == {1: [2]}",
        "from copy import deepcopy\nfrom enum import Enum\nclass E(Enum):\n    A = 1\nassert deepcopy(E.A) is E.A\n"
        "assert deepcopy(len) is len and deepcopy(5) == 5 and deepcopy(None) is None",
    ],
)
def test_a_copy_shares_what_pythons_does(script: str) -> None:
    agrees(script)


def test_what_is_too_much_is_refused() -> None:
    refuses("import copy\na = []\nfor i in range(60):\n    a = [a]\ncopy.deepcopy(a)", "more than 30 levels deep", 5)
    refuses("import copy\na = 1\nfor i in range(25):\n    a = (a, a)\ncopy.deepcopy(a)", "more than 175000 steps", 5)
    refuses(
        "import copy\na = [0] * 9000\nwhile True:\n    copy.copy(a)",
        "all values together have more than 1000000 elements",
        4,
    )
