import pytest
from script_reading import agrees, reads, refuses

from lidardraft.drafting.blender.script.limits import Limits


@pytest.mark.parametrize(
    "script",
    [
        "import os\nassert os.path.join('/a', 'b', 'c.glb') == '/a/b/c.glb' and os.path.basename('/a/b.py') == 'b.py'",
        "from os.path import dirname, splitext\nassert dirname('/a/b') == '/a' and splitext('a.py') == ('a', '.py')",
        "from pathlib import Path\np = Path('/a') / 'b' / 'c.tar.gz'\n"
        "assert str(p) == '/a/b/c.tar.gz' and p.name == 'c.tar.gz' and p.stem == 'c.tar' and p.suffix == '.gz'\n"
        "assert str(p.parent) == '/a/b' and str(p.parents[1]) == '/a' and p == Path('/a', 'b/c.tar.gz')\n"
        "assert str(p.with_suffix('.py')) == '/a/b/c.tar.py' and f'{p.with_name(\"d\")}' == '/a/b/d'\n"
        "assert repr(Path('a')) == \"PosixPath('a')\"",
        "import sys\nsys.path.append('/lib')\nargs = sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else []\n"
        "assert args == [] and sys.version_info >= (3, 8) and sys.maxsize > 1",
        "import os\nassert os.environ.get('LIDARDRAFT_NOT_SET', '5') == os.getenv('LIDARDRAFT_NOT_SET', '5') == '5'",
    ],
)
def test_names_of_files_are_what_python_makes_of_them(script: str) -> None:
    agrees(script)


def test_no_file_is_looked_at() -> None:
    notes = reads("import os\nassert not os.path.exists('/')\nassert not os.path.isdir(os.getcwd())").notes
    assert list(notes) == [f"no file is looked at: os.path.{name} says False" for name in ("exists", "isdir")]
    notes = reads("from pathlib import Path\nassert not Path(__file__).parent.resolve().exists()").notes
    assert list(notes) == ["no file is looked at: Path.exists says False"]
    notes = reads("from pathlib import Path\nassert not Path('a').is_file() and not Path('a').is_dir()").notes
    assert list(notes) == [f"no file is looked at: Path.{name} says False" for name in ("is_file", "is_dir")]
    notes = reads("import os\nassert os.environ.get('HOME') is None").notes
    assert list(notes) == ["no variable of the environment is read"]


@pytest.mark.parametrize("code", ["", "0", "None"])
def test_a_script_may_end_itself(code: str) -> None:
    reads(f"import sys\ntry:\n    sys.exit({code})\nexcept Exception:\n    assert False\nassert False")
    reads("raise SystemExit")
    reads("try:\n    raise SystemExit(0)\nfinally:\n    x = 1")


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("import sys\nsys.exit(1)", "the script ends itself here"),
        ("import sys\nsys.exit('no road')", "the script ends itself here"),
        ("import os\nos.makedirs('/tmp/x')", "os.makedirs is not supported"),
        ("import os\nos.environ['HOME']", "os.environ has no item 'HOME'"),
        ("import os\nos.listdir('.')", "os.listdir is not supported"),
        ("import os\nos.path.getsize('a')", "os.path.getsize is not supported"),
        ("from pathlib import Path\nPath('a').write_text('b')", "a path has no 'write_text'"),
        ("from pathlib import Path\nPath('a').open()", "a path has no 'open'"),
        ("from pathlib import Path\nlist(Path('/').iterdir())", "a path has no 'iterdir'"),
        ("import sys\nsys.modules['os']", "sys.modules is not supported"),
    ],
)
def test_what_reaches_outside_is_refused_where_it_is_called(script: str, said: str) -> None:
    refuses(script, said, 2)


def test_a_comparison_of_paths_counts_their_characters() -> None:
    script = "from pathlib import Path\np, q = Path('a/' * 9999), Path('a/' * 9999)\nassert p == q and p != Path('a')\n"
    refuses(f"{script}for _ in range(9):\n    p == q", "more than 20000 steps", 5, Limits(steps=20_000))
    reads(f"{script}p == q", Limits(steps=20_000))


def test_a_path_that_grows_is_refused() -> None:
    refuses(
        "from pathlib import Path\np = Path('a')\nwhile True:\n    p = p / p",
        "a text of .* characters; 2000000 are the most",
        4,
    )
    refuses(
        "import os\np = 'a'\nwhile True:\n    p = os.path.join(p, p)",
        "a text of .* characters; 2000000 are the most",
        4,
    )
