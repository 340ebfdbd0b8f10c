"""The modules that scripts may import: those that compute, and those that stand for a script's surroundings."""

import math
import random

import pytest
from script_reading import agrees, reads, refuses

AGREED: list[str] = [
    "from abc import ABC, abstractmethod\nclass A(ABC):\n    @abstractmethod\n    def f(self):\n        pass\n"
    "class B(A):\n    def f(self):\n        return 1\nassert B().f() == 1",
    "from itertools import count, cycle, pairwise\nassert list(pairwise('abc')) == [('a', 'b'), ('b', 'c')]\n"
    "assert list(zip(cycle(x for x in 'ab'), range(3))) == [('a', 0), ('b', 1), ('a', 2)]\n"
    "for a, b in pairwise(count(5)):\n    break\nassert (a, b) == (5, 6)",
    "import sys\nsys.path.append('/lib')\nargs = sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else []\n"
    "assert args == [] and sys.version_info >= (3, 8)",
    # names of files and arguments of commands may be made, as nothing depends on them
    "import argparse, os\nfrom pathlib import Path\npath = Path(os.getcwd()) / 'a' / os.path.join('b', 'c')\n"
    "print(path, os.environ.get('HOME'))\n"
    "parser = argparse.ArgumentParser()\nparser.add_argument('--count', type=int, default=3)\n"
    "args = parser.parse_args([])",
    # what is said to nobody is passed over
    "import gc, logging, sys, traceback, warnings\nlogging.basicConfig(level=logging.WARNING)\n"
    "log = logging.getLogger(__name__)\nlog.setLevel(logging.ERROR)\nlog.info('made %d', 3)\n"
    "log.addHandler(logging.StreamHandler(sys.stderr))\nlogging.debug('x')\n"
    "warnings.simplefilter('ignore')\nwarnings.warn('old')\nsys.stdout.flush()\ngc.collect()",
]
REFUSED: list[tuple[str, str, int]] = [
    ("from functools import singledispatch\nsingledispatch(1)", "a call of functools.singledispatch", 2),
    ("from collections import namedtuple\nnamedtuple('A', 'x')", "a call of collections.namedtuple", 2),
    ("from enum import Enum\nclass K(Enum):\n    A = 1", "a class derived from enum.Enum is not supported", 2),
    # what a script's surroundings tell is not known
    (
        "import argparse\nargs = argparse.ArgumentParser().parse_args()\nrange(args.count)",
        "count; it must be a whole",
        3,
    ),
    ("from datetime import datetime\ndatetime.now() + 1", r"datetime.datetime.now\(\) . 1 is not supported", 2),
    ("import os\nif os.path.exists('/'):\n    pass", r"the value of os.path.exists\(\) is not known", 2),
    ("import os\nx = len(os.environ['HOME'])", "os.environ has no item 'HOME'", 2),
    ("import os\nos.environ.get('A') is None", r"the value of os.environ.get\(\) is not known", 2),
    ("import os\nf'{os.getcwd()}'", r"the value of os.getcwd\(\) is not known", 2),
    ("from pathlib import Path\nlist(Path('/').iterdir())", "cannot be looped over", 2),
    # what reaches outside is refused where it is called
    ("import sys\nsys.exit(1)", "the script ends here", 2),
    ("import os\nos.remove('/tmp/x')", "os.remove is not supported", 2),
    ("import sys\nsys.modules['os']", "sys.modules is not supported", 2),
]


@pytest.mark.parametrize("script", AGREED)
def test_it_is_what_python_makes_of_it(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(("script", "said", "line"), REFUSED)
def test_it_is_refused(script: str, said: str, line: int) -> None:
    refuses(script, said, line)


@pytest.mark.parametrize(
    "draw",
    [
        "random.random()",
        "random.uniform(-2, 3)",
        "random.randint(1, 6)",
        "random.randrange(0, 100, 5)",
        "random.choice([4, 5, 6])",
        "random.choice('abc')",
        "random.choice(range(9))",
        "random.choices(['a', 'b'], weights=[1, 5], k=4)",
        "random.sample(range(100), 5)",
        "random.gauss(0, 1)",
        "random.normalvariate(1, 2)",
        "random.triangular(0, 10, 2)",
        "random.expovariate(2)",
    ],
)
@pytest.mark.parametrize("seed", [0, 12345, "'a text'"])
def test_random_numbers_are_those_of_python(draw: str, seed: object) -> None:
    drawn: dict[str, object] = {}
    exec(f"import random\nrandom.seed({seed})\nx = [{draw} for _ in range(5)]", drawn)
    reads(f"import random\nrandom.seed({seed})\nassert [{draw} for _ in range(5)] == {drawn['x']!r}")


def test_generators_of_their_own_and_shuffling() -> None:
    agrees("import random\na = random.Random(3)\nb = random.Random(3)\nassert a.random() == b.random() != a.random()")
    order = list(range(9))

    random.Random(3).shuffle(order)
    reads(f"import random\nx = list(range(9))\nrandom.Random(3).shuffle(x)\nassert x == {order}")


def test_the_functions_of_math_are_those_of_python() -> None:
    for name, arguments in (("sin", "0.5"), ("atan2", "1, 2"), ("hypot", "3, 4"), ("floor", "-1.5"), ("gcd", "12, 18")):
        expected = eval(f"math.{name}({arguments})", {"math": math})
        reads(f"import math\nassert math.{name}({arguments}) == {expected!r}")
    agrees("import math\nassert math.dist((0, 0), [3, 4]) == 5 and math.factorial(5) == 120 and math.isnan(math.nan)")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("math.sqrt(-1)", "math.sqrt: math domain error|math.sqrt: expected"),
        ("math.sin('a')", "math.sin.. does not take the arguments ..a"),
        ("math.gamma(5)", "math.gamma is not supported"),
        ("math.floor(1e300)", "more than 63 bits"),
        ("random.choice([])", "choice: Cannot choose"),
        ("random.getrandbits(8)", "random has no 'getrandbits'"),
        ("random.seed([1])", "the seed is a list; it must be a number or a text"),
        ("random.shuffle((1, 2))", "a tuple cannot be shuffled"),
        ("random.uniform(1)", "uniform.. does not take"),
    ],
)
def test_what_they_refuse(call: str, said: str) -> None:
    refuses(f"import math, random\n{call}", said, 2)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("permutations(range(17))", "the number of elements at a time is 17; it must be 0 to 16"),
        ("list(combinations(range(99), 9))", "more than 175000 steps"),
        ("list(chain(count(), [1]))", "more than 175000 steps"),
        ("all(range(1, 10**10))", "9999999999 elements"),
        ("list(cycle(x for x in [1, 2]))", "more than 175000 steps"),
    ],
)
def test_what_is_too_much_is_refused_before_it_is_made(call: str, said: str) -> None:
    refuses(f"from itertools import *\n{call}", said, 2)


def test_the_clock_stands_still() -> None:
    notes = reads("import time\nassert time.time() == time.perf_counter() == 0").notes
    assert notes == {"the time is taken as 0": 2}


@pytest.mark.parametrize("code", ["", "0", "None"])
def test_a_script_may_end_itself(code: str) -> None:
    reads(f"import sys\ntry:\n    sys.exit({code})\nexcept Exception:\n    assert False\nassert False")
    reads("raise SystemExit")
    reads("try:\n    raise SystemExit(0)\nfinally:\n    x = 1")
