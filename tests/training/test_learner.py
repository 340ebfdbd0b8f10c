from pathlib import Path

import pytest

from lidardraft.errors import TrainingError
from lidardraft.training.learner import LearningConfig, RunIdentity


def test_the_rate_rises_stays_and_falls() -> None:
    config = LearningConfig(steps=100, batch=1, warmup=10, decay=0.2, learning_rate=1.0)
    assert [config.rate(step) for step in (0, 9, 50, 80, 90, 99)] == pytest.approx([0.1, 1, 1, 1, 0.5, 0.05])


def test_a_run_may_get_longer_but_no_other() -> None:
    fields = LearningConfig(steps=100, batch=2, learning_rate=0.1).of_any_length()
    assert fields == LearningConfig(steps=200, batch=2, learning_rate=0.1, save_every=7, report_every=9).of_any_length()
    assert fields != LearningConfig(steps=100, batch=3, learning_rate=0.1).of_any_length()


@pytest.mark.parametrize(
    ("begun", "message"),
    [
        (RunIdentity({"seed": 0}, 1, 3, "old"), "begun with the pairs of old, which are not those of new"),
        (RunIdentity({"seed": 0}, 3, 2, "old"), r"begun with other weights \(--init, or the base of a ControlNet\)"),
        (RunIdentity({"seed": 5}, 1, 2, "old"), "with another config: its seed is 5, not 0"),
        (RunIdentity({"seed": 0, "crop": 8}, 1, 2, "old"), "with another config: its crop is 8, not None"),
    ],
)
def test_what_differs_from_how_a_run_was_begun_is_named(begun: RunIdentity, message: str) -> None:
    now = RunIdentity({"seed": 0}, 1, 2, "new")
    now.check(Path("state"), RunIdentity({"seed": 0}, 1, 2, "old"))  # the pairs were moved
    with pytest.raises(TrainingError, match=f"state is the state of a run {message}; use another folder"):
        now.check(Path("state"), begun)


@pytest.mark.parametrize("name", ["steps", "batch", "save_every", "report_every"])
def test_counts_that_cannot_be(name: str) -> None:
    fields = {"steps": 1, "batch": 1, "learning_rate": 0.1, name: 0}
    with pytest.raises(TrainingError, match=f"{name} is 0; it must be at least 1"):
        LearningConfig(**fields).check_counts()
