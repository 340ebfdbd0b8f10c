from pathlib import Path

import pytest
from box_pairs import noted

from lidardraft.formats.pairs import write_pairs
from lidardraft.training.sources import PairFolder


@pytest.fixture(scope="session")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> PairFolder:
    folder: Path = tmp_path_factory.mktemp("pairs")
    list(write_pairs(folder, (noted(seed) for seed in range(6))))
    return PairFolder(folder)
