"""The core does all but generate, train and see: in an environment without torch and transformers."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import lidardraft

# Refuses the libraries of the extras, as an environment does that has none of them, and then runs what follows.
_WITHOUT = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("torch", "transformers"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Missing())
"""
# What README promises of the core, in one process: every format that layouts and scans are written in, and read again.
_CORE = """
import numpy as np
import lidardraft
from lidardraft.cli.main import main
small = lidardraft.Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)
small.save("small.json")
sensor = ["--sensor", "small.json"]
for command in (
    ["draft", "--text", "two cars ahead, trees on both sides", "-o", "layout.json"],
    ["draft", "--layout", "layout.json", "-o", "layout.glb", "--no-preview"],
    ["draft", "--glb", "layout.glb", "-o", "layout.obj", "--no-preview"],
    ["draft", "--layout", "layout.json", "-o", "layout.py", "--no-preview"],
    ["draft", "--blender", "layout.py", "-o", "again.json", "--no-preview"],
    ["raycast", "--layout", "layout.json", "-o", "cast.npz", *sensor],
    ["observe", "cast.npz", "-o", "observed"],
    ["simulate", "--layout", "layout.json", "-o", "scans", *sensor],
    ["simulate", "--points", "scans/000000.bin", "-o", "again"],
    ["streets", "-n", "1", "--workers", "1", "-o", "pairs", *sensor],
    ["view", "scans/000000.bin"],
    ["view", "layout.json"],
    ["view", "pairs/00000.npz"],
):
    assert main(command) == 0, command
assert lidardraft.simulate(lidardraft.layout_from_text("a bus ahead"), small).points().shape[1] == 3
"""
_EXTRAS = """
import lidardraft, numpy as np
from lidardraft.cli import main, train
assert main.main(["draft", "--text", "a car ahead", "-o", "layout.json", "--no-preview"]) == 0
np.full((20, 4), 0.5, np.float32).tofile("scan.bin")
from lidardraft.perception.mask_votes import number_objects
for run, command in (
    (main, "generate --layout layout.json -o out"),
    (main, "evaluate -n 1"),
    (main, "pairs scan.bin --sensor vlp16 -o out/pairs"),
    (train, "street --steps 1"),
    (train, "segmenter --pairs out/pairs -o out/run"),
):
    assert run.main(command.split()) == 2, command
for name in ("Pipeline",):
    try:
        getattr(lidardraft, name)
    except lidardraft.LidarDraftError as error:
        assert isinstance(error, ImportError)
        print(error)
picture = np.random.default_rng(0).integers(0, 256, (40, 60, 3), dtype=np.uint8)
try:
    lidardraft.layout_from_image(picture, hfov=1.2)
except lidardraft.LidarDraftError as error:
    print(error)
"""


def run(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", _WITHOUT + code], cwd=folder, capture_output=True, text=True)


def test_the_core_drafts_casts_simulates_views_and_writes_every_format(tmp_path: Path) -> None:
    ended = run(_CORE, tmp_path)
    assert ended.returncode == 0, ended.stderr


def test_what_needs_torch_names_the_extra_in_one_line(tmp_path: Path) -> None:
    ended = run(_EXTRAS, tmp_path)
    assert ended.returncode == 0, ended.stderr
    said = "torch is not installed; run: pip install 'lidardraft[{}]'"
    lines = [f"{name}: {said.format(extra)}" for name, extra in
             (*[("lidardraft", "generate")] * 3, *[("lidardraft-train", "train")] * 2)]  # fmt: skip
    assert ended.stderr.splitlines() == lines
    assert ended.stdout.splitlines()[1:] == [said.format("generate"), said.format("image")]
    assert not [*(tmp_path / "out").rglob("*.npz"), *(tmp_path / "out").rglob("*.safetensors")]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_fresh_environment_of_the_core_has_no_torch_and_simulates(tmp_path: Path) -> None:
    """Dependencies as pyproject.toml lists them, from the index that pip is set to; the package is this checkout's."""
    import tomllib

    root = Path(lidardraft.__file__).parents[2]
    needed = tomllib.loads((root / "pyproject.toml").read_text())["project"]["dependencies"]
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    python = tmp_path / "venv" / ("Scripts" if sysconfig.get_platform().startswith("win") else "bin") / "python"
    install = [python, "-m", "pip", "install", "-q", "-c", root / "constraints.txt", *needed]
    subprocess.run(install, check=True)
    environment = os.environ | {"PYTHONPATH": str(root / "python")}
    code = "import importlib.util as u; assert not u.find_spec('torch') and not u.find_spec('transformers')"
    for each in (code, _CORE):
        ended = subprocess.run([python, "-c", each], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert ended.returncode == 0, ended.stderr
