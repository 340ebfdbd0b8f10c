import pytest
from script_reading import agrees, reads, refuses


@pytest.mark.parametrize(
    "script",
    [
        'import json\nd = json.loads(\'{"a": [1, 2.5, null, true], "b": {"c": "d"}}\')\n'
        "assert d == {'a': [1, 2.5, None, True], 'b': {'c': 'd'}}",
        "import json\nassert json.dumps({'a': [1, (2, 3)], 'b': None}) == '{\"a\": [1, [2, 3]], \"b\": null}'",
        "import json\nassert json.loads(json.dumps(['\U0001f600', 'é'])) == ['\U0001f600', 'é']",
        "import json\nassert json.dumps({'b': 1, 'a': 2}, indent=2, sort_keys=True).splitlines()[1] == '  \"a\": 2,'",
        "import json\ntry:\n    json.loads('{')\n    assert False\nexcept ValueError:\n    pass\n"
        "try:\n    json.loads('')\n    assert False\nexcept json.JSONDecodeError:\n    pass",
    ],
)
def test_data_is_read_and_written_as_python_does(script: str) -> None:
    agrees(script)


def test_what_is_no_data_or_too_much_is_refused() -> None:
    refuses("import json\njson.load('a.json')", "json.load is not supported", 2)
    refuses("import json\njson.loads('1' * 30)", "a whole number of more than 63 bits", 2)
    refuses("import json\njson.loads('1' * 5000)", "a number of 5000 digits", 2)
    refuses("import json\njson.loads('[' * 9000 + ']' * 9000)", "nested too deeply", 2)
    refuses('import json\njson.loads(r\'[{"a": "\\ud83d"}]\')', "half a character", 2)
    refuses("import json\njson.dumps([1], indent=10**9)", "the indent is 1000000000; it must be 0 to 8", 2)
    refuses("import json\njson.dumps(json)", "json.dumps.. does not take the arguments .json", 2)
    refuses(
        "import json\ns = '[' + '1,' * 50000 + '1]'\nwhile True:\n    json.loads(s)",
        "all values together have more than 1000000 elements",
        4,
    )
    reads("import json")
