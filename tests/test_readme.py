"""What the README shows, run as it stands there."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


@pytest.mark.parametrize("code", blocks("python"), ids=lambda code: code.strip().splitlines()[0])
def test_python(code: str, tmp_path: Path) -> None:
    result = subprocess.run([sys.executable, "-W", "error", "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    written = {".bin", ".label", ".json", ".png"} if "scan.save" in code else set()
    assert {path.suffix for path in tmp_path.iterdir()} == written


@pytest.mark.timeout(400)
def test_commands(tmp_path: Path) -> None:
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("lidardraft ")]
    assert len(lines) >= 6
    for line in lines:
        words = shlex.split(line, comments=True)[1:]
        if words[0] in ("generate", "evaluate"):
            words += ["--steps", "4"]
        if words[0] == "evaluate":
            words += ["-n", "1"]  # 50 streets take minutes
        if words[0] == "streets":
            words += ["--num", "2", "--poses", "1", "--workers", "1"]  # 1,000 take minutes
        if "scan.bin" in words:
            for end in (".bin", ".label"):
                (tmp_path / f"scan{end}").write_bytes((tmp_path / f"crossroads/000000{end}").read_bytes())
        command = [sys.executable, "-m", "lidardraft", *words]
        result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert result.returncode == 0, f"{line}\n{result.stderr}"
    assert (tmp_path / "crossroads/000003.bin").exists()
    assert (tmp_path / "crossroads/000000.view.png").exists()
    assert (tmp_path / "streets.png").exists()
    assert (tmp_path / "pairs/index.json").exists()


def test_make_targets() -> None:
    result = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True)
    for target in re.findall(r"^make (\w+)", README, flags=re.MULTILINE):
        assert re.search(rf"^{target}\b", result.stdout, flags=re.MULTILINE), target


@pytest.mark.parametrize("document", ["README.md", "ARCHITECTURE.md", "CONVENTIONS.md", "CONTRIBUTING.md"])
def test_links_lead_somewhere(document: str) -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", (ROOT / document).read_text()):
        if not target.startswith("http"):
            assert (ROOT / target).exists(), target


def test_the_class_table_of_the_conventions() -> None:
    from lidardraft import CLASSES

    cells = re.findall(r"\| (\d+) \| ([a-z-]+)", (ROOT / "CONVENTIONS.md").read_text())
    assert {int(number): name for number, name in cells} == {row.id: row.name for row in CLASSES}
