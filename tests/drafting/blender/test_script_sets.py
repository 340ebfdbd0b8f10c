import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "s = set()\ns.add((1, 2))\ns.add((1, 2))\nassert len(s) == 1 and (1, 2) in s and (2, 1) not in s\n"
        "assert s and not set()",
        "s = {1, 2} | {3}\ns |= {4}\ns -= {1}\nassert s == {2, 3, 4} == set([4, 3, 2])\n"
        "assert s & {2, 9} == {2} and s ^ {2} == {3, 4}",
        "s = {1, 2, 3}\ns.discard(9)\ns.remove(1)\ns.update([5], (6,))\n"
        "assert sorted(s) == [2, 3, 5, 6] and sum(s) == 16",
        "s = {1, 2}\nt = s.copy()\nt.add(3)\nassert s.issubset(t) and not t.issubset(s)\n"
        "assert t.difference(s) == {3} and s.union([7], [8]) == {1, 2, 7, 8}\n"
        "assert s.isdisjoint({5}) and s.intersection([2]) == {2}",
        "try:\n    {1}.remove(2)\nexcept KeyError:\n    x = 1\n"
        "assert x == 1 and str(set()) == 'set()' and str({1}) == '{1}'",
        "s = {k % 3 for k in range(9)}\n"
        "assert isinstance(s, set) and not isinstance(s, (list, dict)) and len(list(s)) == 3",
        "s = {1}\nassert s != [1] and {1} != {2} and s in [{1}] and max({1, 5}) == 5",
    ],
)
def test_they_are_what_python_makes_of_them(script: str) -> None:
    agrees(script)


def test_what_they_refuse() -> None:
    refuses("{[1]}", "a list cannot be a key")
    refuses("x = 1\n{1}.add([1])", "a list cannot be a key", 2)
    refuses("{1}.pop()", "a set has no 'pop' that is supported")
    refuses("{1} + {2}", "a set . a set is not supported")
    refuses("s = set()\nwhile True:\n    s.add(len(s))", "more than 175000 steps", 3)
    refuses("s = set(range(60000))\nwhile True:\n    s | s", "more than 1000000 elements", 3)
