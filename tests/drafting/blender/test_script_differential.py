"""Generated programs of the subset: the reader comes to the values that Python comes to."""

from random import Random

import pytest
from script_reading import reads

from lidardraft.drafting.blender.script.limits import Limits

START = """import random
random.seed(7)
log, a, b, c = [], [3, 1, 2], [5, 4], {'x': 1, 'y': 2}
d, e, i, j, s = a, {'z': 3}, 2, -3, {1, 2}
t = s
def f(n=1):
    log.append(n)
    return random.randrange(3) + n
def g(*rest, k=2):
    for each in rest:
        yield each * k
"""


def expression(r: Random, depth: int = 0) -> str:
    """A whole number."""
    deeper = [
        lambda: f"({number()} {r.choice(['+', '-', '*', '//', '%', '&', '|', '^'])} {number()})",
        lambda: f"f({number()} % 5)",
        lambda: f"{r.choice('abd')}[{number()} % 4]",
        lambda: f"c.get({r.choice('xyz')!r}, {number()})",
        lambda: f"({number()} if {number()} {r.choice(['<', '>=', '==', '!='])} {number()} else {number()})",
        lambda: f"sum([k * {number()} for k in {r.choice(['a', 'b', 'd', 'sorted(s)'])} if k > {number()}])",
        lambda: f"len({r.choice('abcdest')})",
        lambda: f"sum(g({number()}, *{r.choice('abd')}, k={number()}))",
        lambda: f"({r.choice('ij')} := {number()})",
    ]

    def number() -> str:
        return expression(r, depth + 1)

    return r.choice([*"ij", str(r.randint(-3, 5))]) if depth > 2 or r.random() < 0.2 else r.choice(deeper)()


def statement(r: Random, depth: int = 0) -> list[str]:
    """The lines of a statement."""
    e, name = expression(r), r.choice("abd")
    simple = [f"{name}[f() % 3] {r.choice(['+', '-', '*', '//', '|'])}= {e}", f"{r.choice('ij')} += {e}"]
    simple += [
        f"{name} += [{e}]",
        f"{name} *= {e} % 3",
        f"{name}[{e} % 3:] = [{e}]",
        f"i, *{name}, j = {e}, *{name}, 4",
    ]
    simple += [
        f"{r.choice('st')} {r.choice('|&-^')}= {{{e}, 2}}",
        f"{r.choice('ce')} |= {{'z': {e}}}",
        f"del {name}[{e} % 3]",
    ]
    simple += [
        f"c[{r.choice('xyz')!r}] = {e}",
        f"log.append(f'{{i:>4}}|{{{name}}}')",
        f"{name} = sorted({name}, reverse=True)",
    ]
    if depth > 1 or r.random() < 0.6:
        return [r.choice(simple)]
    body = ["    " + line for _ in range(r.randint(1, 3)) for line in statement(r, depth + 1)]
    heads = [f"for i in list({name})[:4]:", f"if {e} > 0:", f"for i, k in zip({name}, range({e} % 4)):"]
    ends = r.choice([["else:", "    log.append('else')"], []])
    caught = ["except (IndexError, KeyError):", "    log.append('missing')", "finally:", "    log.append(i)"]
    return ["try:", *body, *caught] if r.random() < 0.3 else [r.choice(heads), *body, *ends]


@pytest.mark.parametrize("seed", range(150))
def test_it_comes_to_what_python_comes_to(seed: int) -> None:
    r = Random(seed)
    lines = [START]
    for _ in range(12):
        body = ["    " + line for line in statement(r)]
        lines += [
            "try:",
            *body,
            "except (LookupError, ArithmeticError, ValueError) as error:",
            "    log.append('error')",
        ]
    end = "found = repr((log, a, b, c, d, e, i, j, sorted(s), sorted(t), random.random()))"
    names: dict[str, object] = {}
    program = "\n".join([*lines, end])
    exec(compile(program, "program", "exec"), names)
    reads(f"{program}\nassert found == {names['found']!r}, found", Limits(steps=10**6))
