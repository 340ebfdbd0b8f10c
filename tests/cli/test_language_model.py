"""--text through a language model: options, the environment, and what is said."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from lidardraft import Layout
from lidardraft.cli import main as cli
from replay_server import Answer, Drip, ReplayServer, llama_cpp

TEXT = "two cars ahead in the fog"
SPEC = {
    "road": {"kind": "straight"},
    "groups": [{"words": "two cars ahead", "kind": "car", "count": 2, "places": ["front"]}],
    "not_understood": ["in the fog"],
}
SCRIPT = """```python
import bpy
bpy.ops.mesh.primitive_cube_add(size=1, location=(12, 0, 1))
bpy.context.object.name = "car_1"
bpy.context.object.dimensions = (4.5, 1.8, 1.5)
bpy.ops.render.render()
```"""
DRAFT = ("draft", "--text", TEXT, "--surroundings", "bare", "--no-preview", "-o", "layout.json")


@pytest.fixture
def model(server: ReplayServer) -> tuple[str, ...]:
    """The options that name the model of the server."""
    return ("--llm-url", server.url, "--llm-model", "small")


def test_a_text_is_read_by_the_model(
    server: ReplayServer, model: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    server.answers = [llama_cpp(json.dumps(SPEC))]
    assert cli.main([*DRAFT, *model]) == 0
    assert capsys.readouterr().err == "lidardraft: not understood: in the fog\n"
    layout = Layout.load("layout.json")
    assert layout.provenance["llm"]["model"] == "small"
    assert len(layout.boxes()) == 2
    assert cli.main(["raycast", "--text", TEXT, *model, "--sensor", "small.json", "-o", "image.npz"]) == 0
    assert len(server.requests) == 1


def test_each_scan_has_a_layout_of_its_own_and_the_model_is_asked_once(
    server: ReplayServer, model: tuple[str, ...]
) -> None:
    server.answers = [llama_cpp(json.dumps(SPEC))]
    assert cli.main(["simulate", "--text", TEXT, *model, "--sensor", "small.json", "-n", "2", "-o", "scans"]) == 0
    layouts = [Layout.load(f"scans/00000{number}.layout.json") for number in (0, 1)]
    assert layouts[0].primitives != layouts[1].primitives
    assert [layout.provenance["source"] for layout in layouts] == ["llm", "llm"]
    assert len(server.requests) == 1


def test_the_environment_names_the_model_and_an_empty_url_none(
    server: ReplayServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LIDARDRAFT_LLM_URL", server.url)
    monkeypatch.setenv("LIDARDRAFT_LLM_MODEL", "small")
    server.answers = [llama_cpp(json.dumps(SPEC))]
    assert cli.main([*DRAFT, "--llm-cache", "kept"]) == 0
    assert Layout.load("layout.json").provenance["source"] == "llm"
    assert len(list(Path("kept").iterdir())) == 1
    assert cli.main([*DRAFT, "--llm-url", ""]) == 0
    assert Layout.load("layout.json").provenance["source"] == "text"
    assert len(server.requests) == 1


def test_the_model_writes_a_script(
    server: ReplayServer, model: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    server.answers = [llama_cpp(SCRIPT)] * 2
    assert cli.main([*DRAFT, *model, "--llm-blender"]) == 0
    notes = ["line 5: bpy.ops.render.render is passed over", "the sentence names 'two cars'; the reply has car: 1"]
    notes += ["car_1 floats 0.25 m over the ground"]
    assert capsys.readouterr().err.splitlines() == [f"lidardraft: {note}" for note in notes]
    assert [box.label for box in Layout.load("layout.json").boxes()] == ["car"]


def test_of_many_findings_the_first_are_told(
    server: ReplayServer, model: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    cube = "import bpy\nfor k in range(40):\n    bpy.ops.mesh.primitive_cube_add(location=(8 + 10 * k, 0, 1))\n"
    server.answers = [
        llama_cpp(f'{cube}    bpy.context.object.name = f"wall_{{k}}"\n    bpy.ops.render.render()\n')
    ] * 2
    assert cli.main([*DRAFT, *model, "--llm-blender"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 11
    assert lines[-1].endswith("more, in its notes")


def test_what_goes_wrong_is_one_line(server: ReplayServer, model: tuple[str, ...], refused: Callable[..., str]) -> None:
    server.answers = [Drip()]
    assert "no whole answer within 0.4 s" in refused(*DRAFT, *model, "--llm-timeout", "0.4")
    server.answers = [Answer({"error": {"message": "Invalid API Key\n\x1b[2J"}}, 401)]
    assert "401 Unauthorized: Invalid API Key" in refused(*DRAFT, *model)
    assert "--llm-model names it" in refused(*DRAFT, "--llm-url", server.url)
    assert "LIDARDRAFT_LLM_URL or --llm-url" in refused(*DRAFT, "--llm-model", "small")
    assert "LIDARDRAFT_LLM_URL or --llm-url" in refused(*DRAFT, "--llm-blender")
    assert "the time limit is 0.0" in refused(*DRAFT, *model, "--llm-timeout", "0")
    assert "the text has 0 characters" in refused("draft", "--text", "", *model, "-o", "layout.json")
    Path("file").write_text("")
    assert "file: cannot keep replies of language models" in refused(*DRAFT, *model, "--llm-cache", "file")
    assert len(server.requests) == 2


@pytest.mark.parametrize(
    "option",
    [("--llm-url", "x"), ("--llm-model", "x"), ("--llm-blender",), ("--llm-cache", "x"), ("--llm-timeout", "1")],
)
def test_options_of_the_model_go_with_text(refused: Callable[..., str], option: tuple[str, ...]) -> None:
    Path("layout.json").write_text("{}")
    said = refused("raycast", "--layout", "layout.json", *option, "-o", "image.npz")
    assert f"{option[0]} goes with --text" in said
