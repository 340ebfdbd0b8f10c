"""The training loop, with a network of one number."""

import dataclasses
import json
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from box_pairs import noted
from safetensors.torch import load_file
from torch import Tensor, nn

from lidardraft.errors import FormatError, TrainingError
from lidardraft.formats.pairs import write_pairs
from lidardraft.networks.weight_file import Network
from lidardraft.training.learner import LearningConfig
from lidardraft.training.loop import Measures, Report, device_for_training, naming_lack_of_memory, train
from lidardraft.training.sources import PairFolder

CONFIG = LearningConfig(steps=8, batch=4, learning_rate=0.1, warmup=1, report_every=1, save_every=3)


@dataclasses.dataclass
class OneNumberConfig:
    start: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        return dataclasses.asdict(self)


class OneNumber(Network):
    SCHEMA = "lidardraft.one-number/1"

    def __init__(self) -> None:
        super().__init__()
        self.config = OneNumberConfig()
        self.number = nn.Parameter(torch.zeros(()))


def run(config: LearningConfig, pairs: PairFolder, folder: Path, *, most: int = 99, **options: Any) -> Iterator[Report]:
    """A number that learns the mean of noise around 3, on a device that has room for batches of `most`."""
    network = OneNumber()

    def batch(config: LearningConfig, step: int) -> Tensor:
        return 3 + torch.randn(config.batch, generator=torch.Generator().manual_seed(step))

    def loss(step: int, batch: Tensor) -> tuple[Tensor, Measures]:
        if len(batch) > most:
            raise torch.OutOfMemoryError("CUDA out of memory. Tried to allocate 2.00 GiB.\nSee documentation")
        losses = (network.number - batch) ** 2
        return losses, {"odd": losses.detach()[step % 2 :: 4], "never": losses.detach()[:0]}

    return train(config, network, batch, loss, pairs, folder, device=torch.device("cpu"), **options)


def test_a_consumer_that_stops_at_the_last_report_has_the_weights(pairs: PairFolder, tmp_path: Path) -> None:
    reports = run(CONFIG, pairs, tmp_path)
    for report in reports:
        if report.step == CONFIG.steps:
            break
    assert json.loads((tmp_path / "log.jsonl").read_text().splitlines()[-1])["step"] == CONFIG.steps
    assert load_file(tmp_path / "weights.safetensors")["number"].item() != 0
    assert list(run(CONFIG, pairs, tmp_path)) == []  # nothing is left to do


@pytest.mark.parametrize("stop", [1, 3, 5])
def test_a_run_in_slices_is_the_run_in_one_and_so_is_its_log(stop: int, pairs: PairFolder, tmp_path: Path) -> None:
    whole = list(run(CONFIG, pairs, tmp_path / "whole"))
    for report in run(CONFIG, pairs, tmp_path / "sliced"):
        if report.step == stop:
            break  # as a kill would: what was reported since the last save is lost
    with (tmp_path / "sliced" / "log.jsonl").open("a") as log:
        log.write('{"step": 7, "lo')  # killed while it wrote
    rest = list(run(CONFIG, pairs, tmp_path / "sliced"))
    assert rest[0].step == stop // CONFIG.save_every * CONFIG.save_every + 1
    for name in ("weights.safetensors", "state.safetensors"):
        one, other = load_file(tmp_path / "whole" / name), load_file(tmp_path / "sliced" / name)
        assert one.keys() == other.keys()
        assert all(torch.equal(one[key], other[key]) for key in one), name
    logs = [
        [json.loads(line) for line in (tmp_path / part / "log.jsonl").read_text().splitlines()]
        for part in ("whole", "sliced")
    ]
    assert [row["step"] for row in logs[1]] == list(range(1, CONFIG.steps + 1))
    assert [(row["loss"], row["measures"]) for row in logs[0]] == [(row["loss"], row["measures"]) for row in logs[1]]
    assert [report.loss for report in whole] == [row["loss"] for row in logs[0]]


def test_reports_hold_means_since_the_last_one(pairs: PairFolder, tmp_path: Path) -> None:
    by_step = list(run(CONFIG, pairs, tmp_path / "one"))
    by_four = list(run(dataclasses.replace(CONFIG, report_every=4), pairs, tmp_path / "four"))
    assert [report.step for report in by_four] == [4, 8]
    for start, report in zip((0, 4), by_four, strict=True):
        part = by_step[start : start + 4]
        assert report.loss == pytest.approx(sum(r.loss for r in part) / 4)
        assert report.gradient == pytest.approx(sum(r.gradient for r in part) / 4)
        assert report.measures["odd"] == pytest.approx(sum(r.measures["odd"] or 0 for r in part) / 4)
        assert report.measures["never"] is None


def test_the_average_is_over_about_a_tenth_of_the_training(pairs: PairFolder, tmp_path: Path) -> None:
    expected, seen = None, []
    for report in run(dataclasses.replace(CONFIG, save_every=1), pairs, tmp_path):
        number = load_file(tmp_path / "state.safetensors")["network.number"].item()
        count = report.step - 1
        decay = (1 + count) / (10 + count)
        expected = number if expected is None else decay * expected + (1 - decay) * number
        seen.append((load_file(tmp_path / "weights.safetensors")["number"].item(), expected))
    assert [average for average, _ in seen] == pytest.approx([value for _, value in seen])


def test_what_is_killed_while_it_saves_is_done_again(pairs: PairFolder, tmp_path: Path) -> None:
    (tmp_path / "weights.safetensors" / "in the way").mkdir(parents=True)
    with pytest.raises(FormatError, match=r"weights\.safetensors cannot be written"):
        list(run(CONFIG, pairs, tmp_path))
    (tmp_path / "weights.safetensors" / "in the way").rmdir()
    (tmp_path / "weights.safetensors").rmdir()
    assert [report.step for report in run(CONFIG, pairs, tmp_path)] == list(range(1, CONFIG.steps + 1))
    assert load_file(tmp_path / "weights.safetensors")


def test_a_run_goes_on_with_the_pairs_that_it_began_with(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    list(write_pairs(first, [noted(0), noted(1)]))
    list(write_pairs(second, [noted(0), noted(2)]))
    assert len(list(run(dataclasses.replace(CONFIG, steps=2), PairFolder(first), tmp_path / "run"))) == 2
    with pytest.raises(TrainingError, match=f"begun with the pairs of {first}, which are not those of {second}"):
        list(run(CONFIG, PairFolder(second), tmp_path / "run"))
    first.rename(tmp_path / "moved")  # the same pairs in another place
    assert len(list(run(CONFIG, PairFolder(tmp_path / "moved"), tmp_path / "run"))) == 6


def test_a_run_goes_on_with_its_config_and_is_no_other_file(pairs: PairFolder, tmp_path: Path) -> None:
    list(run(dataclasses.replace(CONFIG, steps=2), pairs, tmp_path))
    with pytest.raises(TrainingError, match=r"state\.safetensors .* with another config: its decay is 0\.3, not 0\.6"):
        list(run(dataclasses.replace(CONFIG, decay=0.6), pairs, tmp_path))
    (tmp_path / "state.safetensors").write_bytes(b"half a fi")
    with pytest.raises(TrainingError, match="is not the state of a run"):
        list(run(CONFIG, pairs, tmp_path))


def test_a_loss_that_is_not_finite_ends_the_run_before_it_is_saved(pairs: PairFolder, tmp_path: Path) -> None:
    config = dataclasses.replace(CONFIG, learning_rate=1e30, save_every=1)
    with pytest.raises(TrainingError, match=r"the loss is inf and its gradient \S+ at step 2"):
        list(run(config, pairs, tmp_path))
    assert load_file(tmp_path / "weights.safetensors")["number"].isfinite()  # those of step 1


def test_lines_of_the_log_that_are_no_reports_are_dropped(pairs: PairFolder, tmp_path: Path) -> None:
    list(run(dataclasses.replace(CONFIG, steps=2), pairs, tmp_path))
    with (tmp_path / "log.jsonl").open("ab") as log:
        log.write(b'[1]\n3\nnull\n{}\n{"step": "2"}\n\xff\n')
    list(run(CONFIG, pairs, tmp_path))
    rows = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert [row["step"] for row in rows] == list(range(1, CONFIG.steps + 1))


def test_devices_that_are_not_there() -> None:
    assert device_for_training("cpu") == torch.device("cpu")
    assert device_for_training("meta") == torch.device("meta")
    with pytest.raises(TrainingError, match="device is 'nonsense'"):
        device_for_training("nonsense")
    with pytest.raises(TrainingError, match="device is 'xpu:7'"):
        device_for_training("xpu:7")


def test_a_driver_that_torch_cannot_use_is_no_training_on_a_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_old() -> bool:
        warnings.warn("CUDA initialization: The NVIDIA driver is too old (found 11040). Please update", stacklevel=2)
        return False

    monkeypatch.setattr(torch.cuda, "is_available", too_old)
    with pytest.raises(TrainingError, match=r"^the GPU cannot be used: CUDA .* \(found 11040\); --device cpu trains"):
        device_for_training()
    assert device_for_training("cpu") == torch.device("cpu")


def test_a_batch_without_memory_is_one_line(pairs: PairFolder, tmp_path: Path) -> None:
    needs = "step 1 of batches of 8 needs more memory than there is; a smaller --batch needs less"
    with pytest.raises(TrainingError, match=rf"^{needs} \(CUDA out of memory\. Tried to allocate 2\.00 GiB\.\)$"):
        list(run(dataclasses.replace(CONFIG, batch=8), pairs, tmp_path, most=7))
    assert not (tmp_path / "weights.safetensors").exists()
    assert len(list(run(dataclasses.replace(CONFIG, batch=4), pairs, tmp_path, most=4))) == 8


@pytest.mark.parametrize("make", [lambda: np.empty(2**60, np.uint8), lambda: torch.empty(2**60).byte()])
def test_memory_that_a_cpu_does_not_have_is_one_line(make: Callable[[], object]) -> None:
    with pytest.raises(TrainingError, match="step 3 of batches of 2 needs more memory"), naming_lack_of_memory(2, 2):
        make()


def test_other_errors_of_a_step_stay_what_they_are() -> None:
    with pytest.raises(RuntimeError, match="shape"), naming_lack_of_memory(2, 0):
        torch.zeros(2).reshape(3)
