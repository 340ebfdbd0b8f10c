import pytest

from lidardraft.cli.training_progress import show
from lidardraft.training.loop import Report


def test_the_bar_shows_the_last_report(capsys: pytest.CaptureFixture[str]) -> None:
    reports = [
        Report(step=step, loss=1 / step, gradient=0.0, measures={}, samples_per_second=3.0, minutes=0.0)
        for step in (2, 4)
    ]
    assert show(iter(reports), 4, "stage") == 4
    shown = capsys.readouterr().err
    assert "stage: 100%" in shown
    assert "loss 0.250, 3.0 samples/s" in shown
    assert show(iter([]), 4, "stage") is None
