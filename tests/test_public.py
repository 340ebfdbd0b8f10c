"""What `import lidardraft` offers: every name has a type, what arguments are made of is there, and seeds are alike."""

import ast
import inspect
import os
import re
import subprocess
import sys
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import lidardraft
from lidardraft import Layout, LayoutError, Primitive, RecordedScan, Scan, Sensor, streets
from lidardraft.cli.main import main

SCRIPT = Path(__file__).with_name("typed_script.py")
PACKAGE = Path(lidardraft.__file__).parent
NETWORKS = ("lidardraft.diffusion", "lidardraft.networks")  # rooms whose own signatures name layers and their configs
RECORDS = {"Scan", "WorldState", "streets.Street"}  # of the seed that something was made with
SENSOR = Sensor(name="few", elevations=(0.05, -0.1, -0.2), columns=64)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(90, 90, 0), label="road", id="road")
BOX = Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 2), label="car", id="car_1", instance=1)
STREET = Layout((ROAD, BOX))


def public() -> Iterator[tuple[str, Any]]:
    """Every public name, with those of modules that are public whole."""
    for name in lidardraft.__all__:
        value = getattr(lidardraft, name)
        if isinstance(value, ModuleType):
            names = getattr(value, "__all__", None) or [
                n for n, f in vars(value).items() if n[0] != "_" and getattr(f, "__module__", "") == value.__name__
            ]
            yield from ((f"{name}.{each}", getattr(value, each)) for each in names)
        else:
            yield name, value


def callables(name: str, value: Any) -> Iterator[tuple[str, Callable[..., Any]]]:
    """A public function, or the constructor and the public methods and properties of a class."""
    if inspect.isfunction(value):
        yield name, value
    elif inspect.isclass(value):
        for key, method in vars(value).items():
            function = inspect.unwrap(getattr(method, "fget", None) or getattr(method, "func", None) or method)
            function = getattr(function, "__func__", function)
            if inspect.isfunction(function) and (not key.startswith("_") or key in ("__init__", "__call__")):
                yield name if key == "__init__" else f"{name}.{key}", function


def named_types(hint: Any) -> Iterator[type]:
    for argument in typing.get_args(hint):
        for each in argument if isinstance(argument, list) else [argument]:
            yield from named_types(each)
    if inspect.isclass(hint):
        yield hint


def test_type_checkers_read_the_names_that_are_there() -> None:
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text())
    aliases = [alias for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    assert all(alias.asname == alias.name for alias in aliases)  # without, `mypy --strict` does not export it again
    names = [alias.name for alias in aliases]
    assert sorted(names) == lidardraft.__all__ == dir(lidardraft)
    assert [name for name in names if isinstance(getattr(lidardraft, name), ModuleType)] == ["streets", "edit"]


def test_what_signatures_mention_is_public() -> None:
    known = dict(public())
    types, checked, hidden = {id(value) for value in known.values()}, 0, set()
    for name, value in known.items():
        if name.startswith("streets.") and inspect.isclass(value) and name[8:] not in known:
            continue  # what a pair holds is for trainings
        if getattr(value, "__module__", "").startswith(NETWORKS):
            continue
        for called, function in callables(name, value):
            for argument, hint in typing.get_type_hints(function, localns=known).items():
                for each in named_types(hint):
                    ours = each.__module__.startswith("lidardraft.") and each.__module__ != "lidardraft._core"
                    checked += ours
                    if ours and id(each) not in types:
                        hidden.add(f"{called}({argument}): {each.__module__}.{each.__name__}")
    assert not hidden
    assert checked > 150


def test_seeds_are_keywords() -> None:
    for name, value in public():
        for called, function in callables(name, value):
            seed = inspect.signature(function).parameters.get("seed")
            assert seed is None or called in RECORDS or seed.kind is seed.KEYWORD_ONLY, called


def seeded() -> dict[str, Callable[[Any], object]]:
    """A call of each function that takes a seed."""
    image = lidardraft.raycast(STREET, SENSOR, incidence=True)
    points = image.points()
    recorded = RecordedScan.from_points(points, SENSOR)
    simulator, caster = lidardraft.Simulator(STREET, SENSOR), lidardraft.Raycaster(STREET)
    pixels = np.full((50, 50, 3), 255, np.uint8)
    pose = SENSOR.pose()
    paper = lidardraft.Pipeline.from_pretrained("paper-small")
    return {
        "ObjectSampling": lambda seed: lidardraft.ObjectSampling({"car": 1}, SENSOR, models=1, seed=seed),
        "Pipeline.__call__": lambda seed: paper(STREET, sensor=SENSOR, seed=seed),
        "Pipeline.from_map": lambda seed: paper.from_map(image.label, sensor=SENSOR, seed=seed),
        "Pipeline.generate": lambda seed: paper.generate(image, seed=seed),
        "Raycaster.cast": lambda seed: caster.cast(np.zeros(3), np.eye(3), seed=seed),
        "Raycaster.scan": lambda seed: caster.scan(SENSOR, seed=seed),
        "Raycaster.scan_batch": lambda seed: caster.scan_batch(SENSOR, pose[None], seed=seed),
        "SequenceSimulator": lambda seed: lidardraft.SequenceSimulator(STREET, SENSOR, frames=1, seed=seed),
        "Simulator": lambda seed: lidardraft.Simulator(STREET, SENSOR, detail=False, seed=seed),
        "Simulator.scan": lambda seed: simulator.scan(seed=seed),
        "World": lambda seed: lidardraft.World(STREET, SENSOR, seed=seed),
        "detail": lambda seed: lidardraft.detail(STREET, seed=seed),
        "edit_scan": lambda seed: lidardraft.edit_scan(recorded, [], seed=seed),
        "layout_from_llm": lambda seed: lidardraft.layout_from_llm("a car", url="http://localhost:1", seed=seed),
        "layout_from_sketch": lambda seed: lidardraft.layout_from_sketch(pixels, metres_per_pixel=0.1, seed=seed),
        "layout_from_text": lambda seed: lidardraft.layout_from_text("a car", seed=seed),
        "observe_cast": lambda seed: lidardraft.observe_cast(image.depth, image.label, SENSOR, seed=seed),
        "observe_points": lambda seed: lidardraft.observe_points(points, image.label[image.valid], SENSOR, seed=seed),
        "raycast": lambda seed: lidardraft.raycast(STREET, SENSOR, seed=seed),
        "simulate": lambda seed: lidardraft.simulate(STREET, SENSOR, seed=seed),
        "street_drive": lambda seed: lidardraft.street_drive(0, seed=seed, frames=2),
        "street_scan": lambda seed: lidardraft.street_scan(0, seed=seed),
        "streets.make_street": lambda seed: streets.make_street(seed=seed),
        "streets.street_drive": lambda seed: streets.street_drive(0, seed=seed, frames=2),
        "streets.street_scan": lambda seed: streets.street_scan(0, seed=seed),
        "streets.streets": lambda seed: streets.streets(seed=seed),
        "surround": lambda seed: lidardraft.surround(STREET, seed=seed),
    }


def test_a_wrong_seed_is_one_error_everywhere() -> None:
    calls = seeded()
    takes = {called for n, v in public() for called, f in callables(n, v) if "seed" in inspect.signature(f).parameters}
    assert calls.keys() == takes - RECORDS
    for call in calls.values():
        for wrong in (-1, 1.5, True, "1", None, 2**63):
            expected = re.escape(f"seed is {wrong!r}; it must be an integer of 0 to 2^63 - 1")
            with pytest.raises(LayoutError, match=f"^{expected}$"):
                call(wrong)


def test_the_typed_script_uses_every_public_name() -> None:
    tree = ast.parse(SCRIPT.read_text())
    used = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    used |= {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    assert set(lidardraft.__all__) <= used


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_strict_type_checker_reads_every_name_and_finds_what_is_misspelt(tmp_path: Path) -> None:
    """All that `mypy --strict` finds is what is wrong."""
    more = [f"reveal_type(lidardraft.{name})" for name in lidardraft.__all__]
    wrong = {
        'lidardraft.simulate("a bus", sensor, sed=3)': 'Unexpected keyword argument "sed" for "simulate"',
        'lidardraft.layout_from_text("a bus", 3)': 'Too many positional arguments for "layout_from_text"',
        "Scan.from_points(points, sensor, labels=points)": 'Unexpected keyword argument "labels"',
        "Weather(rains=5.0)": 'Unexpected keyword argument "rains" for "Weather"',
        "lidardraft.Sensr": 'Module has no attribute "Sensr"',
    }
    body = "".join(f"    {line}\n" for line in (*more, *wrong))
    text = f"{SCRIPT.read_text()}\n\ndef misspelt(sensor: Sensor, points: np.ndarray) -> None:\n{body}"
    (tmp_path / "script.py").write_text(text)
    options = ("--strict", "--config-file=", "--follow-imports=silent", f"--cache-dir={tmp_path / 'cache'}")
    command = [sys.executable, "-m", "mypy", *options, "script.py"]
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    said = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=590).stdout
    revealed = re.findall(r'Revealed type is "(.*)"', said)
    assert len(revealed) == len(more)
    assert "Any" not in revealed
    for message in wrong.values():
        assert message in said
    assert said.count(" error: ") == len(wrong)


def test_a_scan_and_its_layout_have_no_notes_where_nothing_was_assumed() -> None:
    assert lidardraft.simulate(STREET, SENSOR, carrier=False).notes == ()


def test_scan_notes_are_those_of_the_layout_and_of_the_scan(tmp_path: Path) -> None:
    bare = Layout((BOX,), {"source": "test"}).noted("the car has no wheels")
    nothing = "the layout has no ground (road, sidewalk or terrain): nothing returns from it"
    with pytest.warns(UserWarning, match=re.escape(nothing)):
        simulator = lidardraft.Simulator(bare, SENSOR, carrier=False)
    scan = simulator.scan()
    assert scan.notes == ("the car has no wheels", nothing)
    assert scan.layout == bare
    scan.save(tmp_path / "scan", picture=False)
    assert Scan.load(tmp_path / "scan").notes == bare.notes  # what a scan assumed is in no file
    with pytest.warns(UserWarning, match="no ground"):
        (frame,) = lidardraft.SequenceSimulator(bare, SENSOR, frames=1, speed=0.0, carrier=False)
    assert frame.notes == scan.notes


def test_a_sentence_that_is_simulated_gets_a_street_and_a_layout_none(capsys: pytest.CaptureFixture[str]) -> None:
    bare = lidardraft.layout_from_text("a car", seed=2)
    assert lidardraft.simulate(bare, SENSOR, seed=2).layout == bare
    street = lidardraft.surround(bare, seed=2)
    hilly = lidardraft.simulate("a car", SENSOR, seed=2).layout
    assert hilly.primitives[: len(street)] == lidardraft.on_relief(street).primitives != street.primitives
    assert lidardraft.simulate("a car", SENSOR, seed=2, relief=False).layout.primitives == street.primitives
    with pytest.raises(SystemExit):
        main(["simulate", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "a layout, as `lidardraft draft` writes it; by itself it gets no street (see --surroundings)" in said
    for function in (lidardraft.simulate, lidardraft.layout_from_text):
        assert "`surround`" in str(function.__doc__)
