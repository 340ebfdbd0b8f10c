"""`lidardraft studio` as a command: it says where the page is, and ends clean."""

from __future__ import annotations

import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

from lidardraft import Layout, Sensor, World, layout_from_text
from lidardraft.cli import main as cli
from lidardraft.cli.studio import inputs_of

pytest.importorskip("viser", reason="viser is not installed (lidardraft[studio])")
from lidardraft.studio.editor import Editor
from lidardraft.studio.server import KEPT, served
from lidardraft.studio.session import Session


def hear_interrupts() -> None:
    """Ctrl-C reaches the process also when the tests run in the background, where it is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def started(*options: str) -> tuple[subprocess.Popen[str], str]:
    words = [sys.executable, "-m", "lidardraft", "studio", "--sensor", "vlp16", *options]
    pipe = subprocess.PIPE
    process = subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True, preexec_fn=hear_interrupts)
    assert process.stdout is not None
    return process, process.stdout.readline().split(" ")[0].strip()


@pytest.fixture
def layout(tmp_path: Path) -> Path:
    layout_from_text("a car ahead", seed=0).save(tmp_path / "a.layout.json")
    return tmp_path / "a.layout.json"


def test_it_serves_a_page_takes_a_free_port_and_ends_with_ctrl_c(layout: Path) -> None:
    first, url = started("--port", "8750", "--layout", str(layout))
    second, other = started("--port", url.rsplit(":", 1)[1], "--layout", str(layout))
    try:
        assert url.startswith("http://127.0.0.1:")
        assert other != url
        for each in (url, other):
            assert b"<html" in urllib.request.urlopen(each, timeout=10).read().lower()
    finally:
        for process in (first, second):
            process.send_signal(signal.SIGINT)
    said = []
    for process in (first, second):
        try:
            said.append(process.communicate(timeout=20)[1])
        finally:
            process.kill()  # of which a failure leaves nothing behind
    assert "is taken; the studio is on" in said[1]
    assert "Traceback" not in said[0]
    assert first.returncode == second.returncode == 130
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(url, timeout=5)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--layout", "nowhere.json"], "nowhere.json"),
        (["--text", "qwertz"], "qwertz"),
        (["--sensor", "hdl65e"], "did you mean 'hdl64e'"),
        (["--world", "a.layout.json"], "a.layout.json"),
        (["--weather", "hail:3mm"], "hail"),
        (["--detail", "fine"], "--detail goes with --points"),
        (["--llm-url", "http://localhost:9/v1", "--layout", "nowhere.json"], "nowhere.json"),
    ],
)
def test_a_bad_start_is_one_line(
    options: list[str], said: str, layout: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(layout.parent)
    assert cli.main(["studio", *options]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize("option", ["--num=2", "--speed=3", "--surroundings=street", "--frames=2"])
def test_the_state_of_a_world_says_all_of_its_scan(
    option: str, layout: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    world = World(Layout.load(layout), Sensor.preset("vlp16"))
    world.state().save(tmp_path / "a.world.json")
    assert cli.main(["simulate", "--world", str(tmp_path / "a.world.json"), option, "-o", str(tmp_path / "out")]) == 2
    assert "--world" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_scene_that_nobody_looks_at_goes_after_a_while(layout: Path) -> None:
    first = Layout.load(layout)
    with served(lambda: Editor(first, (Sensor.preset("vlp16"),)), inputs_of("vlp16", None), 8760) as studio:
        old, new = Session(Editor(first, (Sensor.preset("vlp16"),))), Session(Editor(first, (Sensor.preset("vlp16"),)))
        studio._sessions |= {"old": old, "new": new}
        old.used -= KEPT + 1.0
        studio.tidy()
        assert set(studio.sessions) == {"new"}
        old._thread.join(timeout=10.0)
        assert not old._thread.is_alive()
    new._thread.join(timeout=10.0)
    assert not new._thread.is_alive()
