"""A language model's server in the test process, and an environment that names no other."""

import gc
import itertools
import os
from collections.abc import Iterator

import pytest

from replay_server import ReplayServer

os.environ.setdefault("OMP_NUM_THREADS", "1")  # for torch, on small tensors: threads would wait for each other

_NUMBERS = itertools.count()


def pytest_collection_finish() -> None:
    """What was imported stays, and is not looked at whenever a test or pytest itself collects garbage."""
    gc.freeze()


@pytest.fixture(autouse=True)
def no_language_model(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    """No test asks a model that a developer uses, goes through a proxy, or fills a developer's cache."""
    for name in ("URL", "MODEL", "KEY"):
        monkeypatch.delenv(f"LIDARDRAFT_LLM_{name}", raising=False)
    for name in ("http_proxy", "https_proxy", "all_proxy", "no_proxy"):
        monkeypatch.delenv(name, raising=False)
        monkeypatch.delenv(name.upper(), raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / f"caches/{next(_NUMBERS)}"))


@pytest.fixture
def server() -> Iterator[ReplayServer]:
    """A server on a port of its own; what it answers is put into its `answers`."""
    with ReplayServer() as running:
        yield running
