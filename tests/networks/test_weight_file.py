import json
import subprocess
import sys
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file, save_file

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.errors import CheckpointError
from lidardraft.networks import weight_file
from lidardraft.networks.weight_header import read_metadata
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, SphericalGrid

CONFIG = DenoiserConfig(
    cell=(2, 4), widths=(8, 8), strides=(1, 2), dilations=(1, 1), condition=("depth", "class"), controlnet=True
)


@pytest.fixture
def denoiser() -> Denoiser:
    torch.manual_seed(0)
    return Denoiser.from_config(CONFIG)


@pytest.fixture
def path(denoiser: Denoiser, tmp_path: Path) -> Path:
    weight_file.save(denoiser, tmp_path / "weights.safetensors", {"score": 0.5})
    return tmp_path / "weights.safetensors"


def test_weights_config_and_card_come_back(denoiser: Denoiser, path: Path) -> None:
    loaded = weight_file.load(path, Denoiser)
    assert loaded.config == CONFIG
    assert not loaded.training
    for name, weight in denoiser.state_dict().items():
        assert torch.equal(loaded.state_dict()[name], weight), name
    assert weight_file.read_card(path) == {"score": 0.5}
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_half_precision_halves_the_file(denoiser: Denoiser, path: Path, tmp_path: Path) -> None:
    half = tmp_path / "half.safetensors"
    weight_file.save(denoiser, half, {}, half=True)
    assert half.stat().st_size < 0.6 * path.stat().st_size
    for name, weight in weight_file.load(half, Denoiser).state_dict().items():
        assert weight.dtype == torch.float32
        torch.testing.assert_close(weight, denoiser.state_dict()[name], rtol=1e-3, atol=1e-4)


def rewritten(path: Path, tensors: dict[str, torch.Tensor], **metadata: str) -> Path:
    known = {"schema": Denoiser.SCHEMA, "config": json.dumps(CONFIG.to_dict()), "card": "{}"}
    save_file(tensors, path, {**known, **metadata})
    return path


def test_what_is_not_ours_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match=r"nothing\.safetensors: No such file"):
        weight_file.load(tmp_path / "nothing.safetensors", Denoiser)
    text = tmp_path / "text.safetensors"
    text.write_text("not weights at all")
    with pytest.raises(CheckpointError, match="is not a complete safetensors file"):
        weight_file.load(text, Denoiser)
    with pytest.raises(CheckpointError, match="is a directory; it must be a regular file"):
        weight_file.load(tmp_path, Denoiser)
    foreign = tmp_path / "foreign.safetensors"
    save_file({"weight": torch.zeros(3)}, foreign)
    with pytest.raises(CheckpointError, match=r"schema is None; it must be 'lidardraft.denoiser/2'"):
        weight_file.load(foreign, Denoiser)
    with pytest.raises(CheckpointError, match="schema is None"):
        weight_file.read_card(foreign)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.999])
def test_truncated_files_are_refused(path: Path, share: float) -> None:
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(CheckpointError, match="is not a complete safetensors file"):
        weight_file.load(path, Denoiser)


def test_pickles_are_refused(tmp_path: Path) -> None:
    torch.save({"weight": torch.zeros(3)}, tmp_path / "weights.pt")
    with pytest.raises(CheckpointError, match="is not a complete safetensors file"):
        weight_file.load(tmp_path / "weights.pt", Denoiser)


def test_tensors_that_do_not_fit_are_refused(path: Path) -> None:
    tensors = load_file(path)
    name = "network.head.bias"
    with pytest.raises(CheckpointError, match=f"tensor '{name}' is missing"):
        weight_file.load(rewritten(path, {key: t for key, t in tensors.items() if key != name}), Denoiser)
    with pytest.raises(CheckpointError, match="tensor 'spare' is unknown"):
        weight_file.load(rewritten(path, {**tensors, "spare": torch.zeros(1)}), Denoiser)
    with pytest.raises(CheckpointError, match=rf"tensor '{name}' is \[3\]; it must be \[64\]"):
        weight_file.load(rewritten(path, {**tensors, name: torch.zeros(3)}), Denoiser)
    with pytest.raises(CheckpointError, match=f"tensor '{name}' holds values that are not finite"):
        weight_file.load(rewritten(path, {**tensors, name: torch.full((64,), torch.nan)}), Denoiser)


@pytest.mark.parametrize(
    "config",
    ["{", "3", "{}", '{"cell": [2, 4], "widths": [8], "strides": [1, 2], "dilations": [1]}', '{"cell": "a"}'],
)
def test_a_config_that_makes_no_denoiser_is_refused(path: Path, config: str) -> None:
    with pytest.raises(CheckpointError, match="its config makes no Denoiser"):
        weight_file.load(rewritten(path, load_file(path), config=config), Denoiser)


def test_each_network_reads_its_own_weights(path: Path, tmp_path: Path) -> None:
    segmenter = Segmenter(SegmenterConfig(grid=SphericalGrid(rows=16, columns=64), widths=(8, 8)))
    weight_file.save(segmenter, tmp_path / "segmenter.safetensors", {"score": 1})
    again = weight_file.load(tmp_path / "segmenter.safetensors", Segmenter)
    assert again.config == segmenter.config
    assert all(torch.equal(again.state_dict()[name], weight) for name, weight in segmenter.state_dict().items())
    assert weight_file.read_card(tmp_path / "segmenter.safetensors") == {"score": 1}
    with pytest.raises(CheckpointError, match=r"'lidardraft.segmenter/2'; it must be 'lidardraft.denoiser/2'"):
        weight_file.load(tmp_path / "segmenter.safetensors", Denoiser)
    with pytest.raises(CheckpointError, match=r"'lidardraft.denoiser/2'; it must be 'lidardraft.segmenter/2'"):
        weight_file.load(path, Segmenter)


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
    with pytest.raises(CheckpointError, match=r"a\.safetensors is not a complete safetensors file"):
        read_metadata(path)
    with pytest.raises(CheckpointError, match="is a directory"):
        read_metadata(tmp_path)
