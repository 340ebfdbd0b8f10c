"""Scripts of several kinds, what is said of them, and, where there is one, the real Blender beside ours."""

import json
import os
import random
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft import Sensor, layout_from_text
from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.drafting.blender.script.limits import ScriptLimits
from lidardraft.errors import FormatError, LidarDraftError, ScriptError
from lidardraft.formats.blender_script import blender_script, write_blender_script
from lidardraft.scene.check import check
from lidardraft.scene.layout import primitive_mesh
from lidardraft.view import render_layout_and_cast, save_png

HERE = Path(__file__).parent
SCRIPTS = sorted((HERE / "scripts").glob("*.py"))
BLENDER = os.environ.get("LIDARDRAFT_BLENDER")  # a Python that can `import bpy`
CAR = "import bpy\nbpy.ops.mesh.primitive_cube_add(location=(5, 0, 1))\nbpy.context.object.name = 'Car'\n"


def test_a_street_as_a_language_model_writes_it() -> None:
    layout = layout_from_blender(HERE / "scripts" / "street.py")
    labels = [primitive.label for primitive in layout]
    assert {label: labels.count(label) for label in dict.fromkeys(labels)} == {
        "road": 1,
        "sidewalk": 2,
        "car": 3,
        "trunk": 12,
        "vegetation": 12,
        "building": 12,
    }
    assert {primitive.shape for primitive in layout} == {"plane", "box", "cylinder", "ellipsoid"}
    assert [box.id for box in layout.boxes()] == ["Lead_Car", "Car", "Car_001"]
    assert layout["Lead_Car"].size == (4.5, 1.8, 1.5)
    assert not [finding for finding in check(layout) if finding.check in ("size", "on_road", "ego_clear", "in_range")]
    assert layout.provenance["source"] == "street.py"
    assert any("bpy" not in note and note.startswith("line ") for note in layout.notes)


def test_the_picture_of_the_docs_shows_what_is_read_now(tmp_path: Path) -> None:
    """docs/images/blender.png; where it is out of date, copy the file that the message names there."""
    layout = layout_from_blender(HERE / "scripts" / "street.py")
    picture = render_layout_and_cast(layout, Sensor.preset("hdl64e"))
    save_png(tmp_path / "blender.png", picture)
    with Image.open(HERE.parents[2] / "docs" / "images" / "blender.png") as image:
        shown = np.asarray(image)
    assert shown.shape == picture.shape, tmp_path
    different = (np.abs(shown.astype(int) - picture) > 2).any(axis=2)
    assert different.mean() < 0.001, tmp_path


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_gives_the_same_layout_again(path: Path) -> None:
    assert layout_from_blender(path) == layout_from_blender(path)
    assert layout_from_blender(str(path)) == layout_from_blender(path)
    text = layout_from_blender(path.read_text())
    assert text.primitives == layout_from_blender(path).primitives
    assert text.provenance["source"] == "blender"


def test_a_script_without_a_seed_says_that_0_is_taken() -> None:
    layout = layout_from_blender("import random\n" + CAR + "bpy.context.object.location.x = random.random()")
    assert layout.primitives[0].center[0] == random.Random(0).random()
    assert "line 5: random numbers without a seed: the seed 0 is taken" in layout.notes


def test_a_script_that_makes_nothing_says_what_was_passed_over() -> None:
    with pytest.raises(ScriptError, match=r"^line 2: the script has made no object with a surface$"):
        layout_from_blender("import bpy\nbpy.ops.object.empty_add()")
    with pytest.raises(ScriptError, match=r"no object with a surface; line 2: bpy.ops.render.render is passed over"):
        layout_from_blender("import bpy\nbpy.ops.render.render()")


def test_limits_are_the_callers() -> None:
    many = "import bpy\nfor k in range(9):\n    bpy.ops.mesh.primitive_cube_add()\n    bpy.context.object.name = 'Car'"
    assert len(layout_from_blender(many)) == 9
    with pytest.raises(ScriptError, match=r"^line 3: more than 8 objects$"):
        layout_from_blender(many, limits=ScriptLimits(objects=8))
    mesh = CAR + "bpy.ops.mesh.primitive_torus_add()\nbpy.context.object.name = 'Car'"
    with pytest.raises(ScriptError, match="the scene has 576 vertices; the limit is 500"):
        layout_from_blender(mesh, limits=ScriptLimits(vertices=500))


def test_files_that_are_no_script(tmp_path: Path) -> None:
    path = tmp_path / "a.py"
    for data in (b"x = 1\n\xff\xfe", b"x = 1\ny = '\xed\xa0\x80'", b"# coding: latin-1\nx = '\xe9'"):
        path.write_bytes(data)
        with pytest.raises(ScriptError, match=r"a\.py: line 2: no text in UTF-8: byte \d+ of the file is wrong"):
            layout_from_blender(path)
    path.write_bytes(b"\xef\xbb\xbf" + CAR.encode())
    assert len(layout_from_blender(path)) == 1
    path.write_text("import bpy\nimport os\nos.remove('a')")
    with pytest.raises(ScriptError, match=r"a\.py: line 3: os.remove is not supported"):
        layout_from_blender(path)
    with open(path, "wb") as file:
        file.truncate(10**8)
    with pytest.raises(FormatError, match=r"a\.py has 100000000 bytes; scripts of up to 16000000 are read"):
        layout_from_blender(path)


def test_what_travels_with_an_exported_layout_is_checked() -> None:
    for value in ("5", "'{'", "'[]'", "'{\"provenance\": {}}'"):
        with pytest.raises(ScriptError, match="the property 'lidardraft' of the scene is not what an export writes"):
            layout_from_blender(CAR + f"bpy.context.scene['lidardraft'] = {value}")
    for value in ('\'{"provenance": 5, "coverage": null}\'', '\'{"provenance": {}, "coverage": [1]}\''):
        with pytest.raises(LidarDraftError):
            layout_from_blender(CAR + f"bpy.context.scene['lidardraft'] = {value}")


def world_bounds(path: Path) -> dict[str, list[list[float]]]:
    """What the real Blender makes of a script: the bounds of each mesh object, by its name."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
        resource.setrlimit(resource.RLIMIT_AS, (8 * 2**30, 8 * 2**30))

    command = [BLENDER or "", str(HERE / "blender_bounds.py"), str(path)]
    run = subprocess.run(
        command, capture_output=True, text=True, timeout=100, preexec_fn=limit, env={"HOME": "/nonexistent"}
    )
    assert run.returncode == 0, run.stderr[-1000:]
    return json.loads(next(line for line in run.stdout.splitlines() if line.startswith("BOUNDS"))[6:])


def assert_same_bounds(path: Path) -> None:
    """Every object of the real Blender is a primitive of ours, and at the same place, to Blender's float32."""
    theirs = world_bounds(path)
    named = path.with_suffix(".named.py")  # where each object's id is its name
    named.write_text(path.read_text() + "\nfor item in bpy.data.objects:\n    item['id'] = item.name\n")
    ours = {primitive.id: primitive for primitive in layout_from_blender(named)}
    assert ours.keys() == theirs.keys()
    for name, (low, high) in theirs.items():
        vertices, extent = primitive_mesh(ours[name]).vertices, max(np.subtract(high, low))
        np.testing.assert_allclose(vertices.min(axis=0), low, atol=1e-5 * extent + 1e-5, err_msg=name)
        np.testing.assert_allclose(vertices.max(axis=0), high, atol=1e-5 * extent + 1e-5, err_msg=name)


@pytest.mark.skipif(not BLENDER, reason="LIDARDRAFT_BLENDER names no Python that has bpy")
@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_blender_itself_puts_every_object_there(tmp_path: Path, path: Path) -> None:
    copy = tmp_path / path.name
    copy.write_text(path.read_text())
    assert_same_bounds(copy)


@pytest.mark.skipif(not BLENDER, reason="LIDARDRAFT_BLENDER names no Python that has bpy")
@pytest.mark.parametrize(
    "sentence", ["two parked cars on the left, trees along both sides, houses", "a busy crossroads"]
)
def test_blender_itself_runs_what_is_exported(tmp_path: Path, sentence: str) -> None:
    path = tmp_path / "exported.py"
    layout = layout_from_text(sentence, seed=2)
    write_blender_script(path, layout)
    assert layout_from_blender(blender_script(layout)) == layout
    assert_same_bounds(path)


@pytest.mark.skipif(not BLENDER, reason="LIDARDRAFT_BLENDER names no Python that has bpy")
def test_blender_itself_reads_and_writes_our_glb(tmp_path: Path) -> None:
    """A layout that goes through Blender as GLB keeps its shapes, classes, ids and places."""
    from lidardraft.drafting.models import layout_from_glb
    from lidardraft.formats.glb import write_glb

    layout = layout_from_text("two parked cars on the left, trees along both sides, houses", seed=2)
    write_glb(tmp_path / "a.glb", layout)
    code = (
        "import bpy\nbpy.ops.wm.read_factory_settings(use_empty=True)\n"
        f"bpy.ops.import_scene.gltf(filepath={str(tmp_path / 'a.glb')!r})\n"
        f"bpy.ops.export_scene.gltf(filepath={str(tmp_path / 'b.glb')!r}, export_extras=True)\n"
    )
    run = subprocess.run([BLENDER or "", "-c", code], capture_output=True, text=True, timeout=100)
    assert run.returncode == 0, run.stderr[-1000:]
    found = {primitive.id: primitive for primitive in layout_from_glb(tmp_path / "b.glb")}
    assert found.keys() == {primitive.id for primitive in layout}
    for was in layout:
        is_ = found[was.id]
        assert (is_.shape, is_.label, is_.instance) == (was.shape, was.label, was.instance)
        np.testing.assert_allclose(is_.center, was.center, atol=1e-4)
        np.testing.assert_allclose(sorted(is_.size), sorted(was.size), atol=1e-4)


def test_nothing_of_a_script_is_run() -> None:
    """Not even what is imported: the reader's process knows no `bpy`."""
    code = (
        "import sys; from pathlib import Path; from lidardraft import layout_from_blender\n"
        f"layout_from_blender(Path({str(SCRIPTS[0])!r}))\nassert not {{'bpy', 'mathutils'}} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
