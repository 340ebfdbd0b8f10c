import pytest
from script_reading import reads, refuses

from lidardraft.drafting.blender.script.limits import Limits, RefusalError, Script


def test_each_limit_is_a_whole_number() -> None:
    with pytest.raises(ValueError, match=r"steps is 0; a limit is a whole number of 1 or more"):
        Limits(steps=0)
    with pytest.raises(ValueError, match=r"cells is 1.5"):
        Limits(cells=1.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("limits", "script", "said"),
    [
        (Limits(file=5), "x = 100", "the script has 7 characters; 5 are read"),
        (Limits(tokens=4), "x = 1 + 2", "more than 4 names, numbers and signs"),
        (Limits(steps=20), "while 1: pass", "the script takes more than"),
        (Limits(levels=4), "[[[[[1]]]]]", "nested more than 4 levels deep"),
        (Limits(length=10), "[0] * 11", "a value of 11 elements; 10 are the most"),
        (Limits(length=10), "'a' * 81", "a text of 81 characters; 80 are the most"),
        (Limits(cells=100), "[[0] * 30 for i in range(9)]", "all values together have more than 100 elements"),
    ],
)
def test_each_limit_is_held_to(limits: Limits, script: str, said: str) -> None:
    refuses(script, said, 1, limits)
    reads(script.replace("while 1: pass", "x = 1") if "while" in script else "x = 1", Limits())


def test_what_is_counted_is_counted_before_it_is_made() -> None:
    budget = Script(Limits(length=8, cells=10))
    budget.take_cells(8)
    with pytest.raises(RefusalError, match="all values together"):
        budget.take_cells(3)
    with pytest.raises(RefusalError, match="a value of 9 elements"):
        budget.take_cells(9)
    assert Script(Limits(steps=5)).steps == 5


def test_a_line_is_kept_once_it_is_known() -> None:
    assert RefusalError("x").at(3).at(5).line == 3
