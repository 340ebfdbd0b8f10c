"""Any input becomes a layout of semantic shapes, and the layout a LiDAR scan."""

import ast
import importlib
import warnings
from pathlib import Path

from lidardraft._core import DEBUG as _DEBUG
from lidardraft.errors import extra as _extra

__version__ = "0.2.0"  # that of pyproject.toml and Cargo.toml

# The module of each public name; type checkers read them too. A module is imported at the first use of its name: most
# need scikit-learn, Pillow or torch.
_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_MODULE_OF = {name.name: row.module for row in _STUB.body if isinstance(row, ast.ImportFrom) for name in row.names}
_MODULES = ("edit", "streets")  # public names that are modules
__all__ = sorted(_MODULE_OF)


def __getattr__(name):
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'lidardraft' has no attribute {name!r}")
    with _extra():
        if name in _MODULES:
            return importlib.import_module(f"{_MODULE_OF[name]}.{name}")
        return globals().setdefault(name, getattr(importlib.import_module(_MODULE_OF[name]), name))


def __dir__():
    return __all__


def _warn_of_debug_build(debug: bool) -> None:
    """Warn once, at the line that imports lidardraft, if the core was compiled without optimisation."""
    if debug:
        message = (
            "lidardraft's compiled core is a debug build: right, but many times slower than a release build; "
            "`make install` or `maturin develop --release` makes that"
        )
        warnings.warn(message, RuntimeWarning, stacklevel=3)


_warn_of_debug_build(_DEBUG)
