"""The progress bar of a training."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lidardraft.training.loop import Report


def show(reports: Iterator[Report], steps: int, name: str) -> int | None:
    """A progress bar of a training; its last step, or None where there was nothing to do."""
    from tqdm import tqdm

    step = None
    with tqdm(total=steps, unit="step", desc=name) as bar:
        for report in reports:
            bar.update(report.step - bar.n)
            bar.set_postfix_str(f"loss {report.loss:.3f}, {report.samples_per_second:.1f} samples/s")
            step = report.step
    return step
