import pytest
from script_reading import reads, refuses

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
        "(3, 7.5, False, True)\nassert args.s is None\nargs, more = parser.parse_known_args([])\nassert more == []"
    )


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("add_argument('--a', required=True)", "the argument '--a' has no default"),
        ("add_argument('a')", "the argument 'a' has no default"),
        ("add_argument()", "a parser of no argument"),
        ("add_argument('--a', action='version')", "the action 'version' of an argument is not read"),
        ("parse_args(['--count', '5'])", "arguments that a script gives itself are not read"),
        ("print_help()", "an ArgumentParser has no 'print_help'"),
    ],
)
def test_what_is_refused(call: str, said: str) -> None:
    refuses(f"{SCRIPT}parser.{call}", said, 11)
