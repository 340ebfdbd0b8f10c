import numpy as np
import pytest
import torch

from lidardraft.errors import TrainingError
from lidardraft.training.free_memory import check_memory, free_memory, memory_of


def test_more_than_there_is_is_refused() -> None:
    free = free_memory()
    if free is None:
        pytest.skip("this system does not say how much memory is free")
    check_memory("a little", free // 4)
    with pytest.raises(TrainingError, match=r"a folder needs .* GB of memory; .* GB are free"):
        check_memory("a folder", 4 * free)


@pytest.mark.parametrize("ask", [lambda: np.empty(2**60, np.uint8), lambda: torch.empty(2**60, dtype=torch.uint8)])
def test_memory_that_is_not_there_is_one_line(ask: object) -> None:
    assert callable(ask)
    with (
        pytest.raises(TrainingError, match="step 1 needs more memory than there is; use a smaller --batch"),
        memory_of("step 1"),
    ):
        ask()


def test_other_errors_stay_what_they_are() -> None:
    with pytest.raises(RuntimeError, match="shape"), memory_of("step 1"):
        torch.zeros(2).reshape(3)
