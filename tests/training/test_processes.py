"""Two processes on one machine, this and another, in the environment that torchrun gives them."""

import dataclasses
import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import torch
from box_pairs import noted
from safetensors.torch import load_file

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import write_pairs
from lidardraft.training import recipes
from lidardraft.training.denoising import train_denoiser
from lidardraft.training.processes import ALONE, Processes
from lidardraft.training.sources import PairFolder

SCRIPT = """
import dataclasses, sys, torch
from lidardraft.training import recipes
from lidardraft.training.denoising import train_denoiser
from lidardraft.training.sources import PairFolder
torch.set_num_threads(1)
config = dataclasses.replace(recipes.tiny()[0], steps=4, batch=3, learning_rate=1e-3)
list(train_denoiser(config, PairFolder(sys.argv[1]), sys.argv[2]))
"""


def test_shares_of_a_batch_are_disjoint_and_together_all() -> None:
    assert list(ALONE.share(3)) == [0, 1, 2]
    assert [list(Processes(rank, 2).share(3)) for rank in range(2)] == [[0, 2], [1]]
    with pytest.raises(TrainingError, match="a step learns from 1 scans, too few for 2 processes"):
        Processes(0, 2).share(1)


def test_two_processes_learn_what_one_learns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    list(write_pairs(tmp_path / "pairs", (noted(seed) for seed in range(4))))
    (tmp_path / "learn.py").write_text(SCRIPT)
    with socket.create_server(("localhost", 0)) as free:
        address = {"MASTER_ADDR": "localhost", "MASTER_PORT": str(free.getsockname()[1]), "WORLD_SIZE": "2"}
    config = dataclasses.replace(recipes.tiny()[0], steps=4, batch=3, learning_rate=1e-3)
    call = [sys.executable, str(tmp_path / "learn.py"), str(tmp_path / "pairs"), str(tmp_path / "two")]
    other = subprocess.Popen(call, env=os.environ | address | {"RANK": "1"})
    with monkeypatch.context() as first:
        for name, value in {**address, "RANK": "0"}.items():
            first.setenv(name, value)
        list(train_denoiser(config, PairFolder(tmp_path / "pairs"), tmp_path / "two"))
        torch.distributed.destroy_process_group()
    assert other.wait() == 0
    list(train_denoiser(config, PairFolder(tmp_path / "pairs"), tmp_path / "one"))
    one, two = (load_file(tmp_path / run / "weights.safetensors") for run in ("one", "two"))
    for name, weight in one.items():
        # sums of bfloat16 in another order
        torch.testing.assert_close(two[name], weight, atol=2e-3, rtol=0, msg=name)
    # one report, of the samples of both
    (alone,), (together,) = ((tmp_path / run / "log.jsonl").read_text().splitlines() for run in ("one", "two"))
    alone, together = json.loads(alone), json.loads(together)
    assert together["loss"] == pytest.approx(alone["loss"], rel=0.01)
    for name, value in alone["measures"].items():
        assert together["measures"][name] == (None if value is None else pytest.approx(value, rel=0.01)), name
