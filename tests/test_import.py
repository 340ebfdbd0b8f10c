"""What `import lidardraft` does: it loads little, and says so if the core is a slow build."""

import subprocess
import sys
import warnings

import pytest

import lidardraft
from lidardraft import _core


def test_a_debug_build_is_named_with_the_way_to_a_faster_one():
    with pytest.warns(RuntimeWarning, match="debug build.* slower .*make install"):
        lidardraft._warn_of_debug_build(True)


def test_a_release_build_says_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lidardraft._warn_of_debug_build(False)


def test_importing_is_light_and_warns_once_if_and_only_if_the_core_is_a_debug_build():
    code = "import sys, time; start = time.process_time(); import lidardraft; took = time.process_time() - start\n"
    code += "print(sorted({'torch', 'sklearn', 'scipy', 'PIL', 'numpy'} & set(sys.modules)), took < 0.3)\n"
    code += "import lidardraft.scene.raycast\n"
    result = subprocess.run(
        [sys.executable, "-W", "always", "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert result.stdout == "[] True\n"
    assert result.stderr.count("RuntimeWarning: lidardraft's compiled core is a debug build") == int(_core.DEBUG)
