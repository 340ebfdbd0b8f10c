"""How well each input becomes a layout, in one command: sentences, the solver, Blender scripts, pictures, clouds,
sketches, and files that are spoiled.

`make report-inputs`. The parts of pictures and clouds need recordings, in the folder LIDARDRAFT_DATA.
"""

from __future__ import annotations

import importlib
import math
import os
import re
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import lidardraft
from drawn_sketches import DrawnBox, DrawnLine, Hand, painted
from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.errors import LayoutError, LidarDraftError, TextError
from lidardraft.scene.check import check
from lidardraft.semantics import BY_NAME
from spoiled_files import BYTES, SECONDS, outcome, outcomes

SEEDS = (0, 1, 2)
SPECS = 1000
SKETCHES = 20
_MIB = 2**20


def report_sentences() -> None:
    """Sentences that are understood as expected, with layouts in which every relation holds, for each seed."""
    from test_sentences import read_sentences

    from lidardraft.drafting.solver.scene_spec import relations
    from lidardraft.drafting.text.layout import spec_from_text

    sentences, passed = read_sentences(), 0
    for sentence in sentences:
        spec = spec_from_text(sentence.text)
        found = [text for text in relations(spec) if text != "road: straight"]
        right = found == sentence.relations and list(spec.not_understood) == sentence.unknown
        passed += right and all(_holds(sentence.text, spec, sentence.refusal, seed) for seed in SEEDS)
    print(f"  {passed} of {len(sentences)} sentences, each with seeds {SEEDS}")


def _holds(text: str, spec: SceneSpec, refusal: str, seed: int) -> bool:
    from spec_checker import broken

    try:
        layout = lidardraft.layout_from_text(text, seed=seed)
    except (LayoutError, TextError) as error:
        return bool(refusal) and re.search(refusal, str(error)) is not None
    return not refusal and not broken(spec, layout) and not check(layout)


def report_solver() -> None:
    """Random specs whose layouts an independent checker finds right, alone and in the street around them."""
    from test_layout_from_spec import random_spec
    from test_surround import faults

    from lidardraft.drafting.solver.layout import layout_from_spec
    from spec_checker import broken

    held = surrounded = refused = 0
    for number in range(SPECS):
        spec = random_spec(np.random.default_rng([7, number]))
        try:
            layout = layout_from_spec(spec, seed=number)
        except LayoutError:
            refused += 1
            continue
        held += not broken(spec, layout) and not check(layout)
        surrounded += not faults(layout, lidardraft.surround(layout, seed=number))
    print(f"  of {SPECS} specs every relation holds in {held}; refused: {refused}; broken: {SPECS - held - refused}")
    print(f"  in the street around it nothing is touched, hidden or counted wrong in {surrounded}")


def report_scripts() -> None:
    """Hostile Blender scripts that are refused with their line, and what the worst of them cost."""
    from hostile_scripts import HOSTILE, says_where

    refused, seconds, memory = 0, 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.py"
        for name, script, line in HOSTILE:
            path.write_text(script, encoding="utf-8", errors="surrogatepass")
            found = outcome("blender", name, lidardraft.layout_from_blender, path)
            refused += says_where(str(found.said), script, line)
            seconds, memory = max(seconds, found.seconds), max(memory, found.memory)
    cost = f"{seconds:.2f} s and {memory / _MIB:.0f} MB"
    print(f"  {refused} of {len(HOSTILE)} refused with their line; each takes {cost} at most")


def report_recorded(name: str) -> None:
    """What another report prints, of recordings too."""
    if not Path(os.environ.get("LIDARDRAFT_DATA", "")).is_dir() or "LIDARDRAFT_DATA" not in os.environ:
        print("  left out: LIDARDRAFT_DATA names no folder of recordings")
    else:
        sys.argv = [name]
        importlib.import_module(name).main()


def drawn_scene(seed: int) -> list[DrawnBox | DrawnLine]:
    """A road and objects beside and on it, apart from each other."""
    rng = np.random.default_rng(seed)
    shapes: list[DrawnBox | DrawnLine] = [DrawnLine("road", np.array([(-40.0, 0.0), (40.0, 0.0)]), 8.0)]
    rows = {"car": (-2.0, 2.0), "bus": (2.0,), "truck": (-2.0,), "building": (-18.0, 18.0), "bicycle": (6.5,)}
    taken: list[tuple[float, float, float]] = []
    for label in ("building", "building", "building", "bus", "truck", "car", "car", "car", "car", "bicycle"):
        length, width, _ = BY_NAME[label].size or (rng.uniform(8, 14), rng.uniform(7, 10), 0)
        for _ in range(50):
            x, y = float(rng.uniform(-32, 32)), float(rng.choice(rows[label]))
            reach = (length + 2.0) / 2
            if all(abs(x - other) > reach + size or abs(y - beside) > 3.0 for other, beside, size in taken):
                taken.append((x, y, length / 2))
                yaw = float(rng.uniform(-0.15, 0.15)) + (math.pi if y > 0 else 0.0)
                shapes.append(DrawnBox(label, (x, y), float(length), float(width), yaw))
                break
    return shapes


def report_sketches() -> None:
    """Objects of painted scenes with the wobble of a hand that are found again, and how far off they are."""
    drawn = found = invented = 0
    centers, yaws, seconds = [], [], 0.0
    for seed in range(SKETCHES):
        shapes = drawn_scene(seed)
        boxes = [shape for shape in shapes if isinstance(shape, DrawnBox)]
        begun = time.process_time()
        layout = lidardraft.layout_from_sketch(painted(shapes, hand=Hand(seed, 0.08)), metres_per_pixel=0.1)
        seconds = max(seconds, time.process_time() - begun)
        standing = [primitive for primitive in layout if primitive.label not in ("terrain", "road")]
        drawn += len(boxes)
        for box in boxes:
            near = [one for one in standing if one.label == box.label and math.dist(one.center[:2], box.center) < 1.0]
            if near:
                found += 1
                standing.remove(near[0])
                centers.append(math.dist(near[0].center[:2], box.center))
                if box.label != "building":
                    yaws.append(abs(math.degrees(math.remainder(near[0].yaw - box.yaw, math.tau))))
        invented += len(standing)
    print(f"  {found} of {drawn} objects of {SKETCHES} sketches found within 1 m, and {invented} that nobody drew")
    print(f"  centres off by {np.median(centers):.2f} m (median), {max(centers):.2f} m (most)")
    print(f"  headings off by {np.median(yaws):.1f} (median), {max(yaws):.1f} degrees (most); {seconds:.1f} s at most")


def report_spoiled_files() -> None:
    """Bad files that end in one clear line, and what the worst of them cost."""
    with tempfile.TemporaryDirectory() as folder:
        found = list(outcomes(Path(folder)))
    clear = sum(each.clear for each in found)
    slow, large = max(found, key=lambda each: each.seconds), max(found, key=lambda each: each.memory)
    print(f"  {clear} of {len(found)} files are read or end in one line that names the file")
    print(f"  longest: {slow.seconds:.2f} s of {SECONDS:g} s, {slow.reader}, {slow.file}")
    print(f"  most memory: {large.memory / _MIB:.0f} of {BYTES / _MIB:.0f} MB, {large.reader}, {large.file}")
    for each in found:
        if not each.clear or each.seconds > SECONDS or each.memory > BYTES:
            cost = f"{each.seconds:.2f} s, {each.memory / _MIB:.0f} MB"
            print(f"  not kept: {each.reader}, {each.file}: {cost}, {each.said}")


PARTS: dict[str, Callable[[], None]] = {
    "sentences": report_sentences,
    "solver": report_solver,
    "Blender scripts": report_scripts,
    "images": partial(report_recorded, "report_image"),
    "clouds": partial(report_recorded, "report_cloud"),
    "sketches": report_sketches,
    "bad files": report_spoiled_files,
}


def main() -> None:
    """Print all parts, or those whose names are given."""
    tests = Path(__file__).parents[1] / "tests"
    drafting = tests / "drafting"
    rooms = (tests, tests / "simulation", drafting, drafting / "text", drafting / "solver", drafting / "blender")
    sys.path[:0] = map(str, rooms)
    wanted = sys.argv[1:]
    for name, report in PARTS.items():
        if not wanted or name in wanted:
            print(f"{name}:", flush=True)
            try:
                report()
            except (ImportError, LidarDraftError) as error:
                print(f"  left out: {error}")


if __name__ == "__main__":
    main()
