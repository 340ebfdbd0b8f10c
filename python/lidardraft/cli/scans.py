"""`lidardraft simulate`, `generate` and `observe`: labelled scans, a seed each, in a folder of their own."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lidardraft.arranging.street_mix import USUAL_MIX, StreetMix, only
from lidardraft.cli.arguments import (
    add_carla_tags,
    add_carrier,
    add_seed,
    add_sensor,
    add_speed,
    add_weather,
    add_weights,
    assignments,
    positive,
    read_carrier,
    read_pipeline,
    read_sensor,
    read_weather,
    whole_number,
)
from lidardraft.cli.command import add_json, progress, report, say
from lidardraft.cli.inputs import (
    add_inputs,
    around_it,
    check_inputs,
    district_named,
    layout_of_text,
    notes_on,
    read_layout,
)
from lidardraft.cli.scan_folder import ScanFolder, add_folder, add_jobs, check_output, jobs_of
from lidardraft.errors import FormatError
from lidardraft.files import named, new_folder, read_sentences, write_text
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import inverse
from lidardraft.scene.scenario import Scenario
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather

if TYPE_CHECKING:
    from lidardraft.pipeline import Pipeline
    from lidardraft.scan import Scan
    from lidardraft.scene.range_image import RangeImage
    from lidardraft.simulation.motion.sequence import SequenceSimulator as Drive
    from lidardraft.streets import StreetConfig

_POSES = 4  # scans of a street
_HZ = 10.0  # frames of a sequence


@dataclass(frozen=True, slots=True)
class Layouts:
    """The layout of each scan: `first` for all, or the sentences in turn, each with another seed; a sentence comes with
    its name in messages."""

    arguments: argparse.Namespace
    first: Layout
    sentences: list[tuple[str, str]]

    @classmethod
    def read(cls, arguments: argparse.Namespace) -> Layouts:
        """The layouts of the arguments."""
        if arguments.text_file is None:
            sentences = [] if arguments.text is None else [("--text", arguments.text)]
            return cls(arguments, read_layout(arguments), sentences)
        check_inputs(arguments)
        lines = read_sentences(arguments.text_file).items()
        sentences = [(f"{arguments.text_file}, line {number}", sentence) for number, sentence in lines]
        name, sentence = sentences[0]
        with named(name):
            return cls(arguments, layout_of_text(arguments, sentence, arguments.seed), sentences)

    def of(self, number: int) -> tuple[Layout, int]:
        """Layout and seed of scan `number`."""
        seed = self.arguments.seed + number
        if not (number and self.sentences):
            return self.first, seed
        name, sentence = self.sentences[number % len(self.sentences)]
        with named(name):
            return layout_of_text(self.arguments, sentence, seed), seed

    def notes(self, number: int, scan: Scan | Drive) -> list[str]:
        """The notes on a sentence of a file, the first time that it is read."""
        if self.arguments.text_file is None or number >= len(self.sentences):
            return []
        return [f"{self.sentences[number][0]}: {note}" for note in notes_on(self.arguments, scan.layout)]


def _simulated(layouts: Layouts, sensor: Sensor, weather: Weather | None, threads: int | None, number: int) -> Scan:
    """The simulated scan of layout `number`."""
    from lidardraft.simulation.simulate import simulate

    layout, seed = layouts.of(number)
    speed = layouts.arguments.speed or 0.0
    carrier = _carrier(layouts.arguments)
    return simulate(layout, sensor, seed=seed, weather=weather, speed=speed, threads=threads, **carrier)


def _say_if_unknown(sensor: Sensor, arguments: argparse.Namespace) -> None:
    """Say if the vehicle of the sensor is unknown."""
    from lidardraft.simulation.carrier import carried

    for note in carried(sensor, read_carrier(arguments.carrier)).notes:
        say(note)


def _carrier(arguments: argparse.Namespace) -> dict[str, Any]:
    return {"carrier": read_carrier(arguments.carrier), "own_returns": arguments.own_returns}


def _drive(layouts: Layouts, sensor: Sensor, weather: Weather | None, threads: int | None, number: int) -> Drive:
    """The sequence of layout `number`."""
    from lidardraft.simulation.motion.sequence import SequenceSimulator

    arguments = layouts.arguments
    layout, seed = layouts.of(number)
    scenario = Scenario() if arguments.scenario is None else Scenario.load(arguments.scenario)
    with named(arguments.scenario) if arguments.scenario else nullcontext():
        return SequenceSimulator(
            layout,
            sensor,
            scenario,
            frames=arguments.frames,
            hz=arguments.hz or _HZ,
            speed=arguments.speed,
            seed=seed,
            weather=weather,
            threads=threads,
            **_carrier(arguments),
        )


def _write_sequences(arguments: argparse.Namespace) -> None:
    """Write the frames of a sequence, or with --num several in folders of their own."""
    from lidardraft.streets.drives import street_drive

    for option in ("poses", "world"):
        if getattr(arguments, option) is not None:
            raise FormatError(f"--{option} does not go with --frames, which make drives")
    sensor, weather = read_sensor(arguments.sensor), read_weather(arguments.weather)
    layouts = None if arguments.street else Layouts.read(arguments)
    num = arguments.num or (len(layouts.sentences) if layouts and arguments.text_file else 0)
    jobs = jobs_of(arguments, num or arguments.frames)
    threads = 1 if jobs > 1 else None
    make: Callable[[int], Drive]
    if layouts is not None:
        make = partial(_drive, layouts, sensor, weather, threads)
    else:
        config = _street_config(arguments, sensor, weather, 1)
        of = {"seed": arguments.seed, "config": config, "frames": arguments.frames, "hz": arguments.hz or _HZ}
        of["carrier"] = read_carrier(arguments.carrier)
        make = partial(street_drive, threads=threads, **of)
    if num:
        notes = None if layouts is None else layouts.notes
        folder = ScanFolder(Path(arguments.output), arguments.pictures, make, _save_drive, notes)
        with progress(num, "drive") as bar:
            for _ in folder.write(num, jobs=jobs):
                bar.update()
        text = f"{arguments.output}: {num} drive{'s' * (num > 1)} of {arguments.frames} scans, a folder each"
        report(arguments, text, output=arguments.output, drives=num, scans=num * arguments.frames)
    else:
        _write_frames(arguments, make(0), None if layouts is None else layouts.first, jobs)
    _say_if_unknown(sensor, arguments)


def _save_drive(simulator: Drive, folder: Path, *, picture: bool) -> None:
    """Write all frames and the tracks into a new folder, the first with a picture."""
    with new_folder(folder) as part:
        for number, scan in enumerate(simulator):
            scan.save(part / f"{number:06d}", picture=picture and not number)
        simulator.save_tracks(part)


def _write_frames(arguments: argparse.Namespace, simulator: Drive, given: Layout | None, jobs: int) -> None:
    """Write the frames of one sequence into the output folder itself."""
    from lidardraft.scan import Scan

    for note in simulator.layout.notes[len(given.notes) :] if given else ():
        say(note)
    asked = arguments.scenario is not None or arguments.speed is not None
    if not (asked or simulator.tracks.actors or simulator.tracks.ego.moves()):
        say("nothing moves: the layout has no road with known lanes; give --speed or --scenario")
    num = arguments.frames
    folder = ScanFolder(Path(arguments.output), arguments.pictures, simulator.frame, Scan.save)
    with progress(num, "frame") as bar:
        for _ in folder.write(num, jobs=jobs):
            bar.update()
    simulator.save_tracks(arguments.output)
    files = "; poses.txt, times.txt and tracks.json"
    _report(arguments, num, f"{files}{around_it(given) if given else ''}")


def simulate(arguments: argparse.Namespace) -> None:
    """Write simulated scans, or with --frames sequences."""
    from lidardraft.scan import Scan
    from lidardraft.streets.scans import street_scan

    check_output(arguments)
    if arguments.frames is not None:
        _write_sequences(arguments)
        return
    for option in ("hz", "scenario"):
        if getattr(arguments, option) is not None:
            raise FormatError(f"--{option} is for a sequence; give its length with --frames")
    sensor, weather = read_sensor(arguments.sensor), read_weather(arguments.weather)
    output, pictures, around = Path(arguments.output), arguments.pictures, ""
    if arguments.world is not None:
        num, jobs, poses, notes = 1, 1, 1, None
        make: Callable[[int], Scan] = _scan_of_world(arguments, sensor, weather)
    elif arguments.street is None:
        layouts = Layouts.read(arguments)
        around = around_it(layouts.first)
        num = arguments.num or len(layouts.sentences) or 1
        jobs, poses = jobs_of(arguments, num), 1
        make = partial(_simulated, layouts, sensor, weather, 1 if jobs > 1 else None)
        notes = layouts.notes
    else:
        num, poses = arguments.num or 1, arguments.poses or _POSES
        jobs = jobs_of(arguments, num, poses)
        config = _street_config(arguments, sensor, weather, poses)
        carrier = read_carrier(arguments.carrier)
        of = {"seed": arguments.seed, "config": config, "carrier": carrier, "threads": 1 if jobs > 1 else None}
        make, notes = partial(street_scan, **of), None
    with progress(num, "scan") as bar:
        for _ in ScanFolder(output, pictures, make, Scan.save, notes).write(num, jobs=jobs, run=poses):
            bar.update()
    _report(arguments, num, around)
    _say_if_unknown(sensor, arguments)


def _scan_of_world(arguments: argparse.Namespace, sensor: Sensor, weather: Weather | None) -> Callable[[int], Scan]:
    """The function that makes the scan of --world, which has its own seed, speeds and surroundings."""
    from lidardraft.world.state import WorldState
    from lidardraft.world.world import World

    check_inputs(arguments)
    for option in ("num", "speed", "surroundings"):
        if getattr(arguments, option) is not None:
            raise FormatError(f"--{option} does not go with --world, whose state is complete")
    state = WorldState.load(arguments.world)
    with named(arguments.world):
        world = World(state, sensor, weather=weather, **_carrier(arguments))
    return lambda _: world.scan()


def _street_config(arguments: argparse.Namespace, sensor: Sensor, weather: Weather | None, poses: int) -> StreetConfig:
    from lidardraft.streets import StreetConfig
    from lidardraft.streets.drives import HALF_LENGTH

    check_inputs(arguments)
    for option in ("speed", "surroundings", "scenario", "own_returns"):
        if getattr(arguments, option):
            name = option.replace("_", "-")
            raise FormatError(f"--{name} goes with a layout; --street decides its own traffic and objects")
    mix = USUAL_MIX if arguments.street == "any" else StreetMix(**only(district_named(arguments.street)))
    config = StreetConfig(sensor=sensor, poses_per_street=poses, mix=mix, weather=weather or Weather())
    return config if arguments.frames is None else dataclasses.replace(config, half_length=HALF_LENGTH)


def simulate_options(parser: argparse.ArgumentParser) -> None:
    """The options of `simulate`."""
    parser.epilog = (
        "The layout's shapes become objects with details, the sensor's beams are cast into them, and a model of its "
        "light and receiver makes returns, ranges and intensities of that. No weights are used; every label is that of "
        "the surface that was hit. A sensor without its own model gets typical values."
    )
    inputs = add_inputs(parser, "text-file", "street", "world")
    text = f"scans of each --street in a row, from different places (default {_POSES})"
    inputs.add_argument("--poses", type=whole_number(1), metavar="N", help=text)
    world = parser.add_argument_group("world")
    add_weather(world)
    add_carrier(world)
    add_speed(world, "; in a sequence that of the road")
    sequence = parser.add_argument_group("sequence")
    text = "make a sequence of N frames: the ego vehicle, traffic and people move; with -n several, a folder each"
    sequence.add_argument("--frames", type=whole_number(1), metavar="N", help=text)
    sequence.add_argument("--hz", type=positive, metavar="R", help=f"frames a second (default {_HZ:g})")
    text = "how the ego vehicle and objects move (docs/reference/scenario.md); the rest moves by its kind"
    sequence.add_argument("--scenario", metavar="FILE.json", help=text)
    add_jobs(_add_scan_output(parser))
    add_json(parser)


def generate(arguments: argparse.Namespace) -> None:
    """Write generated scans."""
    from lidardraft.scan import Scan

    check_output(arguments)
    sensor = read_sensor(arguments.sensor)
    if arguments.map is None:
        layouts = Layouts.read(arguments)
        num, notes, around = arguments.num or len(layouts.sentences) or 1, layouts.notes, around_it(layouts.first)
    else:
        label, num, notes, around = _read_map(arguments, sensor), arguments.num or 1, None, ""
    pipeline = read_pipeline(arguments)
    with progress(num * pipeline.steps, "step", f"{num} scan{'s' * (num > 1)}") as bar:
        if arguments.map is None:
            sources, speed = map(layouts.of, range(num)), arguments.speed or 0.0
            made = pipeline.scans(sources, sensor=sensor, speed=speed, on_step=bar.update)
        else:
            seeds = range(arguments.seed, arguments.seed + num)
            made = _scans_of_map(pipeline, arguments.map, label, sensor, seeds, bar.update)
        folder = ScanFolder(Path(arguments.output), arguments.pictures, lambda _: next(made), Scan.save, notes)
        for _ in folder.write(num):
            pass
    _report(arguments, num, around)


def _scans_of_map(
    pipeline: Pipeline, path: str, label: np.ndarray, sensor: Sensor, seeds: range, on_step: Callable[[], object]
) -> Iterator[Scan]:
    from lidardraft.scan import Scan

    for seed in seeds:
        with named(path):
            image = pipeline.from_map(label, sensor=sensor, seed=seed, on_step=on_step)
        yield Scan(image=image, layout=Layout(), pose=sensor.pose(), seed=seed)


def _read_map(arguments: argparse.Namespace, sensor: Sensor) -> np.ndarray:
    from lidardraft.formats.recording import read_semantic_map

    check_inputs(arguments)
    if arguments.speed is not None or arguments.surroundings is not None:
        raise FormatError("--speed and --surroundings go with a layout; a semantic map has none")
    return read_semantic_map(arguments.map, sensor)


def generate_options(parser: argparse.ArgumentParser) -> None:
    """The options of `generate`."""
    parser.epilog = (
        "The whole scan is made from noise, and a ControlNet holds it to the cast of the layout, as the paper does; "
        "of a semantic map too, with ranges that are guessed: flat ground, and all else where it stands on it. Labels "
        "are the layout's where ranges agree with it, the network's elsewhere. A GPU makes several scans at once. "
        "Weather and sequences are `simulate`'s alone."
    )
    add_inputs(parser, "text-file", "map")
    add_speed(parser.add_argument_group("world"))
    add_weights(parser.add_argument_group("model"))
    _add_scan_output(parser)
    add_json(parser)


def observe(arguments: argparse.Namespace) -> None:
    """Write the scans of casts."""
    from lidardraft.scan import CASTS_FILE, Scan

    check_output(arguments)
    sensor = None if arguments.sensor is None else read_sensor(arguments.sensor)
    materials = assignments(arguments.materials, "--material", "CLASS=MATERIAL, as in car=dark-paint")
    weather, num = read_weather(arguments.weather), len(arguments.casts)

    def make(number: int) -> Scan:
        path, seed = arguments.casts[number], arguments.seed + number
        image = _observed(path, seed, sensor, materials, weather, arguments.carla_tags)
        return _with_its_scene(path, image, seed)

    with progress(num, "cast") as bar:
        for _ in ScanFolder(Path(arguments.output), arguments.pictures, make, Scan.save).write(num):
            bar.update()
    names = {f"{number:06d}": path for number, path in enumerate(arguments.casts)}
    write_text(Path(arguments.output, CASTS_FILE), json.dumps(names, indent=1) + "\n")
    _report(arguments, num, f"; {CASTS_FILE}")


def _with_its_scene(path: str, image: RangeImage, seed: int) -> Scan:
    """The image of a cast with its scene: pose, motion and time from its .npz, and NAME.layout.json or NAME.boxes.json
    beside it."""
    from lidardraft.drafting.boxes import layout_from_boxes
    from lidardraft.formats.boxes import read_boxes
    from lidardraft.scan import Scan, read_motion

    stem = Path(path).with_suffix("")
    told: dict[str, Any] = {"pose": image.sensor.pose(), "layout": Layout()}
    if Path(path).suffix == ".npz":
        told |= read_motion(path)
    if (beside := Path(f"{stem}.layout.json")).exists():
        told["layout"] = Layout.load(beside)
    elif (beside := Path(f"{stem}.boxes.json")).exists():
        if boxes := [box.seen_from(inverse(told["pose"])) for box in read_boxes(beside)[0]]:
            told["layout"] = layout_from_boxes(boxes)
        told["velocities"] = {box.id.split(".", 1)[0]: box.velocity for box in boxes if box.velocity is not None}
    scan = Scan(image=image, **{**told, "seed": seed})
    if image.instance.any() and scan.boxes() and not any(scan.returns_per_box()):
        say(f"{path}: no point is of an object of {beside}; the cast's instances must be those of the boxes")
    return scan


def _observed(
    path: str, seed: int, sensor: Sensor | None, materials: dict[str, str], weather: Weather | None, tags: str | None
) -> RangeImage:
    from lidardraft.formats.carla import TAGS, VERSIONS, read_carla
    from lidardraft.formats.cast import read_cast
    from lidardraft.simulation.observe_cast import observe_cast, observe_points

    made: Callable[..., RangeImage] = observe_cast
    if Path(path).suffix == ".npz":
        sensor, given = read_cast(path, sensor)
    elif sensor is None:
        raise FormatError(f"{path} does not name its sensor; give its --sensor")
    else:
        made, given = observe_points, asdict(read_carla(path, VERSIONS.get(tags or "", TAGS)))
    options = given | ({"materials": materials} if materials else {})
    with named(path):
        return made(**options, sensor=sensor, seed=seed, weather=weather)


def observe_options(parser: argparse.ArgumentParser) -> None:
    """The options of `observe`."""
    parser.epilog = (
        "An .npz cast holds images [H, W] of the sensor's rays: depth [m, 0 without a return] and label (our class "
        "ids), and where they are known instance, incidence (its cosine), materials and sensor (JSON); `lidardraft "
        "raycast` writes such a file. A .ply or .npy cloud holds x y z CosAngle ObjIdx ObjTag, as CARLA 0.9.14 and "
        "later write it; --carla-tags says if an earlier one did. Scans keep pose, speed, turn, time and velocities of "
        "an .npz, and the objects of NAME.layout.json or, in the sensor's frame, NAME.boxes.json beside a cast."
    )
    parser.add_argument("casts", nargs="+", metavar="CAST", help="an .npz cast, or CARLA's .ply or .npy")
    add_sensor(parser, default=None, of=" of these rays, if an .npz does not hold it")
    text = "material of a class, in place of the usual one; repeatable"
    metavar = "CLASS=MATERIAL"
    parser.add_argument("--material", dest="materials", action="append", default=[], metavar=metavar, help=text)
    add_carla_tags(parser)
    add_weather(parser)
    add_seed(parser)
    add_folder(parser)
    add_json(parser)


def _add_scan_output(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add --sensor, --num and the options of `add_folder`, in a group of their own."""
    output = parser.add_argument_group("output")
    add_sensor(output, of=" to make scans of")
    text = "scans to make, with seeds counting up (default 1, or one of each sentence of --text-file)"
    output.add_argument("-n", "--num", type=whole_number(1), metavar="N", help=text)
    add_folder(output)
    return output


def _report(arguments: argparse.Namespace, num: int, more: str = "") -> None:
    """Report the contents of the folder."""
    names, pictures = [f"{number:06d}" for number in range(num)], min(arguments.pictures, num)
    beside = (".label", ".boxes.json", ".png")
    each = [ending for ending in beside if all(Path(arguments.output, f"{name}{ending}").exists() for name in names)]
    listed = " and ".join(filter(None, (", ".join(each[:-1]), each[-1])))
    last = f" to {names[-1]}.bin" if num > 1 else ""
    some = f"; the first {pictures} with .png" if 0 < pictures < num else ""
    text = f"{arguments.output}: {num} scan{'s' * (num > 1)}, 000000.bin{last}, each with {listed}{some}{more}"
    report(arguments, text, output=arguments.output, scans=num)
