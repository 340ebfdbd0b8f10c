import math
import random

import pytest
from script_reading import agrees, reads, refuses


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
