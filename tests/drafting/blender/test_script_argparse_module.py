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


def test_all_arguments_have_their_defaults() -> None:
    reads(
        f"{SCRIPT}args = parser.parse_args()\nassert (args.count, args.road_width, args.wet, args.trees) == "
        "(3, 7.5, False, True)\nassert args.s is None and args.rest == []\n"
        "args, more = parser.parse_known_args([])\nassert more == []"
    )


def test_a_default_that_is_a_text_becomes_its_type() -> None:
    agrees(
        "import argparse\nparser = argparse.ArgumentParser()\n"
        "parser.add_argument('--count', type=int, default='3')\n"
        "parser.add_argument('--size', type=lambda s: [float(part) for part in s.split('x')], default='2x3.5')\n"
        "parser.add_argument('--names', nargs='*', default=None)\nparser.add_argument('--kind', type=str, default=5)\n"
        "parser.add_argument('first', nargs='?', type=float, default='1.5')\nparser.add_argument('rest', nargs='*')\n"
        "args = parser.parse_args([])\nassert args.count == 3 and args.size == [2.0, 3.5] and args.names is None\n"
        "assert args.kind == 5 and args.first == 1.5 and args.rest == []"
    )
    refuses("import argparse\nargparse.ArgumentParser().add_argument('--a', type=int, default='x')", "int: invalid", 2)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("add_argument('--a', required=True)", "the argument '--a' has no default"),
        ("add_argument('a')", "the argument 'a' has no default"),
        ("add_argument()", "a parser of no argument"),
        ("add_argument('--a', action='version')", "the action 'version' of an argument is not supported"),
        ("parse_args(['--count', '5'])", "arguments that a script gives itself are not supported"),
        ("print_help()", "an ArgumentParser has no 'print_help'"),
    ],
)
def test_an_argument_that_needs_the_command_is_refused(call: str, said: str) -> None:
    refuses(f"{SCRIPT}parser.{call}", said, 11)
