import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "assert ' Ab '.strip().lower() == 'ab' and 'a-b'.title() == 'A-B' and 'x'.isalpha() and '7'.isdigit()",
        "assert 'abcabc'.find('c', 3) == 5 and 'aab'.count('a') == 2 and 'abc'.startswith(('x', 'a'))",
        "assert 'a b  c'.split() == ['a', 'b', 'c'] and 'a,b,c'.split(',', 1) == ['a', 'b,c']",
        "assert 'a\\nb\\r\\nc\\n'.splitlines() == ['a', 'b', 'c'] and ''.splitlines() == []",
        "assert '-'.join(['a', 'b']) == 'a-b' and 'aXbX'.replace('X', '', 1) == 'abX' and '7'.zfill(3) == '007'",
        "assert 'a'.ljust(3, '.') == 'a..' and 'a'.rjust(2) == ' a' and 'a'.center(3) == ' a '",
        "x = [3, 1]\nx.append(2)\nx.extend((5, 4))\nx.insert(0, 9)\nx.remove(1)\n"
        "assert x == [9, 3, 2, 5, 4] and x.pop() == 4",
        "x = [3, 1, 2]\nx.sort(key=lambda v: -v)\nassert x == [3, 2, 1] and x.index(2) == 1 and x.count(1) == 1",
        "x = [1, 2]\ny = x.copy()\nx.reverse()\nx.clear()\nassert y == [1, 2] and x == []",
        "d = {'a': 1}\nd.update({'b': 2}, c=3)\nassert d.get('z', 0) == 0 and "
        "list(d.items())[1] == ('b', 2) and "
        "d.pop('a') == 1",
        "d = {}\nd.setdefault('a', []).append(1)\nassert d == {'a': [1]} and list(d.keys()) == ['a'] and "
        "list(d.values()) == [[1]]",
        "assert (1, 2, 1).count(1) == 2 and (1, 2).index(2) == 1",
    ],
)
def test_they_do_what_pythons_do(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("[].pop()", "a list of 0 has no place -1"),
        ("[1].remove(2)", "2 is not in the list"),
        ("{}.pop('a')", "pop: 'a'"),
        ("{}.setdefault([])", "a list cannot be a key"),
        ("'a'.encode()", "'a' has no 'encode' that is supported"),
        ("''.join([1])", "a part of a text is 1; it must be a text"),
        ("[].append()", "append.. does not take the arguments"),
        ("'a'.ljust(1000)", "the width is 1000; it must be 200 or less"),
        ("range(3).index(1)", "a range has no 'index' that is supported"),
    ],
)
def test_wrong_uses_are_named(script: str, said: str) -> None:
    refuses(script, said)


def test_a_method_that_is_kept_costs_as_much_each_time() -> None:
    for method, arguments in (("upper", ""), ("count", "'b'"), ("split", "'zz'"), ("isdigit", "")):
        refuses(
            f"s = 'a' * 900000\nf = s.{method}\nwhile True:\n    f({arguments})", "all values together have more", 4
        )
