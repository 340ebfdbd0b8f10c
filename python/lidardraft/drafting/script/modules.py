"""The modules `math` and `random` as a script sees them."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

from lidardraft.drafting.script.class_parts import BaseMarker
from lidardraft.drafting.script.limits import Budget, RefusalError
from lidardraft.drafting.script.values import Builtin, Namespace, Record, Value, checked, describe, elements, whole

_FUNCTIONS = (
    *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cos", "cosh", "sin", "sinh", "tan", "tanh"),
    *("ceil", "floor", "trunc", "fabs", "fmod", "copysign", "gcd", "hypot", "degrees", "radians"),
    *("exp", "log", "log10", "log2", "pow", "sqrt", "isqrt", "modf", "isclose", "isfinite", "isinf", "isnan"),
)
_LARGEST_FACTORIAL = 20  # the largest below 2^63
_DRAWS = ("random", "uniform", "gauss", "normalvariate", "lognormvariate", "expovariate", "triangular")
_STEPS_OF_SEED, _CELLS_OF_GENERATOR = 20, 1000
_WHOLE_DRAWS = ("randint", "randrange")


def math_module(budget: Budget) -> Namespace:
    """The functions of numbers, and the constants."""

    def bounded(function: Callable[..., Value]) -> Callable[..., Value]:
        return lambda *arguments, **keywords: checked(function(*arguments, **keywords))

    def factorial(n: Value) -> int:
        if whole(n, "the number") > _LARGEST_FACTORIAL:
            raise RefusalError(f"factorial: {n} is more than {_LARGEST_FACTORIAL}")
        return math.factorial(n)

    functions = {name: bounded(getattr(math, name)) for name in _FUNCTIONS}
    functions |= {
        "factorial": factorial,
        "dist": lambda a, b: math.dist(elements(a, budget), elements(b, budget)),
        "fsum": lambda items: math.fsum(elements(items, budget)),
    }
    values: dict[str, Value] = {name: Builtin(f"math.{name}", function) for name, function in functions.items()}
    return Namespace("math", values | {name: getattr(math, name) for name in ("pi", "tau", "e", "inf", "nan")})


class Annotations(Record):
    """`typing` and `__future__`, and all that is in them: what is said of types is passed over."""

    kind = "an annotation"

    def attribute(self, name: str) -> Value:
        return BaseMarker(name) if name == "NamedTuple" else self

    def item(self, _key: Value) -> Value:
        return self


class RandomNumbers(Record):
    """`random`, or a `random.Random`: the numbers that Python's generator gives for a seed, which is 0 until it is set.

    `note` gets a line where a number is drawn before that.
    """

    kind = "random"

    def __init__(self, budget: Budget, note: Callable[[str], None], seed: Value = None) -> None:
        self.budget = budget
        self._note = note
        self._seeded = seed is not None
        self._generator = random.Random(0 if seed is None else self._checked(seed))
        self.functions: dict[str, Builtin] = {}
        self._tables()

    def attribute(self, name: str) -> Value:
        if name not in self.functions:
            raise RefusalError(f"random.{name} is not read")
        return self.functions[name]

    @staticmethod
    def _checked(seed: Value) -> int | float | str:
        if not isinstance(seed, int | float | str):
            raise RefusalError(f"the seed is {describe(seed)}; it must be a number or a text")
        return seed

    def _tables(self) -> None:
        generator = self._generator
        table = {name: getattr(generator, name) for name in (*_DRAWS, *_WHOLE_DRAWS)}
        table |= {"choice": self._choice, "choices": self._choices, "sample": self._sample, "shuffle": self._shuffle}
        for name, function in table.items():
            self.functions[name] = Builtin(f"random.{name}", self._drawing(function))
        self.functions["seed"] = Builtin("random.seed", self._seed, _STEPS_OF_SEED)
        self.functions["Random"] = Builtin("random.Random", self._another, 4 * _STEPS_OF_SEED)

    def _drawing(self, function: Callable[..., Value]) -> Callable[..., Value]:
        def draw(*arguments: Value, **keywords: Value) -> Value:
            if not self._seeded:
                self._note("random numbers without a seed: the seed 0 is taken")
            return checked(function(*arguments, **keywords))

        return draw

    def _another(self, x: Value = None) -> RandomNumbers:
        self.budget.take_cells(_CELLS_OF_GENERATOR)
        return RandomNumbers(self.budget, self._note, x)

    def _seed(self, a: Value = None) -> None:
        self._seeded |= a is not None
        self._generator.seed(0 if a is None else self._checked(a))

    def _choice(self, seq: Value) -> Value:
        return self._generator.choice(seq if isinstance(seq, range) else elements(seq, self.budget))

    def _choices(self, population: Value, weights: Value = None, *, cum_weights: Value = None, k: Value = 1) -> Value:
        self.budget.take_steps(max(whole(k, "k"), 0))
        items = elements(population, self.budget)
        return self._generator.choices(items, weights, cum_weights=cum_weights, k=k)

    def _sample(self, population: Value, k: Value) -> Value:
        self.budget.take_steps(max(whole(k, "k"), 0))
        items = population if isinstance(population, range) else elements(population, self.budget)
        return self._generator.sample(items, k)

    def _shuffle(self, x: Value) -> None:
        if not isinstance(x, list):
            raise RefusalError(f"{describe(x)} cannot be shuffled")
        self.budget.take_steps(len(x))
        self._generator.shuffle(x)
