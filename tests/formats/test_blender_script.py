import ast
from pathlib import Path

import pytest
from exported_layouts import EVERYTHING, drafted

from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.formats.blender_script import blender_script, write_blender_script
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import BY_NAME


@pytest.mark.parametrize("layout", [EVERYTHING, Layout((EVERYTHING.primitives[0],)), *drafted()])
def test_a_layout_comes_back_to_the_last_digit(layout: Layout) -> None:
    assert layout_from_blender(blender_script(layout)) == layout


def test_names_from_others_stay_text() -> None:
    name = "\"); import os; os.system('x') # '''\\ "
    layout = Layout((Primitive(shape="box", center=(1, 2, 3), size=(1, 1, 1), label="wall", id=name),), {"x": name})
    script = blender_script(layout)
    imports = [node for node in ast.walk(ast.parse(script)) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert [alias.name for node in imports for alias in node.names] == ["bpy"]
    assert layout_from_blender(script) == layout


def test_three_thousand_shapes_of_all_classes_are_read_within_the_limits() -> None:
    labels, shapes = list(BY_NAME)[1:], ("box", "cylinder", "ellipsoid")
    primitives = tuple(
        Primitive(
            shape=shapes[k % 3],
            center=(k / 7, k / 9, k / 11),
            size=(1 / 3, 1 / 3, 4 / 3),
            yaw=k / 3000,
            label=labels[k % len(labels)],
            id=f"shape_{k}",
            instance=k,
            extinction=0.5 if k % 60 == 2 else None,
        )
        for k in range(3000)
    )
    assert layout_from_blender(blender_script(Layout(primitives))) == Layout(primitives)


def test_it_is_written_whole(tmp_path: Path) -> None:
    write_blender_script(tmp_path / "a.py", EVERYTHING)
    assert (tmp_path / "a.py").read_text(encoding="utf-8") == blender_script(EVERYTHING)
    assert layout_from_blender(tmp_path / "a.py") == EVERYTHING


def test_any_printable_character_may_be_in_a_name() -> None:
    names = ["a|b", "\u2502 |", " both ends ", 'two"""quotes', "back\\slash\\", "é\U0001f600", "{x}"]
    shapes = tuple(
        Primitive(shape="plane", center=(k, 0, 0), size=(2, 1, 0), label="road", id=name)
        for k, name in enumerate(names)
    )
    assert layout_from_blender(blender_script(Layout(shapes))) == Layout(shapes)
