"""The command itself: what a stranger sees first, options and their values, and how commands end."""

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import lidardraft
from lidardraft.cli import main as cli
from lidardraft.cli import train
from lidardraft.cli.command import progress
from lidardraft.errors import EXTRAS

ROOT = Path(__file__).parents[2]


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *command], capture_output=True, text=True)


def test_the_version_is_that_of_the_package() -> None:
    for file in ("pyproject.toml", "Cargo.toml"):
        assert re.search(r'^version = "(.+)"$', (ROOT / file).read_text(), re.MULTILINE)[1] == lidardraft.__version__
    result = run("-m", "lidardraft", "--version")
    assert (result.returncode, result.stdout) == (0, f"lidardraft {lidardraft.__version__}\n")
    assert run("-m", "lidardraft.cli.train", "--version").stdout == result.stdout


def test_without_a_command_the_help_says_where_to_start(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 2
    text = capsys.readouterr().err
    first = [line for line in text.splitlines() if line.startswith("  lidardraft ")]
    assert len(first) >= 2
    for line in first:
        cli.parser().parse_args(shlex.split(line)[1:])


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; from lidardraft.cli.main import main\n"
        "for argv in (['--help'], ['generate', '--help']):\n"
        "    try: main(argv)\n"
        "    except SystemExit: print(sorted({'torch', 'sklearn', 'scipy', 'PIL'} & set(sys.modules)))"
    )
    result = run("-c", code)
    assert result.stdout.count("usage: lidardraft") == result.stdout.count("\n[]\n") == 2


def test_every_help_has_an_example_that_its_command_takes() -> None:
    for name, of in (("lidardraft", cli), ("lidardraft-train", train)):
        for command, (_, _, example) in of.COMMANDS.items():
            words = shlex.split(example.partition(" > ")[0])
            assert words[:2] == [name, command]
            assert of.parser([command]).parse_args(words[1:]).command


def test_help_declares_the_asked_command_alone(capsys: pytest.CaptureFixture[str]) -> None:
    code = "import sys; from lidardraft.cli.main import main; main(['--help'])"
    code = f"import atexit, sys; atexit.register(lambda: print('numpy' in sys.modules)); {code}"
    assert run("-c", code).stdout.endswith("\nFalse\n")
    with pytest.raises(SystemExit, match="0"):
        cli.main(["doctor", "--help"])
    assert "lidardraft doctor --json" in capsys.readouterr().out


def test_quiet_and_json(capsys: pytest.CaptureFixture[str]) -> None:
    draft = ["draft", "--text", "a car ahead and a purple dinosaur", "--no-preview", "-o", "layout.json"]
    assert cli.main([*draft, "--quiet"]) == 0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "dinosaur" in captured.err
    assert cli.main([*draft, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["output"] == "layout.json"
    assert cli.main(["raycast", "--layout", "layout.json", "--sensor", "vlp16", "-o", "cast.npz", "--json"]) == 0
    assert 0.2 < json.loads(capsys.readouterr().out)["hit"] <= 1


def test_a_log_gets_a_line_a_minute(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    now = [1e9]
    monkeypatch.setattr("tqdm.std.time", lambda: now[0])

    def shown(scans: int, seconds: float) -> list[str]:
        with progress(scans, "scan", "streets") as bar:
            for _ in range(scans):
                now[0] += seconds
                bar.update()
        return [line.partition(" [")[0] for line in capsys.readouterr().err.splitlines()]

    assert shown(10, 5.9) == []
    assert shown(10, 25.0) == [f"streets:  {k}0% {k}/10" for k in (3, 6, 9)]


def test_commands_show_progress_in_a_log_and_none_with_quiet(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("lidardraft.cli.command._EVERY", 0.0)
    simulate = ["simulate", "--text", "a car ahead", "--sensor", "vlp16", "-n", "2", "--jobs", "1", "--no-picture"]
    assert cli.main([*simulate, "-o", "loud"]) == 0
    assert re.findall(r"^\d+% \d/2 ", capsys.readouterr().err, re.M) == ["0% 0/2 ", "50% 1/2 ", "100% 2/2 "]
    assert cli.main([*simulate, "-q", "-o", "quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_an_output_may_be_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead", "-o", "made/"]) == 0
    assert cli.main(["raycast", "--layout", "made/layout.json", "--sensor", "vlp16", "-o", "made"]) == 0
    names = {"layout.json", "layout.preview.png", "cast.npz", "cast.layout.json"}
    assert {path.name for path in Path("made").iterdir()} == names
    assert "made/cast.npz: vlp16" in capsys.readouterr().out


def test_doctor_says_what_is_here_and_how_to_get_the_rest(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["doctor", "--json"]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert rows[0]["version"] == lidardraft.__version__
    assert "reference" in rows[1]["backends"]
    libraries = {row["library"]: row["found"] for row in rows if "library" in row}
    assert libraries.keys() == EXTRAS.keys()
    assert libraries["shtab"][0].isdigit()
    assert cli.main(["doctor"]) == 0
    missing = [name for name, found in libraries.items() if found is None]
    assert capsys.readouterr().out.count("missing; pip install 'lidardraft[") == len(missing)


def test_a_shell_completes_commands_and_options(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["completion", "bash"]) == 0
    Path("completion").write_text(capsys.readouterr().out)
    typed = "COMP_WORDS=(lidardraft simulate --scen); COMP_CWORD=2; _shtab_lidardraft lidardraft --scen simulate"
    code = f"source ./completion; {typed}; echo ${{COMPREPLY[@]}}"
    assert subprocess.run(["bash", "-c", code], capture_output=True, text=True).stdout == "--scenario\n"


@pytest.mark.parametrize("command", ["generate", "view", "draft", "raycast", "streets", "evaluate"])
def test_every_option_has_a_help_text(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        cli.main([command, "--help"])
    help_text = re.sub(r"\n {8,}", " ", capsys.readouterr().out)
    options = re.findall(r"^  (-.*)$", help_text.split("options:")[1], re.MULTILINE)
    assert len(options) >= 3
    for option in options:
        assert re.search(r"\S {1,}[a-z].{8}", option.split("  ")[-1]) or len(option.split()) > 4, option
    assert not re.search(r"drawing|drawn|\bthings?\b", help_text)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("simulate --sensr vlp16 --text car -o out", "there is no option --sensr; did you mean '--sensor'?"),
        ("simulate --txet=car -o out", "there is no option --txet; did you mean '--text'?"),
        ("simulate --text car --layout a.json -o out", "argument --layout: not allowed with argument --text"),
        ("simulate -o out", "one of the arguments --text --image"),
        ("simulate --text car", "the following arguments are required: -o/--output"),
        ("simulate --text car -o out -n some", "argument -n/--num: 'some' is not a whole number of 1 or more"),
        ("simulate --text car -o out -z 3", "not understood: -z 3"),
        ("draft --text car -o a.json --detail fin", "'fin' is not one of fine, objects; did you mean 'fine'?"),
        ("draft --sketch a.png --scale-bar long -o a.json", "argument --scale-bar: 'long' is not a number"),
        ("street --recipe smal", "'smal' is not one of paper-small, paper"),
        ("segmenter --pair folder", "the following arguments are required: -o/--output"),
    ],
)
def test_arguments_that_cannot_be_are_one_line(command: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = command.split()
    main, name = (train.main, "lidardraft-train") if words[0] in ("street", "segmenter") else (cli.main, "lidardraft")
    with pytest.raises(SystemExit, match="2"):
        main(words)
    message = capsys.readouterr().err
    assert message.startswith(f"{name} {words[0]}: error: ")
    assert message.endswith(f" (see `{name} {words[0]} --help`)\n")
    assert message.count("\n") == 1
    assert said in message


def test_so_are_a_command_and_an_option_before_it(capsys: pytest.CaptureFixture[str]) -> None:
    for words, said in ((["simulat"], "did you mean 'simulate'?"), (["--versoin"], "did you mean '--version'?")):
        with pytest.raises(SystemExit, match="2"):
            cli.main(words)
        message = capsys.readouterr().err
        assert message.startswith("lidardraft: error: ")
        assert said in message
        assert message.count("\n") == 1


def test_a_value_may_look_like_an_option() -> None:
    assert cli.main(["draft", "--text", "--two cars ahead", "--no-preview", "--out", "layout.json"]) == 0
    assert len(lidardraft.Layout.load("layout.json").boxes()) >= 2


def test_files_that_cannot_be_read_or_written(refused: Callable[..., str]) -> None:
    assert refused("view", "nowhere.bin") == "lidardraft: nowhere.bin: No such file or directory\n"
    Path("file").write_text("")
    assert "file" in refused("draft", "--text", "a car ahead", "-o", "file/layout.json")
    assert "cannot be written" in refused("draft", "--text", "a car ahead", "-o", "nowhere/layout.json")


def test_a_reader_that_goes_away_is_no_error() -> None:
    command = [sys.executable, "-m", "lidardraft", "draft", "--text", "a car ahead", "-o", "layout.json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.close()
    _, err = process.communicate(timeout=60)
    assert err == ""
    assert process.returncode == 141


def test_words_that_are_not_understood_are_said_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead and a purple dinosaur", "-o", "layout.json"]) == 0
    captured = capsys.readouterr()
    assert captured.err.count("dinosaur") == 1
    assert captured.out.startswith("layout.json: ")
