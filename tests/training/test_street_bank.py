"""Streets that processes make while a network learns."""

import itertools
import time

import numpy as np
import pytest
import torch
from box_pairs import SENSOR

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import Pair
from lidardraft.streets import StreetConfig, streets
from lidardraft.training import sources
from lidardraft.training.processes import ALONE
from lidardraft.training.sources import StreetBank

CPU = torch.device("cpu")


def test_a_step_draws_from_the_pairs_that_are_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "_MOST", 6)
    bank = StreetBank(3, SENSOR, workers=2)
    with bank.running(ALONE, CPU):
        stack = bank.stack(0, 2)
        assert stack.sensor == SENSOR
        assert bank.made >= 6  # so many that the oldest go
        end = time.monotonic() + 60
        while bank.made < 9 and time.monotonic() < end:
            time.sleep(0.05)
    config = StreetConfig(sensor=SENSOR, poses_per_street=sources._POSES_MEANWHILE)
    made = [
        Pair(p.scan, p.condition_image).compact() for p in itertools.islice(streets(seed=3, config=config), bank.made)
    ]
    newest = made[bank.made - 6 : bank.made]
    for number, pair in enumerate(newest, start=bank.made - 6):  # each in its place, to the bit
        for name, image in pair.items():
            held = bank._images[name][number % 6].numpy()
            np.testing.assert_array_equal(held.view(image.dtype), image)
    assert all(
        any(np.array_equal(row, pair["scan_label"]) for pair in made) for row in stack.images["scan_label"].numpy()
    )


def test_what_ends_the_processes_is_raised_where_pairs_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise TrainingError("no streets today")

    monkeypatch.setattr(sources, "streets", broken)
    bank = StreetBank(3, SENSOR, workers=1)
    with bank.running(ALONE, CPU), pytest.raises(TrainingError, match="no streets today"):
        bank.stack(0, 2)


def test_a_device_without_room_for_a_pair_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "free_memory", lambda _: 10_000)
    bank = StreetBank(3, SENSOR, workers=1)
    with (
        pytest.raises(TrainingError, match=r"cpu has no room for pairs of small, of 0.0 MB each"),
        bank.running(ALONE, CPU),
    ):
        pytest.fail("it began")
