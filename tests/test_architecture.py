"""The house holds to its plan: who imports whom, how long things are, what they may be called."""

import ast
import graphlib
import re
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "python" / "lidardraft"
FILES = sorted(PACKAGE.rglob("*.py"))
PAGE, WRITTEN = ROOT / "ARCHITECTURE.md", "`python tests/test_architecture.py` writes this block"
# The rooms and modules of streets, and which others each may use.
STREETS = {
    "coarse": (),
    "ego": (),
    "street": ("coarse",),
    "worker_processes": (),
    "pairs": ("coarse", "ego", "street", "worker_processes"),
    "scans": ("coarse", "pairs", "street"),
    "drives": ("coarse", "ego", "street"),
}
TORCH_ROOMS = {"networks", "diffusion", "perception", "training", "pipeline", "evaluation"}
FORBIDDEN_NAMES = {"utils", "util", "helpers", "helper", "misc", "common", "tools", "base"}
LONGEST_FILE, LONGEST_FUNCTION = 600, 60  # of a file that is one thing


@cache
def trees() -> dict[Path, ast.Module]:
    return {path: ast.parse(path.read_text()) for path in FILES}


@cache
def nodes() -> dict[Path, list[ast.AST]]:
    """All nodes of each tree: to walk through them takes as long as to read the files."""
    return {path: list(ast.walk(tree)) for path, tree in trees().items()}


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def imported(path: Path) -> set[str]:
    """Full names of all modules and names a file imports, wherever in it."""
    names = set()
    for node in nodes()[path]:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def import_plan() -> str:
    """A line for each room: those that it imports, without those that they import, directly or not."""
    uses: dict[str, set[str]] = {room_of(path): set() for path in FILES if path != PACKAGE / "__init__.py"}
    for path in FILES:
        ours = {name.split(".")[1] for name in imported(path) if name.startswith("lidardraft.")}
        uses.get(room_of(path), set()).update(ours & uses.keys() - {room_of(path)})
    below: dict[str, set[str]] = {}
    lines = []
    for room in graphlib.TopologicalSorter({room: sorted(uses[room]) for room in sorted(uses)}).static_order():
        below[room] = uses[room].union(*(below[other] for other in uses[room]))
        direct = uses[room] - set().union(*(below[other] for other in uses[room]))
        lines.append(f"{room} <- {', '.join(sorted(direct))}" if direct else room)
    return "\n".join(lines) + "\n"


def test_imports_follow_the_plan() -> None:
    plan = PAGE.read_text().split(WRITTEN)[1].split("```")[1].removeprefix("\n")
    assert import_plan() == plan, "if the new imports are meant: python tests/test_architecture.py writes the plan"


def test_the_core_is_called_from_two_rooms() -> None:
    for path in FILES:
        uses = {name for name in imported(path) if name.startswith("lidardraft._core")}
        assert not uses or room_of(path) in ("__init__", "scene", "drafting"), path


def test_the_rooms_of_streets_stand_on_one_another() -> None:
    start = "lidardraft.streets."
    for path in sorted((PACKAGE / "streets").rglob("*.py")):
        room = path.relative_to(PACKAGE / "streets").parts[0].removesuffix(".py")
        if room == "__init__":
            continue
        used = {name.removeprefix(start) for name in imported(path) if name.startswith(start)}
        allowed = tuple(f"{other}." for other in (room, *STREETS[room]))
        assert not {name for name in used if not name.startswith(allowed)}, path


def test_outside_libraries_stay_in_their_rooms() -> None:
    for path in FILES:
        top = {name.split(".")[0] for name in imported(path)}
        assert "torch" not in top or room_of(path) in TORCH_ROOMS, path
        if room_of(path) != "cli":
            assert not top & {"argparse", "tqdm"}, path
            calls = [node for node in nodes()[path] if isinstance(node, ast.Call)]
            prints = [c.lineno for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"]
            assert not prints, f"{path} prints in lines {prints}"
        assert not top & {"requests", "pickle", "yaml"}, path
        if path.relative_to(PACKAGE).as_posix() != "drafting/language_model/chat_server.py":
            modules = {".".join(name.split(".")[:2]) for name in imported(path)}
            network = top & {"socket", "ssl", "asyncio"} | modules & {"urllib.request", "http.client", "http.server"}
            assert not network, path


def test_names_and_sizes() -> None:
    for path in FILES:
        assert path.stem not in FORBIDDEN_NAMES, path
        assert not path.stem.endswith(("_v2", "_new", "_cond")), path
        assert len(path.read_text().splitlines()) <= LONGEST_FILE, path
        for node in nodes()[path]:
            if isinstance(node, ast.FunctionDef):
                assert node.end_lineno is not None
                assert node.end_lineno - node.lineno < LONGEST_FUNCTION, f"{path}: {node.name} is too long"


def reads_of_provenance(tree: ast.AST) -> set[str]:
    """The functions that look into a provenance; it is looked into by a name, a method or `in`, not by `|`."""
    found = set()
    for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
        for node in ast.walk(function):
            used = [node.value] if isinstance(node, ast.Attribute | ast.Subscript) else []
            used = node.comparators if isinstance(node, ast.Compare) else used
            if "provenance" in [getattr(one, "attr", getattr(one, "id", "")) for one in used]:
                found.add(function.name)
    return found


def test_a_provenance_is_shown_and_saved_but_nothing_depends_on_it() -> None:
    """What depends on where a layout came from has a field of its own."""
    shown = {"scene/layout.py": {"__repr__"}, "cli/inputs.py": {"around_it"}}
    for path, tree in trees().items():
        name = path.relative_to(PACKAGE).as_posix()
        assert reads_of_provenance(tree) == shown.get(name, set()), name
    looks = "def f(layout):\n    return layout.provenance['a']\ndef g(x):\n    return 'b' in x.provenance\n"
    looks += "def h(x):\n    provenance = x.provenance\n    return provenance.get('c')\n"
    looks += "def i(x):\n    return x.provenance | {}"
    assert reads_of_provenance(ast.parse(looks)) == {"f", "g", "h"}


def test_public_names_are_documented() -> None:
    for path, tree in trees().items():
        if path.stem != "__init__" or path.parent == PACKAGE:
            assert ast.get_docstring(tree), f"{path} says nothing about itself"
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                assert ast.get_docstring(node), f"{path}: {node.name} has no docstring"


def python_uses() -> dict[str, set[str]]:
    """The modules of the package that each of its modules imports, wherever in it."""
    names = {path: ".".join(("lidardraft", *path.relative_to(PACKAGE).with_suffix("").parts)) for path in FILES}
    modules = {path: name.removesuffix(".__init__") for path, name in names.items()}
    known = set(modules.values()) - {"lidardraft"}  # whose version and debug flag are asked for
    return {
        module: {full if full in known else full.rpartition(".")[0] for full in imported(path)} & known - {module}
        for path, module in modules.items()
    }


def test_modules_of_the_package_do_not_go_in_circles() -> None:
    uses = python_uses()
    assert "lidardraft.scene.sensor" in uses["lidardraft.scene.range_image"]
    try:
        graphlib.TopologicalSorter(uses).prepare()
    except graphlib.CycleError as error:
        pytest.fail("modules use each other: " + " <- ".join(error.args[1]))


def test_no_class_is_an_include() -> None:
    """A class with one subclass and no other user is a piece of it: inheritance is for substitution."""
    classes = [node for found in nodes().values() for node in found if isinstance(node, ast.ClassDef)]
    own = {node.name for node in classes}
    bases = [base.id for node in classes for base in node.bases if isinstance(base, ast.Name) and base.id in own]
    uses = Counter(node.id for found in nodes().values() for node in found if isinstance(node, ast.Name))
    includes = {name for name in bases if bases.count(name) == 1 and uses[name] == 1}
    assert not includes, f"these are pieces of their only subclass: {sorted(includes)}"


def test_rust_files_are_short_and_unsafe_stays_in_its_folder() -> None:
    for path in (ROOT / "rust").rglob("*.rs"):
        lines = path.read_text().splitlines()
        assert len(lines) <= 400, f"{path.name} has {len(lines)} lines"
        code = [line for line in lines if not line.strip().startswith("//")]
        assert path.parent == ROOT / "rust" / "core" / "simd" or not [line for line in code if "unsafe " in line], path


def rust_names_used(text: str) -> set[str]:
    """What follows `crate::` in a Rust file: modules, and names that lib.rs re-exports."""
    code = re.sub(r"//.*", "", text)
    grouped = [names for group in re.findall(r"\bcrate::\{([^;]*)\};", code) for names in group.split(",")]
    return set(re.findall(r"\bcrate::(\w+)", code)) | {name.strip().split("::")[0] for name in grouped}


def core_uses() -> dict[str, set[str]]:
    """The modules that each module of the Rust core uses."""
    core = ROOT / "rust" / "core"
    library = (core / "lib.rs").read_text()
    modules = set(re.findall(r"^(?:pub )?mod (\w+);", library, re.MULTILINE)) - {"tests"}
    home = {module: module for module in modules}
    for module, names in re.findall(r"^pub use (\w+)::\{?([\w, \n]+)\}?;", library, re.MULTILINE):
        home |= {name.strip(): module for name in names.split(",") if name.strip() and name.strip() not in modules}
    uses: dict[str, set[str]] = {module: set() for module in modules}
    for path in core.rglob("*.rs"):
        module = path.relative_to(core).parts[0].removesuffix(".rs")
        if module in modules:
            text = path.read_text()
            assert "super::super" not in text, f"{path} should say crate::"
            uses[module] |= {home[name] for name in rust_names_used(text) if name in home} - {module}
    return uses


def test_modules_of_the_core_do_not_go_in_circles() -> None:
    uses = core_uses()
    assert "packed" in uses["scan"]
    try:
        graphlib.TopologicalSorter(uses).prepare()
    except graphlib.CycleError as error:
        pytest.fail("modules use each other: " + " <- ".join(error.args[1]))


def test_modules_of_the_core_use_those_in_lines_above() -> None:
    lines = PAGE.read_text().split("in lines above its own:")[1].split("```")[1].split("\n")
    place = {name: number for number, line in enumerate(lines) for name in line.split()}
    uses = core_uses()
    assert place.keys() == uses.keys()
    below = {(user, used) for user, names in uses.items() for used in names if place[used] > place[user]}
    assert not below, f"these use modules of lines below: {sorted(below)}"


def test_one_module_makes_lanes() -> None:
    """Those of streets; others come from files, by `read_as`, or are of several joined."""
    makers = {
        path.relative_to(PACKAGE).as_posix()
        for path, found in nodes().items()
        for node in found
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Lane"
    }
    assert makers == {"scene/street.py"}


def test_the_table_of_changes_is_true() -> None:
    table = PAGE.read_text().split("## I want to change")[1].split("\n## ")[0]
    rows = [[cell.strip(" `") for cell in line.split("|")[2:4]] for line in table.splitlines() if line.startswith("| ")]
    rows = rows[1:]
    assert len(rows) >= 20
    for file, name in rows:
        path = ROOT / file if file.startswith("rust/") else PACKAGE / file
        last = name.split("::")[-1].split(".")[-1]
        assert last in path.read_text(), f"{name} is not in {file}"


def test_every_public_name_is_there() -> None:
    import lidardraft

    rooms = {path.name for path in PACKAGE.iterdir() if path.is_dir()}
    assert rooms & set(lidardraft.__all__) == {"streets"}  # which is that room; another would be hidden by it
    for name in lidardraft.__all__:
        assert getattr(lidardraft, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = lidardraft.nothing


if __name__ == "__main__":
    before, block, after = PAGE.read_text().partition(WRITTEN)
    head, _, tail = after.split("```", 2)
    PAGE.write_text(f"{before}{block}{head}```\n{import_plan()}```{tail}")
