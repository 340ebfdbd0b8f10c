"""The command itself: what a stranger sees first."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import lidardraft
from lidardraft.cli import main as cli

ROOT = Path(__file__).parents[2]


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *command], capture_output=True, text=True)


def test_the_version_is_that_of_the_package() -> None:
    for file in ("pyproject.toml", "Cargo.toml"):
        assert re.search(r'^version = "(.+)"$', (ROOT / file).read_text(), re.MULTILINE)[1] == lidardraft.__version__
    result = run("-m", "lidardraft", "--version")
    assert (result.returncode, result.stdout) == (0, f"lidardraft {lidardraft.__version__}\n")
    assert run("-m", "lidardraft.cli.train", "--version").stdout == result.stdout


def test_without_a_command_the_help_says_where_to_start(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 2
    text = capsys.readouterr().err
    first = [line for line in text.splitlines() if line.startswith("  lidardraft ")]
    assert len(first) >= 2
    for line in first:
        cli._parser().parse_args(shlex.split(line)[1:])


@pytest.mark.parametrize("argv", [["--help"], ["generate", "--help"]])
def test_help_loads_nothing_heavy(argv: list[str]) -> None:
    code = (
        "import sys; from lidardraft.cli.main import main\n"
        f"try: main({argv!r})\n"
        "except SystemExit: print(sorted({'torch', 'sklearn', 'lark', 'scipy', 'PIL'} & set(sys.modules)))"
    )
    result = run("-c", code)
    assert "usage: lidardraft" in result.stdout
    assert result.stdout.endswith("[]\n")


@pytest.mark.parametrize("command", ["generate", "view", "draft", "raycast", "streets", "evaluate"])
def test_every_option_has_a_help_text(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        cli.main([command, "--help"])
    help_text = re.sub(r"\n {8,}", " ", capsys.readouterr().out)
    options = re.findall(r"^  (-.*)$", help_text.split("options:")[1], re.MULTILINE)
    assert len(options) >= 3
    for option in options:
        assert re.search(r"\S {1,}[a-z].{8}", option.split("  ")[-1]) or len(option.split()) > 4, option
    assert not re.search(r"drawing|drawn|\bthings?\b", help_text)
