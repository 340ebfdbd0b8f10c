"""Downloads of a visitor: scans and data sets as bytes of a file, and the command that makes a scan again."""

from __future__ import annotations

import io
import itertools
import json
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np

from lidardraft.exports import export
from lidardraft.files import new_folder, written_whole
from lidardraft.formats.frame import FORMATS
from lidardraft.scan import Scan
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.weather import Weather
from lidardraft.studio.document import Document
from lidardraft.world.state import WorldState
from lidardraft.world.world import World

OURS = "lidardraft"  # the files of `simulate`; the other kinds are `FORMATS`
KINDS = (OURS, *FORMATS)
STATE_FILE, SENSOR_FILE = "studio.world.json", "studio.sensor.json"


def scans_of(document: Document, states: Sequence[WorldState]) -> Iterator[Scan]:
    """The scan of each state, by the first sensor."""
    world = World(states[0], document.sensors[0], weather=document.weather)
    for state in states:
        world.restore(state)
        yield world.scan()


def data_set(scans: Iterator[Scan], kind: str, *, on_scan: Callable[[], object] = lambda: None) -> bytes:
    """A ZIP archive of scans, as the files of `simulate` or in a format of `export`."""

    def counted() -> Iterator[Scan]:
        for scan in scans:
            on_scan()
            yield scan

    with tempfile.TemporaryDirectory(prefix="lidardraft-studio-") as folder:
        output = Path(folder, "scans")
        if kind == OURS:
            output.mkdir()
            for number, scan in enumerate(counted()):
                scan.save(output / f"{number:06d}", picture=number == 0)
        else:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # on no box at all: the page shows that
                export(counted(), kind, output)
        return _zipped({path.relative_to(output).as_posix(): path.read_bytes() for path in _files_in(output)})


def put(folder: Path, name: str, content: bytes) -> None:
    """Write a file into a folder, or unpack an archive into a new folder in it."""
    folder.mkdir(parents=True, exist_ok=True)
    if not name.endswith(".zip"):
        with written_whole(folder / name) as temporary:
            temporary.write_bytes(content)
        return
    stem = name.removesuffix(".zip")
    inside = next(one for k in itertools.count(1) if not (one := folder / f"{stem}-{k}").exists())
    with new_folder(inside) as temporary, zipfile.ZipFile(io.BytesIO(content)) as archive:
        archive.extractall(temporary)


def recipe(document: Document, state: WorldState) -> bytes:
    """A ZIP archive of the state, the sensor unless it is a preset, and the two ways to make its scan again."""
    files = {
        STATE_FILE: state.to_json().encode(),
        "scan.sh": f"{as_command(document)}\n".encode(),
        "scan.py": as_python(document).encode(),
    }
    if not _is_preset(document.sensors[0]):
        files[SENSOR_FILE] = document.sensors[0].to_json().encode()
    return _zipped(files)


def as_command(document: Document, folder: str = "") -> str:
    """The command that makes the scan of the first sensor from the state saved in a folder."""
    sensor, weather = document.sensors[0], document.weather
    named = sensor.name if _is_preset(sensor) else f"{folder}{SENSOR_FILE}"
    amounts = {} if weather is None else {row.name: getattr(weather, row.name) for row in fields(weather)}
    kinds = {"rain": "rain:{}mm", "snow": "snow:{}mm", "visibility": "fog:{}m", "wetness": "wet:{}"}
    said = [
        kinds[name].format(np.format_float_positional(value, trim="-"))
        for name, value in amounts.items()
        if 0.0 < value < float("inf")
    ]
    said = said or ["wet:0"] * (weather is not None)
    told = "".join(f" --weather {each}" for each in said)
    return f"lidardraft simulate --world {folder}{STATE_FILE} --sensor {named}{told} -o scan"


def as_python(document: Document, folder: str = "") -> str:
    """The same in Python."""
    sensor, weather = document.sensors[0], document.weather
    is_preset = _is_preset(sensor)
    made = f"Sensor.preset({json.dumps(sensor.name)})" if is_preset else f'Sensor.load("{folder}{SENSOR_FILE}")'
    names = ["Sensor", "World", "WorldState", *(["Weather"] if weather else [])]
    told = "" if weather is None else f", weather={_shown(weather)}"
    lines = [
        f"from lidardraft import {', '.join(sorted(names))}",
        "",
        f'world = World(WorldState.load("{folder}{STATE_FILE}"), {made}{told})',
        'world.scan().save("000000")',
    ]
    return "\n".join(lines) + "\n"


def _shown(weather: Weather) -> str:
    differs = {row.name: getattr(weather, row.name) for row in fields(weather)}
    usual = Weather()
    return f"Weather({', '.join(f'{k}={v!r}' for k, v in differs.items() if v != getattr(usual, k))})"


def _is_preset(sensor: Sensor) -> bool:
    return sensor.name in PRESETS and sensor == Sensor.preset(sensor.name)


def _files_in(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _zipped(files: dict[str, bytes]) -> bytes:
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as zipped:
        for name, content in files.items():
            zipped.writestr(name, content)
    return archive.getvalue()
