"""What the README shows, run as it stands there, and the tables and links of all pages."""

import re
import shlex
import subprocess
import sys
from dataclasses import fields
from math import degrees
from pathlib import Path
from types import ModuleType

import pytest

from lidardraft import CLASSES
from lidardraft.cli import main as cli
from lidardraft.scene.sensor import PRESETS, Sensor

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "python").rglob("*.md")]


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


@pytest.mark.parametrize("code", blocks("python"), ids=lambda code: code.strip().splitlines()[0])
def test_python(code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = ModuleType("__main__")  # where worker processes look for what a script defines
    monkeypatch.setitem(sys.modules, "__main__", page)
    exec(code, vars(page))
    written = (
        {".bin", ".label", ".npz", ".json", ".png"}
        if "scan.save" in code
        else {".json"} & {*re.findall(r"\.\w+", code)}
    )
    assert {path.suffix for path in tmp_path.iterdir()} == written


def test_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("lidardraft ")]
    assert len(lines) == 3
    for line in lines:
        assert cli.main(shlex.split(line, comments=True)[1:]) == 0, line
    assert capsys.readouterr().err.count("\n") <= 2  # notes
    assert (tmp_path / "crossroads/000003.bin").exists()
    assert (tmp_path / "scan.html").exists()
    assert (tmp_path / "nuscenes/v1.0-trainval/sample.json").exists()


def test_make_targets() -> None:
    result = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True)
    for target in re.findall(r"^make (\w+)", README, flags=re.MULTILINE):
        assert re.search(rf"^{target}\b", result.stdout, flags=re.MULTILINE), target


def anchors(page: Path) -> set[str]:
    """The headings of a page and of what it includes, as links name them."""
    text = page.read_text()
    text += "".join(
        (page.parent / name).read_text() for name in re.findall(r"^```\{include\} (\S+)", text, re.MULTILINE)
    )
    titles = re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target, _, anchor in (link.partition("#") for link in re.findall(r"\]\(([^)]+)\)", page.read_text())):
        if not target.startswith("http"):
            found = page.parent / target if target else page
            assert found.exists(), target
            assert not anchor or anchor in anchors(found), f"{target}#{anchor}"


def test_the_tables_of_sensors() -> None:
    page = (ROOT / "docs" / "reference" / "sensor.md").read_text()
    rows = re.findall(r"^\| `(.+?)` \| (.+?) \| (.+?) \| .+? \| (.+?) \| (.+?) \|$", page, re.MULTILINE)
    assert rows == [
        (
            name,
            f"{len(sensor.elevations)} x {sensor.columns}",
            f"{degrees(sensor.elevations[0]):.1f} to {degrees(sensor.elevations[-1]):.1f}",
            f"{sensor.mount_height:g}",
            f"{sensor.min_range:g} to {sensor.max_range:g}",
        )
        for name, sensor in PRESETS.items()
    ]
    assert {sensor.sweep_time for sensor in PRESETS.values()} == {0.1}
    keys = page.split("| key |")[1].split("\n\n")[0]
    assert re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.+?) \|", keys, re.MULTILINE))) == [
        field.name for field in fields(Sensor)
    ]
    Sensor.from_json(re.findall(r"```json\n(.*?)```", page, flags=re.DOTALL)[0])


def test_the_class_table_of_the_conventions() -> None:
    cells = re.findall(r"\| (\d+) \| ([a-z-]+)", (ROOT / "CONVENTIONS.md").read_text())
    assert {int(number): name for number, name in cells} == {row.id: row.name for row in CLASSES}
