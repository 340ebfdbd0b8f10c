"""A recipe: the contents of a data set, in shares and ranges. Scan k of it depends on its seed and on k alone."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import sys
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from glob import glob
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

import lidardraft
from lidardraft.arranging.district import STREET_DISTRICTS
from lidardraft.arranging.street_mix import StreetMix, only
from lidardraft.dataset.table import Table, Values, all_drawn, drawn, every
from lidardraft.drafting.text.lexicon import district_of
from lidardraft.errors import FormatError, one_of
from lidardraft.files import MAX_BYTES, expecting, named, read_bytes, read_sentences, read_text
from lidardraft.formats.frame import FORMATS
from lidardraft.json_fields import is_number
from lidardraft.networks.weight_header import find
from lidardraft.scan import Scan
from lidardraft.scene import edit
from lidardraft.scene.layout import Layout
from lidardraft.scene.materials import MATERIALS
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.weather import Weather
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.carrier import carried
from lidardraft.streets.drives import HALF_LENGTH, street_drive
from lidardraft.streets.scans import street_scan
from lidardraft.streets.street import StreetConfig

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib
if TYPE_CHECKING:
    from lidardraft.pipeline import Pipeline
    from lidardraft.simulation.motion.sequence import SequenceSimulator

SPLITS = ("train", "val", "test")
SCANS = "scans"  # the format of `simulate`, beside those of `export`
_DRAWS = 17  # random numbers of an item, apart from those of its layout and its scan
_HZ = 10.0  # of drives
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_TRIED = 16  # sentences of a scene that are tried before any scan is made
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Edit:
    """An edit of a layout with probability `chance`: `kind` is remove, move or replace, applied to the matches of
    `pattern`."""

    kind: str
    pattern: str
    chance: float
    values: dict[str, Values]


@dataclass(frozen=True, kw_only=True)
class Scene:
    """The scene of a scan: `source` is text, layout or street, and `values` its sentences, files or districts.

    `numbers` are the speed, or the numbers of a `StreetMix`.
    """

    source: str
    values: Values
    numbers: dict[str, Values]
    words: dict[str, Values] = dataclasses.field(default_factory=dict)
    surroundings: str = "bare"
    weights: str | None = None
    edits: tuple[Edit, ...] = ()


@dataclass(frozen=True)
class Choice(Generic[T]):
    """One of several choices, drawn in proportion to its share."""

    share: float
    of: T


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A data set of `scans` scans in shards of `shard_size`; `text` is everything that decides them, in a line of JSON.

    `frames` consecutive scans, `hz` a second, are of one drive; `poses` consecutive scans are of one static street. The
    scans of such a run are all in one of the `splits`.
    """

    name: str
    text: str
    scans: int
    shard_size: int
    format: str
    seed: int
    poses: int
    frames: int
    hz: float
    splits: tuple[Choice[str], ...]
    scenes: tuple[Choice[Scene], ...]
    sensors: tuple[Choice[tuple[Sensor, Values, bool]], ...]  # the heights of their mounts; if their car is in the way
    weather: tuple[Choice[dict[str, Values]], ...]  # the numbers of a `Weather`

    @classmethod
    def load(cls, path: str | os.PathLike[str], num: int | None = None) -> Recipe:
        """The recipe of a TOML file, with `num` scans, or drives, if that is given. Files in it are relative to its
        folder. Raises `LidarDraftError` naming the file and the invalid key."""
        text = read_text(path)
        with named(path):
            with expecting("TOML"):
                fields = tomllib.loads(text)
            counted = "drives" if "frames" in fields else "scans"
            recipe = _recipe(Path(path), fields if num is None else fields | {counted: num})
            recipe.try_sentences()
        return recipe

    def scan(self, number: int) -> Scan:
        """Scan `number`, made in one thread; its layout's provenance lists the values drawn for it under `recipe`.

        Raises `LidarDraftError` naming the invalid scene.
        """
        if self.frames:
            return self._frame(number, self.drive(number // self.frames).frame(number % self.frames))
        place, sensor, air, rng = self._draws(number)
        scene = self.scenes[place - 1].of
        with named(f"{self.name}: scan {number}, scene {place}"):
            make = self._of_street if scene.source == "street" else self._of_layout
            scan = make(scene, number, sensor, Weather(**air), rng)
        return _told(scan, {"scan": number, "scene": place, "weather": air, "speed": scan.speed})

    def made(self, numbers: range) -> Iterator[Iterator[tuple[int, Scan]]]:
        """The scans of these numbers, drive by drive."""
        if not self.frames:
            yield ((k, self.scan(k)) for k in numbers)
            return
        for first in range(numbers.start, numbers.stop, self.frames):
            drive = self.drive(first // self.frames)
            yield ((k, self._frame(k, scan)) for k, scan in enumerate(drive, first))

    def _frame(self, number: int, scan: Scan) -> Scan:
        place, _, air, _ = self._draws(number)
        return _told(scan, {"drive": number // self.frames, "scene": place, "weather": air})

    def drive(self, number: int) -> SequenceSimulator:
        """Drive `number`, made in one thread; raises `LidarDraftError` naming the invalid scene."""
        place, sensor, air, rng = self._draws(number * self.frames)
        scene, weather = self.scenes[place - 1].of, Weather(**air)
        how: dict[str, Any] = {"frames": self.frames, "hz": self.hz, "threads": 1}
        with named(f"{self.name}: drive {number}, scene {place}"):
            if scene.source == "street":
                config = dataclasses.replace(self._config(scene, sensor, weather, rng), half_length=HALF_LENGTH)
                return street_drive(number, seed=self.seed, config=config, carrier=False, **how)
            from lidardraft.simulation.motion.sequence import SequenceSimulator

            seed, more = self.seed + number, all_drawn(scene.numbers, rng)
            layout = _edited_layout(scene, seed, rng)
            return SequenceSimulator(layout, sensor, seed=seed, weather=weather, carrier=False, **how, **more)

    @property
    def notes(self) -> tuple[str, ...]:
        """The sensors of simulated scans whose vehicle is unknown, and so not in their way."""
        if all(choice.of.weights for choice in self.scenes):
            return ()
        said = (note for choice in self.sensors for note in carried(choice.of[0], choice.of[2]).notes)
        return tuple(dict.fromkeys(said))

    def split(self, number: int) -> str:
        """The split of scan `number`, the same for all scans of its run; "" if the recipe has none."""
        if not self.splits:
            return ""
        run = number // (self.frames or self.poses)
        place = (run + 0.5) * _GOLDEN % 1.0  # the first runs, however many, are near the shares
        ends = np.cumsum([choice.share for choice in self.splits])
        return self.splits[min(int(np.searchsorted(ends, place, side="right")), len(ends) - 1)].of

    def drawn(self, number: int) -> tuple[int, dict[str, Any]]:
        """The number of the scene, from 1 on, of scan `number`, and the numbers of its weather."""
        place, _, air, _ = self._draws(number)
        return place, air

    def _draws(self, number: int) -> tuple[int, Sensor, dict[str, Any], np.random.Generator]:
        """The values drawn for a scan, shared by all scans of a street, and the generator for further ones. The
        vehicle of the sensor, if there is one, is in its way already."""
        first = number - number % (self.frames or self.poses)
        choice = _chosen(self.scenes, np.random.default_rng([self.seed, first, _DRAWS]))
        shared = self.frames or choice.of.source == "street"
        rng = np.random.default_rng([self.seed, first if shared else number, _DRAWS, 1])
        sensor, heights, carrier = _chosen(self.sensors, rng).of
        if (height := drawn(heights, rng)) is not None:
            sensor = dataclasses.replace(sensor, mount_height=float(height))
        if choice.of.weights is None:
            sensor = carried(sensor, carrier).sensor
        return self.scenes.index(choice) + 1, sensor, all_drawn(_chosen(self.weather, rng).of, rng), rng

    def _of_street(self, scene: Scene, number: int, sensor: Sensor, weather: Weather, rng: np.random.Generator) -> Scan:
        config = self._config(scene, sensor, weather, rng)
        return street_scan(number, seed=self.seed, config=config, carrier=False, threads=1)

    def _config(self, scene: Scene, sensor: Sensor, weather: Weather, rng: np.random.Generator) -> StreetConfig:
        district, more = drawn(scene.values, rng), all_drawn(scene.numbers, rng)
        mix = StreetMix(**only(str(district_of(district))), **more)
        return StreetConfig(sensor=sensor, poses_per_street=self.poses, mix=mix, weather=weather)

    def _of_layout(self, scene: Scene, number: int, sensor: Sensor, weather: Weather, rng: np.random.Generator) -> Scan:
        seed, more = self.seed + number, all_drawn(scene.numbers, rng)
        layout = _edited_layout(scene, seed, rng)
        if scene.weights is not None:
            return _pipeline(scene.weights)(layout, sensor=sensor, seed=seed, **more)
        from lidardraft.simulation.simulate import simulate

        return simulate(layout, sensor, seed=seed, weather=weather, carrier=False, threads=1, **more)

    def try_sentences(self) -> None:
        """Raise `LidarDraftError` if one of the first sentences of a scene, with any of its words, is invalid."""
        from lidardraft.drafting.text.layout import layout_from_text, spec_from_text

        for place, scene in enumerate((choice.of for choice in self.scenes), 1):
            if scene.source != "text":
                continue
            words = {name: every(values) for name, values in scene.words.items()}
            sentences = every(scene.values)
            for turn in range(min(max(map(len, [sentences, *words.values()])), _TRIED)):
                chosen = {name: values[turn % len(values)] for name, values in words.items()}
                sentence = _filled(sentences[turn % len(sentences)], chosen)
                with named(f"scene {place}, text {sentence!r}"):
                    layout_from_text(sentence, seed=self.seed)
                    if unknown := spec_from_text(sentence).not_understood:
                        raise FormatError(f"not understood: {', '.join(unknown)}")


def _told(scan: Scan, told: dict[str, Any]) -> Scan:
    """The scan with its draws in the provenance of its layout."""
    layout = dataclasses.replace(scan.layout, provenance=scan.layout.provenance | {"recipe": told})
    return dataclasses.replace(scan, layout=layout)


def _edited_layout(scene: Scene, seed: int, rng: np.random.Generator) -> Layout:
    layout = _layout(scene, seed, rng)
    for change in scene.edits:
        layout = _edited(layout, change, rng)
    return layout


def _layout(scene: Scene, seed: int, rng: np.random.Generator) -> Layout:
    if scene.source == "layout":
        return Layout.load(drawn(scene.values, rng))
    from lidardraft.drafting.text.layout import layout_from_text
    from lidardraft.simulation.around.surround import surround
    from lidardraft.simulation.on_relief import without_relief

    layout = layout_from_text(_filled(drawn(scene.values, rng), all_drawn(scene.words, rng)), seed=seed)
    if scene.surroundings == "bare":
        return layout
    whole = surround(layout, seed=seed)
    return without_relief(whole) if scene.surroundings == "level" else whole


def _filled(sentence: str, words: dict[str, Any]) -> str:
    """The sentence with a word in place of each {name}; numbers have three digits."""
    texts = {name: f"{word:.3g}" if isinstance(word, float) else str(word) for name, word in words.items()}
    return _NAMES.sub(lambda found: texts[found[1]], sentence)


_NAMES = re.compile(r"\{(\w+)\}")


def _edited(layout: Layout, change: Edit, rng: np.random.Generator) -> Layout:
    """The edited layout, or the layout itself if chance decides so or nothing matches."""
    values = all_drawn(change.values, rng)
    if rng.random() >= change.chance or not edit.select(layout, change.pattern):
        return layout
    if change.kind == "remove":
        return edit.remove(layout, change.pattern)
    if change.kind == "replace":
        return edit.replace(layout, change.pattern, **values)
    return edit.move(layout, change.pattern, (values["ahead"], values["left"], 0.0), turn=values["turn"])


def _chosen(choices: Sequence[Choice[T]], rng: np.random.Generator) -> Choice[T]:
    """One of the choices, by their shares."""
    shares = np.cumsum([choice.share for choice in choices])
    return choices[int(np.searchsorted(shares / shares[-1], rng.random(), side="right"))]


@lru_cache(maxsize=1)
def _pipeline(weights: str) -> Pipeline:
    from lidardraft.pipeline import Pipeline

    return Pipeline.from_pretrained(weights, threads=1)


def _recipe(path: Path, fields: dict[str, Any]) -> Recipe:
    table, folder = Table(fields), path.parent
    scenes = [Choice(each.share(), _scene(each, folder)) for each in table.tables("scene")]
    sensors = [Choice(each.share(), _sensor(each, folder)) for each in table.tables("sensor")]
    sensors = sensors or [Choice(1.0, (PRESETS["hdl64e"], None, True))]
    weather = [Choice(each.share(), _weather(each)) for each in table.tables("weather")] or [Choice(1.0, {})]
    if not scenes:
        raise FormatError("scene is missing; a recipe has at least one [[scene]]")
    shares = {"scene": scenes, "sensor": sensors, "weather": weather}
    for key, choices in shares.items():
        if not any(choice.share for choice in choices):  # type: ignore[attr-defined]
            raise FormatError(f"{key}: every share is 0; one must be more")
    if any(choice.of.weights for choice in scenes) and any(choice.of for choice in weather):
        raise FormatError("weather goes without scenes with weights, which have seen none")
    frames = table.whole("frames", 0, 1) if "frames" in table else 0
    for key in ("scans", "poses") if frames else ("drives", "hz"):
        if key in table:
            raise FormatError(f"{key} goes {'without' if frames else 'with'} frames, which make drives")
    if frames and any(choice.of.weights for choice in scenes):
        raise FormatError("frames go without scenes with weights, which make single scans")
    recipe = Recipe(
        name=os.fspath(path),
        text=_text(fields, [choice.of for choice in scenes], [choice.of[0] for choice in sensors]),
        scans=table.whole("drives", 0, 1) * frames if frames else table.whole("scans", 0, 1),
        shard_size=table.whole("shard_size", 1 if frames else 64, 1) * max(frames, 1),
        format=table.name("format", [*FORMATS, SCANS], "webdataset"),
        seed=table.whole("seed", 0, 0, 2**32 - 1),
        poses=1 if frames else table.whole("poses", 1, 1),
        frames=frames,
        hz=_rate(table),
        splits=_splits(table.table("split")),
        scenes=tuple(scenes),
        sensors=tuple(sensors),
        weather=tuple(weather),
    )
    table.end()
    return recipe


def _text(fields: dict[str, Any], scenes: list[Scene], sensors: list[Sensor]) -> str:
    """All that decides each scan, in a line: the recipe without the number of scans, with checksums of its files and
    weights, and the version of lidardraft."""
    files = [read_bytes(file) for scene in scenes if scene.source == "layout" for file in scene.values]
    files += ["\n".join(every(scene.values)).encode() for scene in scenes if scene.source == "text"]
    files += [sensor.to_json().encode() for sensor in sensors]
    said = {name: value for name, value in fields.items() if name not in ("scans", "drives")}
    said |= {"checksums": list(map(zlib.crc32, files)), "version": lidardraft.__version__}
    weights = [read_bytes(find(scene.weights), MAX_BYTES) for scene in scenes if scene.weights]
    return json.dumps(said | {"weights": list(map(zlib.crc32, weights))}, sort_keys=True, default=str)


def _scene(table: Table, folder: Path) -> Scene:
    sources = [name for name in ("text", "text_file", "layout", "street") if name in table]
    if len(sources) != 1:
        raise FormatError(f"{table.place}one of text, text_file, layout and street is needed; there are {len(sources)}")
    source, values, words = sources[0], None, {}
    if source == "street":
        values = table.texts(source)
        if None in (named := list(map(district_of, every(values)))):
            table.refuse(source, one_of(STREET_DISTRICTS, every(values)[named.index(None)]))
        more = {field.name: 1.0 for field in dataclasses.fields(StreetMix) if field.name not in STREET_DISTRICTS}
        return Scene(source=source, values=values, numbers=_numbers(table, more, 0.0))
    if source == "layout":
        values = _files(table, folder)
    else:
        of_file = source == "text_file"
        values = list(read_sentences(folder / table.text(source)).values()) if of_file else table.texts(source)
        words = table.words("words")
        _check_words(table, every(values), words)
    weights = table.text("weights") if "weights" in table else None
    if weights and (folder / weights).is_file():
        weights = os.fspath(folder / weights)
    usual = "bare" if source == "layout" else "street"
    return Scene(
        source="layout" if source == "layout" else "text",
        values=values,
        numbers=_numbers(table, {"speed": 0.0}) if "speed" in table else {},
        words=words,
        surroundings=table.name("surroundings", ["street", "level", "bare"], usual),
        weights=weights,
        edits=tuple(map(_edit, table.tables("edit"))),
    )


def _numbers(
    table: Table, usual: dict[str, float], least: float = -math.inf, most: float = math.inf
) -> dict[str, Values]:
    return {name: table.numbers(name, default, least, most) for name, default in usual.items()}


def _files(table: Table, folder: Path) -> list[str]:
    """The layouts named by the paths and patterns, in order."""
    found = list[Path]()
    for text in every(table.texts("layout")):
        found += sorted(map(folder.joinpath, glob(text, root_dir=folder, recursive=True)))
    if not found:
        table.refuse("layout", f'files, as in "layouts/*.layout.json"; there are none in {folder}')
    return list(map(os.fspath, found))


def _check_words(table: Table, sentences: list[str], words: dict[str, Values]) -> None:
    named = {name for sentence in sentences for name in _NAMES.findall(sentence)}
    for name in sorted(named ^ set(words)):
        missing = f"{{{name}}} has no words" if name in named else f"words, {name} is in no sentence"
        raise FormatError(f"{table.place}{missing}")


def _edit(table: Table) -> Edit:
    kinds = [name for name in ("remove", "move", "replace") if name in table]
    if len(kinds) != 1:
        raise FormatError(f"{table.place}one of remove, move and replace is needed; there are {len(kinds)}")
    kind, values = kinds[0], dict[str, Values]()
    if kind == "move":
        values = _numbers(table, {"ahead": 0.0, "left": 0.0, "turn": 0.0})
    if kind == "replace":
        allowed = {"label": list(BY_NAME)[1:], "material": [material.name for material in MATERIALS]}
        values = {name: table.names(name, names) for name, names in allowed.items() if name in table}
    chance = table.numbers("chance", 1.0, 0.0, 1.0)
    return Edit(kind=kind, pattern=table.text(kind), chance=chance, values=values)


def _sensor(table: Table, folder: Path) -> tuple[Sensor, Values, bool]:
    name = table.text("name")
    with named(f"{table.place}name"):
        sensor = Sensor.load(folder / name) if name.endswith(".json") else Sensor.preset(name)
    heights = table.numbers("mount_height", 0.0, 0.1, 100.0) if "mount_height" in table else None
    return sensor, heights, table.name("carrier", ["car", "none"], "car") == "car"


def _rate(table: Table) -> float:
    value = table.get("hz", _HZ)
    if not is_number(value) or value <= 0:
        table.refuse("hz", "a number over 0: scans a second")
    return float(value)


def _splits(table: Table) -> tuple[Choice[str], ...]:
    """The shares of the splits, which add up to 1."""
    found = tuple(Choice(float(table.numbers(name, 0.0, 0.0, 1.0)), name) for name in SPLITS if name in table)
    table.end()
    total = sum(choice.share for choice in found)
    if found and abs(total - 1.0) > 1e-6:
        raise FormatError(f"split: {' + '.join(f'{each.share:g}' for each in found)} is {total:g}; it must be 1")
    return found


def _weather(table: Table) -> dict[str, Values]:
    limits = {"rain": (0.0, 200.0), "snow": (0.0, 200.0), "visibility": (1.0, 1e6), "wetness": (0.0, 1.0)}
    return {name: table.numbers(name, 0.0, *ends) for name, ends in limits.items() if name in table}
