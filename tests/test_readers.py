"""Whatever lies at a path, its reader gives what it holds, or one error of ours in one line that names the file."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from good_files import CAR, SENSOR, readers
from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.errors import LidarDraftError
from lidardraft.json_fields import parse_object
from lidardraft.scene.layout import Layout
from lidardraft.scene.sensor import Sensor
from spoiled_files import odd_paths, outcome, special_files, spoilings

READERS = readers()
LARGEST = 2**20  # bytes of a file that a test writes; `python benches/spoiled_files.py` reads the larger ones too
each_reader = pytest.mark.parametrize("name", READERS)


def refusal(reader: Callable[..., object], *arguments: object) -> str | None:
    """What the reader said of a file that it refused; None where it read it."""
    try:
        reader(*arguments)
    except LidarDraftError as error:
        return str(error)
    return None


def read_or_named(name: str, path: Path, data: bytes) -> None:
    path.write_bytes(data)
    said = refusal(READERS[name].read, path)
    assert said is None or (path.name in said and said.isprintable())


@each_reader
def test_a_good_file_is_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"good{READERS[name].ending}"
    path.write_bytes(READERS[name].good)
    assert refusal(READERS[name].read, path) is None


@each_reader
def test_what_is_no_file_that_can_be_read_is_refused_at_once(tmp_path: Path, name: str) -> None:
    none = tmp_path / f"none\x1b[31m{READERS[name].ending}"
    for kind, path in [*odd_paths(tmp_path, READERS[name].ending), ("missing", none)]:
        said = refusal(READERS[name].read, path)
        assert said is not None, kind
        assert path.stem.partition("\x1b")[0] in said, kind
        assert said.isprintable(), kind


@each_reader
def test_a_spoiled_file(tmp_path: Path, name: str) -> None:
    for _, data in spoilings(READERS[name]):
        read_or_named(name, tmp_path / f"spoiled{READERS[name].ending}", data)


def test_hostile_files(tmp_path: Path) -> None:
    for name, what, data in special_files(large=False):
        if len(data) <= LARGEST:
            read_or_named(name, tmp_path / f"{what}{READERS[name].ending}", data)


PUT = [b"9" * 400, b"9" * 5000, b"-1", b"nan", b"1e999", b"[]", b"{}", b"null", b'"', b"\x00" * 8, b"\xff" * 8]
EDITS = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 9), st.one_of(st.binary(max_size=6), st.sampled_from(PUT))),
    min_size=1,
    max_size=4,
)


@each_reader
@pytest.mark.filterwarnings("ignore::UserWarning")  # which say what was assumed of a file that is read
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(change=st.one_of(EDITS, EDITS, st.binary(max_size=400)))
@example(change=b"")
def test_errors_anywhere_in_a_file(tmp_path: Path, name: str, change: bytes | list[tuple[float, int, bytes]]) -> None:
    data = change if isinstance(change, bytes) else READERS[name].good
    for share, gone, put in () if isinstance(change, bytes) else change:
        at = int(share * len(data))
        data = data[:at] + put + data[at + gone :]
    read_or_named(name, tmp_path / f"a{READERS[name].ending}", data)


def test_what_a_reader_costs_is_measured(tmp_path: Path) -> None:
    (tmp_path / "a.txt").touch()

    def take(path: Path) -> None:
        raise LidarDraftError(f"{path} of {len(bytearray(2**26)) >> 20} MB")

    found = outcome("reader", "file", take, tmp_path / "a.txt")
    assert found.clear
    assert str(found.said).endswith("of 64 MB")
    assert found.memory > 50 * 2**20
    assert not outcome("reader", "file", lambda path: [path][1], tmp_path / "a.txt").clear


VALUES = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.sampled_from([10**400, -(10**400), 1e308, 2**63, float("nan"), float("inf"), "", "car", "box", "\x1b[31m"]),
        st.floats(),
        st.text(max_size=5),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.sampled_from(["id", "x", "kind"]), inner, max_size=3)
    ),
    max_leaves=8,
)
DOCUMENTS: dict[str, tuple[Callable[[str], object], dict[str, object]]] = {
    "layout": (Layout.from_json, json.loads(Layout((CAR,), {"seed": 1}, (-1.0, 1.0)).to_json())),
    "sensor": (Sensor.from_json, json.loads(SENSOR.to_json())),
    "spec": (
        lambda text: SceneSpec.from_dict(parse_object(text)),
        {
            "road": {"kind": "bend", "lanes": 2, "sidewalk": True},
            "groups": [{"kind": "car", "count": 3, "places": ["front"], "distance": [3.0, 9.0], "spacing": 2.0}],
            "absent": ["bus"],
            "not_understood": ["sky"],
        },
    ),
}


@pytest.mark.parametrize("name", DOCUMENTS)
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_documents_with_other_values_in_them(name: str, data: st.DataObject) -> None:
    parse, document = DOCUMENTS[name]
    document = json.loads(json.dumps(document))
    target: object = document
    while True:  # down to a place of any depth
        keys = list(target) if isinstance(target, dict) else list(range(len(target)))  # type: ignore[arg-type]
        key = data.draw(st.sampled_from(keys))
        inner = target[key]  # type: ignore[index]
        if isinstance(inner, dict | list) and inner and data.draw(st.booleans()):
            target = inner
            continue
        target[key] = data.draw(VALUES)  # type: ignore[index]
        break
    said = refusal(parse, json.dumps(document))
    assert said is None or said.isprintable()
