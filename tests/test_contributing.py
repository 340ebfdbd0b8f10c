"""What CONTRIBUTING and ARCHITECTURE name exists, and what a recipe must not forget fails here."""

import ast
import re
from pathlib import Path

import pytest

import lidardraft

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "python" / "lidardraft"
PAGES = (
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CONVENTIONS.md",
    "README.md",
    *(str(page.relative_to(ROOT)) for page in (ROOT / "docs").rglob("*.md")),
)


def functions(path: Path) -> list[str]:
    return [node.name for node in ast.parse(path.read_text()).body if isinstance(node, ast.FunctionDef)]


def named_files(page: str) -> set[str]:
    """The Python, Rust and Markdown files that a page names, without those with a placeholder."""
    text = re.sub(r"https?://\S+", "", (ROOT / page).read_text())
    names = set(re.findall(r"[\w./{},*-]+\.(?:py|rs|md)\b", text))
    for name in [name for name in names if "{" in name]:
        names.remove(name)
        before, choices, after = re.split(r"[{}]", name)
        names |= {f"{before}{choice}{after}" for choice in choices.split(",")}
    names -= set(re.findall(r"^:caption: (\S+)", text, re.MULTILINE))  # files that the page itself gives
    return {re.sub(r"^(\.\./)+", "", name) for name in names if "*" not in name}


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_a_page_names_exists(page: str) -> None:
    files = [
        str(path.relative_to(ROOT))
        for top in ("rust", "python", "tests", "benches", "examples", "docs")
        for path in (ROOT / top).rglob("*")
    ]
    files += [path.name for path in ROOT.iterdir()]
    missing = [name for name in named_files(page) if not any(f"/{file}".endswith(f"/{name}") for file in files)]
    assert not missing


def test_every_test_that_a_recipe_names_exists() -> None:
    tests = {name for path in (ROOT / "tests").rglob("test_*.py") for name in functions(path)}
    named = set(re.findall(r"`(test_\w+)`", (ROOT / "CONTRIBUTING.md").read_text()))
    assert len(named) >= 3
    assert named <= tests


def test_every_input_is_public_and_a_command_takes_it() -> None:
    names = [name for path in (PACKAGE / "drafting").rglob("*.py") for name in functions(path)]
    inputs = [name for name in names if name.startswith("layout_from_")]
    inputs.remove("layout_from_spec")  # what the inputs of words end in
    assert len(inputs) >= 2
    command = "".join(path.read_text() for path in (PACKAGE / "cli").glob("*input*.py"))
    for name in inputs:
        assert name in lidardraft.__all__
        assert f"{name}(" in command


def test_every_reader_of_a_format_is_damaged_in_the_tests() -> None:
    names = [name for path in (PACKAGE / "formats").glob("*.py") for name in functions(path)]
    readers = {name for name in names if name.startswith("read_")}
    table = (ROOT / "benches" / "good_files.py").read_text()
    assert readers
    assert {name for name in readers if f"{name}(" not in table and f"({name}," not in table} == set()


def test_every_metric_is_asked_for() -> None:
    users = [path.read_text() for path in (*PACKAGE.rglob("*.py"), *(ROOT / "benches").glob("*.py"))]
    for path in (PACKAGE / "metrics").glob("[!_]*.py"):
        used = rf"from lidardraft\.metrics\.{path.stem} import|from lidardraft\.metrics import .*\b{path.stem}\b"
        assert any(re.search(used, text) for text in users), path.stem
