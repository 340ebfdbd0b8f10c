"""The file that a layout is written to: its ending says which format."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lidardraft.errors import FormatError
from lidardraft.scene.layout import Layout

ENDINGS = (".json", ".obj", ".glb", ".py")


def check_ending(path: str) -> None:
    """Raises `FormatError` where the ending of a path is none of a format that layouts are written in."""
    if Path(path).suffix.lower() not in ENDINGS:
        raise FormatError(f"{path}: a layout is written as {', '.join(ENDINGS)}; the ending says which")


def write_layout(path: str, layout: Layout) -> None:
    """Write a layout as JSON, Wavefront OBJ, binary glTF or a Blender script."""
    check_ending(path)
    _writer(Path(path).suffix.lower())(path, layout)


def _writer(ending: str) -> Callable[[str, Layout], None]:
    from lidardraft.formats.blender_script import write_blender_script
    from lidardraft.formats.glb import write_glb
    from lidardraft.formats.obj import write_obj

    writers: dict[str, Callable[[str, Layout], None]] = {
        ".obj": write_obj,
        ".glb": write_glb,
        ".py": write_blender_script,
    }
    return writers.get(ending, lambda path, layout: layout.save(path))
