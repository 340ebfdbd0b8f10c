"""The pages of docs/: their links lead somewhere, and their code runs as it stands there, on fewer scans."""

import json
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

import lidardraft
from lidardraft.cli import main as cli
from lidardraft.cli import train
from lidardraft.training.sources import PairFolder
from replay_server import ReplayServer, openai

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts)
TUTORIAL = DOCS / "tutorial.md"
BLOCK = re.compile(r"^```(?:\{code-block\} )?(\w+)\n(?::caption: (\S+)\n\n)?(.*?)^```", re.MULTILINE | re.DOTALL)
# Commands that need what tests do not have: a network, a cluster, a second machine, a person.
ELSEWHERE = (
    "pip",
    "python3",
    "source",
    "ssh",
    "srun",
    "ros2",
    "ollama",
    "#SBATCH",
    "devkit/bin/pip",
    "lidardraft studio",
)
# What larger numbers become here.
FEWER = {"-n": 2, "--num": 2, "--frames": 3, "--steps": 1}
SERVER = "http://localhost:11434/v1"


def name_of(page: Path) -> str:
    return str(page.relative_to(DOCS))


def blocks(page: Path) -> Iterator[tuple[str, str, str]]:
    """Language, name of the file or "", and text of each block of a page."""
    return ((language, caption, text) for language, caption, text in BLOCK.findall(page.read_text(encoding="utf-8")))


def smaller(words: list[str]) -> list[str]:
    """A command with less to do: the same options, smaller numbers, no pictures."""
    for at, (option, value) in enumerate(pairwise(words), 1):
        if option in FEWER:
            words[at] = str(min(int(value), FEWER[option]))
    command, *rest = words
    if command == "lidardraft-train":
        words += ["--batch", "1"]
        if rest[0] == "street":  # a network for tests, of one street
            at = words.index("--init") if "--init" in words else len(words)
            words = [*words[:at], *words[at + 2 :], "--recipe", "tiny", "--steps", "1", "--evaluate", "1"]
        return words
    if rest[0] == "dataset":
        return [*words, "-n", "3"]
    if rest[0] == "streets":
        return [*words, "--jobs", "1"]
    if rest[0] == "generate" or "--weights" in rest:
        return [*words, "--steps", "1", *([] if "--weights" in rest else ["--weights", "paper-small"]), "-n", "1"]
    if rest[0] == "draft":
        return [*words, "--no-preview"]
    return [*words, "--no-picture"] if rest[0] in ("simulate", "observe") else words


def run(line: str, whole: bool, capsys: pytest.CaptureFixture[str]) -> None:
    words = shlex.split(line, comments=True)
    if line.startswith(ELSEWHERE) or ("--image" in words and "--depth" not in words):
        return
    if words[0] == "python":
        runpy.run_path(words[1], run_name="__main__")
    elif words[0] == "devkit/bin/python":
        by_devkit(words[1])
    else:
        program, *arguments = words if whole else smaller(words)
        code = (train.main if program == "lidardraft-train" else cli.main)(arguments)
        assert code == 0, f"{line}\n{capsys.readouterr().err}"


def by_devkit(script: str) -> None:
    """Run a script that needs nuscenes-devkit if NUSCENES_PYTHON has it; the files are looked at in any case."""
    if "NUSCENES_PYTHON" in os.environ:
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        subprocess.run([os.environ["NUSCENES_PYTHON"], script], check=True, env=environment)
    tables = Path("set/nuscenes/v1.0-trainval")
    sweeps, labels = (json.loads((tables / f"{name}.json").read_text()) for name in ("sample_data", "lidarseg"))
    for sweep, label in zip(sweeps, labels, strict=True):
        points = np.fromfile(tables.parent / sweep["filename"], np.float32).reshape(-1, 5)
        assert len(points) == (tables.parent / label["filename"]).stat().st_size > 10_000
    assert json.loads((tables / "sample_annotation.json").read_text())


def walk(page: Path, whole: bool, capsys: pytest.CaptureFixture[str]) -> None:
    """Do what a page says, from top to bottom, in the working folder."""
    module = sys.modules["__main__"]
    for _, file, text in blocks(page):
        if file:
            Path(file).write_text(text if whole else text.replace("steps=300, warmup=30", "steps=2, warmup=1"))
    for language, file, text in blocks(page):
        if language == "python" and not file:
            exec(re.sub(r"frames=\d+", "frames=2", text), vars(module))
        elif language == "sh":
            for line in text.splitlines():
                run(line, whole, capsys)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the files that a page takes as given."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "__main__", ModuleType("__main__"))  # where worker processes look for classes
    shutil.copytree(ROOT / "examples" / "sketches", tmp_path / "examples" / "sketches")
    down = np.linspace(-0.4, 0.4, 90)[:, None] + np.zeros(160)  # slope of each pixel's ray
    depth = np.where(down > 0.05, 1.65 / np.maximum(down, 0.05), 30.0).astype(np.float32)  # road, wall
    np.save("depth.npy", depth)
    Image.fromarray(np.where(down > 0.05, 0, 2).astype(np.uint8)).save("classes.png")
    Image.fromarray(np.full((90, 160, 3), 128, np.uint8)).save("photo.jpg")
    return tmp_path


APART = (TUTORIAL, DOCS / "how-to" / "world.md")  # whose code runs in tests of their own
WITH_CODE = [page for page in PAGES if page not in APART and any(lang in ("python", "sh") for lang, *_ in blocks(page))]


LONG = ("evaluate.md", "fit-sensor.md", "scenarios.md", "train.md", "view.md")  # whose parts have tests of their own


@pytest.mark.timeout(400)
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, id=name_of(page), marks=pytest.mark.slow if page.name in LONG else ()) for page in WITH_CODE],
)
def test_the_code_of_a_page_runs(
    page: Path, place: Path, server: ReplayServer, capsys: pytest.CaptureFixture[str]
) -> None:
    server.answers = [openai(text) for language, _, text in blocks(page) if language == "json"] * 2
    (place / page.name).write_text(page.read_text(encoding="utf-8").replace(SERVER, server.url), encoding="utf-8")
    walk(place / page.name, False, capsys)


def check_tutorial(scans: int) -> None:
    assert len(list(Path("set/nuscenes/samples/LIDAR_TOP").iterdir())) == scans
    assert len(PairFolder("pairs")) == scans
    assert Path("segmenter/weights.safetensors").exists()


@pytest.mark.timeout(400)
def test_the_tutorial_on_three_scans(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = TUTORIAL.read_text(encoding="utf-8").replace("range(8)", "range(2)").replace("-n 8", "-n 2")
    (place / "tutorial.md").write_text(text, encoding="utf-8")
    walk(place / "tutorial.md", False, capsys)
    check_tutorial(3)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.usefixtures("place")
def test_the_tutorial(capsys: pytest.CaptureFixture[str]) -> None:
    walk(TUTORIAL, True, capsys)
    check_tutorial(300)
    rows = dict(re.findall(r"^(\S+) +IoU (\S+)", capsys.readouterr().out, re.MULTILINE))
    assert float(rows["road"]) > 0.4
    assert float(rows["car"]) > 0.5


def test_every_command_of_the_pages_is_known() -> None:
    """Also of those that run elsewhere: the first word is one of our programs, whose parser knows all others, or is
    listed in ELSEWHERE."""
    parsers = {"lidardraft": cli.parser(), "lidardraft-train": train.parser()}
    for page in PAGES:
        for language, _, text in blocks(page):
            for line in text.splitlines() if language == "sh" else ():
                programs = ("lidardraft ", "lidardraft-train ", "python ", "devkit/bin/")
                assert not line or line.startswith((*programs, *ELSEWHERE)), f"{page.name}: {line}"
                program, *words = shlex.split(line, comments=True) or [""]
                if program in parsers:
                    parsers[program].parse_args(words)


def test_every_page_is_in_a_table_of_contents() -> None:
    listed = {DOCS / "index.md"}
    for page in PAGES:
        for tree in re.findall(r"^```\{toctree\}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
            names = [line for line in tree.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{name}.md").resolve() for name in names}
    assert listed == set(PAGES)


def test_every_included_file_exists_and_says_when_it_was_measured() -> None:
    results = set()
    for page in PAGES:
        for name in re.findall(r"^```\{include\} (\S+)", page.read_text(encoding="utf-8"), re.MULTILINE):
            file = (page.parent / name).resolve()
            assert file.exists(), f"{page.name}: {name}"
            results |= {file} if file.parent.name == "results" else set()
    assert len(results) > 10
    for file in results:
        assert re.match(r"Measured 20\d\d-\d\d(-\d\d)? .*`.+`", file.read_text(encoding="utf-8")), file.name


def test_the_pages_are_short() -> None:
    words = {page: len(page.read_text(encoding="utf-8").split()) for page in PAGES}
    assert sum(words.values()) <= 19_000
    for page in (DOCS / "how-to").glob("*.md"):
        prose = BLOCK.sub("", page.read_text(encoding="utf-8"))
        assert len(re.findall(r"[^\s|]*\w[^\s|]*", prose)) <= 400, page.name


def test_every_public_name_has_a_place_in_the_reference() -> None:
    pages = "".join(page.read_text() for page in (DOCS / "reference" / "api").glob("*.md"))
    named = set(re.findall(r"^\.\. auto\w+:: lidardraft\.(?:streets\.)?(\w+)", pages, re.MULTILINE))
    assert set(lidardraft.__all__) <= named
