import subprocess
import sys
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from lidardraft.errors import CheckpointError
from lidardraft.networks.weight_header import read_metadata


def test_the_metadata_comes_back_without_torch(tmp_path: Path) -> None:
    path = tmp_path / "a.safetensors"
    save_file({"a": torch.zeros(3)}, path, {"schema": "x"})
    assert read_metadata(path) == {"schema": "x"}
    call = f"read_metadata({str(path)!r}); import sys; sys.exit('torch' in sys.modules)"
    code = f"from lidardraft.networks.weight_header import read_metadata; {call}"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_what_is_no_weight_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.safetensors"
    with pytest.raises(CheckpointError, match=r"a\.safetensors: No such file"):
        read_metadata(path)
    path.write_bytes(b"\xff" * 100)
    with pytest.raises(CheckpointError, match=r"a\.safetensors is no whole safetensors file"):
        read_metadata(path)
    with pytest.raises(CheckpointError, match="is a directory"):
        read_metadata(tmp_path)
