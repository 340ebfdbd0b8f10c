"""The modules that scripts may import: those that compute, and those that stand for a script's surroundings."""

import math
import random

import pytest
from script_reading import agrees, reads, refuses

SCRIPT = """
import argparse, sys
parser = argparse.ArgumentParser(description="a street")
group = parser.add_argument_group("sizes")
parser.add_argument("--count", "-n", type=int, default=3, help="how many")
group.add_argument("--road-width", type=float, default=7.5)
group.add_argument("--wet", action="store_true")
group.add_argument("--no-trees", dest="trees", action="store_false")
parser.add_argument("-s")
parser.add_argument("rest", nargs="*")
"""
AGREED: list[str] = [
    "from abc import ABC, abstractmethod\nclass A(ABC):\n    @abstractmethod\n    def f(self):\n        pass\n"
    "class B(A):\n    def f(self):\n        return 1\nassert B().f() == 1",
    "from itertools import count, cycle, pairwise\nassert list(pairwise('abc')) == [('a', 'b'), ('b', 'c')]\n"
    "assert list(zip(cycle(x for x in 'ab'), range(3))) == [('a', 0), ('b', 1), ('a', 2)]\n"
    "for a, b in pairwise(count(5)):\n    break\nassert (a, b) == (5, 6)",
    # a default that is a text becomes its type
    "import argparse\nparser = argparse.ArgumentParser()\nparser.add_argument('--count', type=int, default='3')\n"
    "parser.add_argument('--size', type=lambda s: [float(part) for part in s.split('x')], default='2x3.5')\n"
    "parser.add_argument('--names', nargs='*', default=None)\nparser.add_argument('--kind', type=str, default=5)\n"
    "parser.add_argument('first', nargs='?', type=float, default='1.5')\nparser.add_argument('rest', nargs='*')\n"
    "args = parser.parse_args([])\nassert args.count == 3 and args.size == [2.0, 3.5] and args.names is None\n"
    "assert args.kind == 5 and args.first == 1.5 and args.rest == []",
    # names of files are what python makes of them
    "import os\nassert os.path.join('/a', 'b', 'c.glb') == '/a/b/c.glb' and os.path.basename('/a/b.py') == 'b.py'",
    "from os.path import dirname, splitext\nassert dirname('/a/b') == '/a' and splitext('a.py') == ('a', '.py')",
    "from pathlib import Path\np = Path('/a') / 'b' / 'c.tar.gz'\n"
    "assert str(p) == '/a/b/c.tar.gz' and p.name == 'c.tar.gz' and p.stem == 'c.tar' and p.suffix == '.gz'\n"
    "assert str(p.parent) == '/a/b' and str(p.parents[1]) == '/a' and p == Path('/a', 'b/c.tar.gz')\n"
    "assert str(p.with_suffix('.py')) == '/a/b/c.tar.py' and f'{p.with_name(\"d\")}' == '/a/b/d'\n"
    "assert repr(Path('a')) == \"PosixPath('a')\"",
    "import sys\nsys.path.append('/lib')\nargs = sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else []\n"
    "assert args == [] and sys.version_info >= (3, 8) and sys.maxsize > 1",
    "import os\nassert os.environ.get('LIDARDRAFT_NOT_SET', '5') == os.getenv('LIDARDRAFT_NOT_SET', '5') == '5'",
    # what is said to nobody is passed over
    "import gc, logging, sys, traceback, warnings\nlogging.basicConfig(level=logging.WARNING)\n"
    "log = logging.getLogger(__name__)\nlog.setLevel(logging.ERROR)\nlog.info('made %d', 3)\n"
    "log.addHandler(logging.StreamHandler(sys.stderr))\nlog.propagate = False\nlogging.debug('x')\n"
    "warnings.simplefilter('ignore')\nwarnings.warn('old')\nsys.stdout.flush()\ngc.collect()\n"
    "assert logging.INFO == 20",
]
REFUSED: list[tuple[str, str, int]] = [
    ("from functools import singledispatch\nsingledispatch(1)", "a call of functools.singledispatch", 2),
    ("from collections import namedtuple\nnamedtuple('A', '_x')", "namedtuple of '_x' is not supported", 2),
    # a default that is a text becomes its type
    ("import argparse\nargparse.ArgumentParser().add_argument('--a', type=int, default='x')", "int: invalid", 2),
    # what is no time is refused
    ("from datetime import datetime\ndatetime.now() + 1", "a moment", 2),
    ("from datetime import timedelta\ntimedelta(days=1)", "a call of datetime.timedelta", 2),
    # what writes a file is refused
    ("import logging\nlogging.basicConfig(filename='/tmp/a')", "a log that is written to a file", 2),
    ("import logging\nlogging.FileHandler('/tmp/a')", "logging.FileHandler is not supported", 2),
    ("import sys\nsys.stdout.buffer", "sys.stdout.buffer is not supported", 2),
    ("import logging\nlogging.getLogger().handlers", "a logger.handlers is not supported", 2),
    # what reaches outside is refused where it is called
    ("import sys\nsys.exit(1)", "the script ends here", 2),
    ("import os\nos.makedirs('/tmp/x')", "os.makedirs is not supported", 2),
    ("import os\nos.environ['HOME']", "os.environ has no item 'HOME'", 2),
    ("import os\nos.path.getsize('a')", "os.path.getsize is not supported", 2),
    ("from pathlib import Path\nPath('a').write_text('b')", "a path has no 'write_text'", 2),
    ("from pathlib import Path\nlist(Path('/').iterdir())", "a path has no 'iterdir'", 2),
    ("import sys\nsys.modules['os']", "sys.modules is not supported", 2),
    ("from pathlib import Path\nPath('a/' * 9999)", "a path of 19998 characters; the limit is 4096", 2),
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


def test_all_arguments_have_their_defaults() -> None:
    reads(
        f"{SCRIPT}args = parser.parse_args()\nassert (args.count, args.road_width, args.wet, args.trees) == "
        "(3, 7.5, False, True)\nargs.count = 5\nassert args.count == 5 and args.s is None and args.rest == []\n"
        "args, more = parser.parse_known_args([])\nassert more == []"
    )


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("add_argument('--a', required=True)", "the argument '--a' has no default"),
        ("add_argument('a')", "the argument 'a' has no default"),
        ("add_argument('--a', action='version')", "the action 'version' of an argument is not supported"),
        ("parse_args(['--count', '5'])", "arguments that a script gives itself are not supported"),
        ("print_help()", "an ArgumentParser has no 'print_help'"),
    ],
)
def test_an_argument_that_needs_the_command_is_refused(call: str, said: str) -> None:
    refuses(f"{SCRIPT}parser.{call}", said, 11)


def test_the_clock_stands_still_and_shows_nothing() -> None:
    script = "import time\nfrom datetime import datetime\nassert time.time() == time.perf_counter() == 0\n"
    script += "assert datetime.now().strftime('%Y') == time.strftime('%H:%M') == ''"
    assert reads(script).notes == {"the time is taken as 0": 3}


def test_no_file_is_looked_at() -> None:
    notes = reads("import os\nassert not os.path.exists('/')\nassert not os.path.isdir(os.getcwd())").notes
    assert list(notes) == [f"no file is looked at: os.path.{name} says False" for name in ("exists", "isdir")]
    notes = reads("from pathlib import Path\nassert not Path(__file__).parent.resolve().exists()").notes
    assert list(notes) == ["no file is looked at: Path.exists says False"]
    notes = reads("from pathlib import Path\nassert not Path('a').is_file() and not Path('a').is_dir()").notes
    assert list(notes) == [f"no file is looked at: Path.{name} says False" for name in ("is_file", "is_dir")]
    notes = reads("import os\nassert os.environ.get('HOME') is None").notes
    assert list(notes) == ["no variable of the environment is read"]


@pytest.mark.parametrize("code", ["", "0", "None"])
def test_a_script_may_end_itself(code: str) -> None:
    reads(f"import sys\ntry:\n    sys.exit({code})\nexcept Exception:\n    assert False\nassert False")
    reads("raise SystemExit")
    reads("try:\n    raise SystemExit(0)\nfinally:\n    x = 1")
