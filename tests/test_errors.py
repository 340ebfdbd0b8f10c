import importlib
import pickle
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lidardraft
from lidardraft import Layout, Sensor
from lidardraft.errors import EXTRAS, FormatError, MissingExtraError, did_you_mean, extra, nearest_name, one_of

SENSOR = Sensor(name="small", elevations=(0.0, -0.1), columns=8)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("carr", "one of car, bus, traffic-sign; did you mean 'car'?"),
        ("Traffic_Sign", "one of car, bus, traffic-sign; did you mean 'traffic-sign'?"),
        ("zeppelin", "one of car, bus, traffic-sign"),
        (None, "one of car, bus, traffic-sign"),
    ],
)
def test_the_name_that_was_meant_is_suggested(value: object, said: str) -> None:
    assert one_of(("car", "bus", "traffic-sign"), value) == said
    assert did_you_mean(["House_1"], "huose_1") == "; did you mean 'House_1'?"


WORDS = (
    *("ahead", "area", "behind", "bench", "bicycle", "both", "building", "can", "chat", "crowd", "driver", "from"),
    *("hedge", "house", "junction", "lamp", "lane", "motorcycle", "near", "park", "parked", "pedestrian", "people"),
    *("ride", "rider", "right", "road", "roundabout", "shop", "street", "that", "traffic", "train", "tree"),
    *("trees", "truck", "vehicle", "while"),
)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        *(("trcuk", "truck"), ("pedestrain", "pedestrian"), ("tress", "trees"), ("bicylce", "bicycle")),
        *(("roundabuot", "roundabout"), ("huose", "house"), ("biulding", "building"), ("raod", "road")),
        *(("behnd", "behind"), ("parkd", "parked"), ("hegde", "hedge"), ("peple", "people"), ("rigth", "right")),
        *(("houuse", "house"), ("motorcylce", "motorcycle"), ("Trafic", "traffic"), ("juncton", "junction")),
    ],
)
def test_a_misspelled_word_is_near_to_the_one_that_was_meant(typed: str, meant: str) -> None:
    assert nearest_name(WORDS, typed) == meant


@pytest.mark.parametrize(
    "word",
    [
        *("mouse", "bridge", "plane", "rain", "tent", "zebra", "igloo"),
    ],
)
def test_another_word_is_near_to_none(word: str) -> None:
    assert nearest_name(WORDS, word) is None


def test_control_characters_of_names_and_values_are_escaped() -> None:
    message = str(FormatError("a\x1b[31m\n\u202e\udc80.bin: b\x07"))
    assert message == r"a\x1b[31m\n\u202e\udc80.bin: b\x07"
    assert message.isprintable()


def test_a_message_that_quotes_too_much_is_cut_in_its_middle() -> None:
    message = str(FormatError(f"id is {'x' * 10**6}; it must be short"))
    assert len(message) < 2100
    assert message.startswith("id is xxx")
    assert message.endswith("xxx; it must be short")


def test_errors_can_go_to_another_process() -> None:
    error = pickle.loads(pickle.dumps(FormatError("a\nb")))
    assert str(error) == r"a\nb"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lidardraft.raycast(None, SENSOR), "layout is a NoneType; it must be a Layout"),
        (lambda: lidardraft.raycast(Layout(), "hdl64e"), "sensor is a str; it must be a Sensor"),
        (lambda: lidardraft.Raycaster("a bus"), "layout is a str; it must be a Layout"),
        (lambda: lidardraft.Raycaster(Layout()).scan_batch("hdl64e", np.eye(4)[None]), "sensor is a str"),
        (lambda: lidardraft.simulate("a bus", "hdl64e"), "sensor is a str; it must be a Sensor"),
        (lambda: lidardraft.simulate(["a bus"], SENSOR), "layout is a list; it must be a Layout or str"),
        (lambda: lidardraft.detail("a bus"), "layout is a str; it must be a Layout"),
        (lambda: lidardraft.Pipeline("paper"), "denoiser is a str; it must be a Denoiser"),
        (lambda: lidardraft.Pipeline.from_pretrained(None), "name is a NoneType; it must be a str or PathLike"),
        (lambda: lidardraft.Pipeline.from_pretrained("paper-small")(None), "source is a NoneType; it must be a str or"),
        (lambda: lidardraft.layout_from_text(None), "sentence is a NoneType; it must be a str"),
        (lambda: lidardraft.layout_from_llm(b"a bus"), "text is a bytes; it must be a str"),
        (lambda: lidardraft.layout_from_cloud([(1, 2, 3)], np.ones(1)), "points is a list; it must be a ndarray"),
        (lambda: lidardraft.layout_from_cloud(np.ones((1, 3)), [3]), "labels is a list; it must be a ndarray"),
        (lambda: lidardraft.layout_from_boxes(None), "boxes is a NoneType; it must be a Sequence"),
        (lambda: lidardraft.layout_from_boxes(["car"]), "box 0 is a str; it must be a Box"),
        (lambda: lidardraft.layout_from_blender(None), "script is a NoneType; it must be a str or PathLike"),
        (lambda: lidardraft.layout_from_sketch(None), "sketch is a NoneType; it must be a ndarray or str or PathLike"),
        (lambda: lidardraft.layout_from_image(None), "image is a NoneType; it must be a ndarray or str or PathLike"),
        (lambda: lidardraft.layout_from_glb(None), "path is a NoneType; it must be a str or PathLike"),
        (lambda: lidardraft.layout_from_obj(None), "path is a NoneType; it must be a str or PathLike"),
    ],
)
def test_an_argument_of_another_type_is_named(call: Callable[[], object], message: str) -> None:
    with pytest.raises(TypeError, match=f"^{message}"):
        call()


@pytest.mark.parametrize(("library", "names"), EXTRAS.items())
def test_a_missing_library_names_an_extra_that_brings_it(
    library: str, names: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    for preferred in ("", "export", "image"):
        name = preferred if preferred in names else names[0]
        said = re.escape(f"{library} is not installed; run: pip install 'lidardraft[{name}]'")
        with pytest.raises(MissingExtraError, match=f"^{said}$"), extra(preferred):
            importlib.import_module(library)


def test_another_missing_library_is_no_extra() -> None:
    with pytest.raises(ModuleNotFoundError, match="No module named 'llama_of_ours'") as caught, extra():
        importlib.import_module("llama_of_ours")
    assert not isinstance(caught.value, MissingExtraError)


def test_the_extras_bring_what_the_table_says() -> None:
    tomllib = pytest.importorskip("tomllib")
    listed = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    modules = {"ouster-sdk": "ouster"}
    brought: dict[str, set[str]] = {"huggingface_hub": {"image"}}  # which transformers depends on
    for name, needed in listed["optional-dependencies"].items():
        if name in ("dev", "bench", "docs"):
            continue
        for one in needed:
            library = re.split(r"[\[>]", one)[0]
            for module in ["torch"] if one == "lidardraft[generate]" else [modules.get(library, library)]:
                brought.setdefault(module, set()).add(name)
    assert {library: set(names) for library, names in EXTRAS.items()} == brought
