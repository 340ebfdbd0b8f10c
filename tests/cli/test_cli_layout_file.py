from pathlib import Path

import pytest

from lidardraft import Layout, Primitive
from lidardraft.cli.layout_file import ENDINGS, write_layout
from lidardraft.errors import FormatError

CAR = Layout((Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="car_1", instance=1),))
BEGINNINGS = {
    ".json": b'{"schema": "lidardraft.layout/1"',
    ".obj": b"# a layout",
    ".glb": b"glTF",
    ".py": b'"""A layout',
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_each_ending_is_its_format(ending: str) -> None:
    for path in (f"a{ending}", f"b{ending.upper()}"):
        write_layout(path, CAR)
        assert Path(path).read_bytes().startswith(BEGINNINGS[ending])


def test_other_endings_are_refused() -> None:
    with pytest.raises(FormatError, match=r"a\.blend: a layout is written as \.json, \.obj, \.glb, \.py"):
        write_layout("a.blend", CAR)
