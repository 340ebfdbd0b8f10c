"""`lidardraft doctor`: the capabilities of an installation, its missing parts, and how to get them."""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Mapping
from importlib import import_module, metadata
from importlib.util import find_spec

import lidardraft
from lidardraft.cli.command import add_json, report
from lidardraft.cli.scan_folder import cores
from lidardraft.errors import EXTRAS
from lidardraft.scene.raycast import backends

_SENTENCE = "a car ahead"


def doctor(arguments: argparse.Namespace) -> None:
    """Print a line for each part."""
    casters, system = backends(), platform.platform()
    report(
        arguments,
        f"lidardraft {lidardraft.__version__}, Python {platform.python_version()}, {system}, {cores()} cores",
        version=lidardraft.__version__,
        python=platform.python_version(),
        system=system,
        cores=cores(),
    )
    threads = int(os.environ.get("RAYON_NUM_THREADS") or 0) or cores()
    text = f"caster: {casters[0]} (of {', '.join(casters)}), {threads} threads"
    report(arguments, text, backends=casters, threads=threads)
    milliseconds = _first_scan()
    text = f"simulate: {milliseconds:.0f} ms for a first scan of {_SENTENCE!r}"
    report(arguments, text, first_scan_ms=round(milliseconds, 1))
    packages = metadata.packages_distributions()
    for library, extras in EXTRAS.items():
        found = _found(library, packages)
        lacks = f"missing; pip install 'lidardraft[{extras[0]}]'"
        report(arguments, f"{library:15} {found or lacks}", library=library, found=found, extra=extras[0])
    if devices := _devices():
        report(arguments, f"generate: on {', '.join(devices)}", devices=devices)


def _first_scan() -> float:
    """The time [ms] of a sentence's first scan, with its imports."""
    begun = time.perf_counter()
    lidardraft.simulate(_SENTENCE, lidardraft.Sensor.preset("hdl64e"))
    return 1e3 * (time.perf_counter() - begun)


def _found(library: str, packages: Mapping[str, list[str]]) -> str | None:
    """The version of a library, which one of the `packages` brings, or the error of its import; None if it is not
    installed."""
    if find_spec(library) is None:
        return None
    try:
        import_module(library)
    except Exception as error:  # a broken library may raise anything
        return f"broken: {error}"
    return metadata.version(packages.get(library, [library])[0])


def _devices() -> list[str]:
    """The devices that torch may use; none without a working torch, which its own row reports."""
    try:
        from lidardraft.networks.layers import devices
    except Exception:
        return []
    return devices()


def doctor_options(parser: argparse.ArgumentParser) -> None:
    """The options of `doctor`."""
    add_json(parser)
