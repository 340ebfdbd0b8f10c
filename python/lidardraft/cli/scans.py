"""`lidardraft simulate`, `generate` and `observe`: labelled scans, a seed each, in a folder of their own."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from lidardraft.cli.arguments import (
    add_seed,
    add_sensor,
    add_speed,
    add_weather,
    add_weights,
    assignments,
    check_empty,
    number,
    read_sensor,
    read_weather,
    whole_number,
)
from lidardraft.cli.inputs import add_inputs, layout_of_text, read_layout
from lidardraft.errors import FormatError
from lidardraft.files import named
from lidardraft.scene.layout import Layout
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather

if TYPE_CHECKING:
    from lidardraft.cli.arguments import Options
    from lidardraft.pipeline import Pipeline
    from lidardraft.scan import Scan
    from lidardraft.scene.range_image import RangeImage
T = TypeVar("T")


def simulate(arguments: argparse.Namespace) -> None:
    """Make labelled LiDAR scans by physics alone, from a sentence, a layout, a 3D model or a labelled scan."""
    _check_output(arguments)
    sensor, weather = read_sensor(arguments.sensor), read_weather(arguments.weather)
    layout = read_layout(arguments)
    _write_scans(arguments, _simulated(arguments, sensor, weather, layout))


def _simulated(arguments: argparse.Namespace, sensor: Sensor, weather: Weather, layout: Layout) -> Iterator[Scan]:
    from tqdm import tqdm

    from lidardraft.simulation.simulate import Simulator

    with tqdm(total=arguments.num, unit="scan", disable=None) as bar:
        for seed, each in _layouts(arguments, layout):
            simulator = Simulator(each, sensor, seed=seed, weather=weather, clutter=arguments.clutter)
            yield simulator.scan(speed=arguments.speed, seed=seed)
            bar.update()


def simulate_options(parser: argparse.ArgumentParser) -> None:
    """The options of `simulate`."""
    parser.epilog = (
        "The layout's shapes become objects with details, the sensor's beams are cast into them, and a model of its "
        "light and receiver makes returns, ranges and intensities of that. No weights are used; every label is that of "
        "the surface that was hit. A sensor without a model of its own gets typical values."
    )
    add_inputs(parser)
    world = parser.add_argument_group("world")
    add_weather(world)
    add_speed(world)
    text = "what stands beside the roads and is not in the layout, from 0 (nothing) to 1 (default 0)"
    world.add_argument("--clutter", type=number, default=0.0, metavar="SHARE", help=text)
    _add_scan_output(parser)


def generate(arguments: argparse.Namespace) -> None:
    """Make labelled LiDAR scans with the diffusion model, from a sentence, a layout, a 3D model or a labelled scan."""
    _check_output(arguments)
    sensor = read_sensor(arguments.sensor)
    layout = read_layout(arguments)

    from lidardraft.pipeline import Pipeline

    pipeline = Pipeline.from_pretrained(
        arguments.weights,
        device=arguments.device,
        steps=arguments.steps,
        guidance=arguments.guidance,
        langevin=arguments.langevin,
    )
    _write_scans(arguments, _generated(pipeline, arguments, sensor, layout))


def _generated(pipeline: Pipeline, arguments: argparse.Namespace, sensor: Sensor, layout: Layout) -> Iterator[Scan]:
    from tqdm import tqdm

    with tqdm(total=arguments.num * arguments.steps, unit="step", disable=None) as bar:
        for count, (seed, each) in enumerate(_layouts(arguments, layout), start=1):
            bar.set_description(f"scan {count} of {arguments.num}")
            yield pipeline(each, sensor=sensor, seed=seed, speed=arguments.speed, on_step=bar.update)


def generate_options(parser: argparse.ArgumentParser) -> None:
    """The options of `generate`."""
    parser.epilog = (
        "The weights `street` keep the simulated scan of what the layout gives, and make up what it leaves open: what "
        "stands around a sentence's road, a sketch or boxes, and what a picture does not show; another world for each "
        "seed. A recorded scan, a 3D model or a Blender script leaves nothing open: there `generate` adds nothing to "
        "`simulate`, and says so. The weights `paper` make the whole scan from noise, guided by the layout, as the "
        "paper does. Classes of what is made up are the network's. Weather and clutter are `simulate`'s alone: no "
        "weights have seen them."
    )
    add_inputs(parser)
    add_speed(parser.add_argument_group("world"))
    model = parser.add_argument_group("model")
    add_weights(model)
    text = (
        "sample by annealed Langevin dynamics as the paper does, with N updates a step (LiDARGen: --steps 232 "
        "--langevin 5): slow (default: the fast solver)"
    )
    model.add_argument("--langevin", type=whole_number(1), metavar="N", help=text)
    _add_scan_output(parser)


def observe(arguments: argparse.Namespace) -> None:
    """Add ray drop, noise and intensity to the casts of another renderer, which keep their labels: range and class
    images, or clouds of CARLA's semantic LiDAR."""
    _check_output(arguments)
    sensor = None if arguments.sensor is None else read_sensor(arguments.sensor)
    materials = assignments(arguments.materials, "--material", "CLASS=MATERIAL, as in car=dark-paint")
    weather = read_weather(arguments.weather)
    _write_observed(arguments, _observed(arguments, sensor, materials, weather))


def _observed(
    arguments: argparse.Namespace, sensor: Sensor | None, materials: dict[str, str], weather: Weather
) -> Iterator[RangeImage]:
    from tqdm import tqdm

    from lidardraft.formats.carla import read_carla
    from lidardraft.formats.cast import read_cast
    from lidardraft.simulation.observe_cast import observe_cast, observe_points

    for seed, path in enumerate(tqdm(arguments.casts, unit="cast", disable=None), start=arguments.seed):
        if Path(path).suffix == ".npz":
            of_cast, images = read_cast(path, sensor)
            depth, label = images.pop("depth"), images.pop("label")
            with named(path):
                options = images if not materials else images | {"materials": materials}
                yield observe_cast(depth, label, of_cast, seed=seed, weather=weather, **options)
        elif sensor is None:
            raise FormatError(f"{path} does not say by which sensor it is; give its --sensor")
        else:
            cloud = read_carla(path)
            with named(path):
                yield observe_points(
                    cloud.points,
                    cloud.label,
                    sensor,
                    instance=cloud.instance,
                    incidence=cloud.incidence,
                    materials=materials or cloud.materials,
                    seed=seed,
                    weather=weather,
                )


def observe_options(parser: argparse.ArgumentParser) -> None:
    """The options of `observe`."""
    parser.epilog = (
        "An .npz cast holds images [H, W] of the sensor's rays: depth [m, 0 without a return] and label (our class "
        "ids), and where they are known instance, incidence (its cosine), materials and sensor (JSON); `lidardraft "
        "raycast` writes such a file. A .ply or .npy cloud holds x y z CosAngle ObjIdx ObjTag, as CARLA 0.9.14 and "
        "later write it."
    )
    parser.add_argument("casts", nargs="+", metavar="CAST", help="an .npz cast, or CARLA's .ply or .npy")
    add_sensor(parser, default=None, of=" whose rays they are, where an .npz does not hold it")
    text = "material of a class, in place of the usual one; repeatable"
    parser.add_argument(
        "--material", dest="materials", action="append", default=[], metavar="CLASS=MATERIAL", help=text
    )
    add_weather(parser)
    add_seed(parser)
    _add_folder(parser)


def _add_scan_output(parser: argparse.ArgumentParser) -> None:
    """--sensor, --num, --output and --overwrite, in a group of their own."""
    output = parser.add_argument_group("output")
    add_sensor(output, of=" to make scans of")
    text = "scans to make, with seeds counting up (default 1)"
    output.add_argument("-n", "--num", type=whole_number(1), default=1, metavar="N", help=text)
    _add_folder(output)


def _add_folder(parser: Options) -> None:
    """--output and --overwrite."""
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="where scans go: new or empty")
    parser.add_argument("--overwrite", action="store_true", help="replace the scans that are in FOLDER already")


def _check_output(arguments: argparse.Namespace) -> None:
    """Raises `FormatError` where the folder holds anything and --overwrite is not given."""
    otherwise = ", or --overwrite to replace its scans"
    check_empty(Path(arguments.output), otherwise, but=".*" if arguments.overwrite else "")


def _layouts(arguments: argparse.Namespace, first: Layout) -> Iterator[tuple[int, Layout]]:
    """Seed and layout of each scan: `first`, which a sentence replaces with another one for each further seed."""
    yield arguments.seed, first
    for seed in range(arguments.seed + 1, arguments.seed + arguments.num):
        if arguments.text is None:
            yield seed, first
        else:
            yield seed, layout_of_text(arguments, seed)


def _write_scans(arguments: argparse.Namespace, scans: Iterable[Scan]) -> None:
    """Save the scans, numbered from 0; those of an earlier call go when the first one is there."""
    from lidardraft.scan import Scan

    _write(arguments, scans, Scan.save, ".label, .boxes.json and .png")


def _write_observed(arguments: argparse.Namespace, images: Iterable[RangeImage]) -> None:
    """As `_write_scans`, of images without a layout."""
    from lidardraft.scan import save_observed

    _write(arguments, images, save_observed, ".label and .png")


def _write(arguments: argparse.Namespace, scans: Iterable[T], save: Callable[[T, Path], None], beside: str) -> None:
    folder, count = Path(arguments.output), 0
    for count, scan in enumerate(scans, start=1):
        if count == 1:
            _clear(folder)
        save(scan, folder / f"{count - 1:06d}")
    last = f" to {count - 1:06d}.bin" if count > 1 else ""
    print(f"{folder}: {count} scan{'s' * (count > 1)}, 000000.bin{last}, each with {beside}")


def _clear(folder: Path) -> None:
    """Make the folder, without the scans of an earlier call: numbers with a sensor beside them. The rest stays."""
    from lidardraft.scan import SCAN_ENDINGS

    folder.mkdir(parents=True, exist_ok=True)
    for sensor in folder.glob("*.sensor.json"):
        name = sensor.name.removesuffix(".sensor.json")
        if name.isdigit():
            for ending in SCAN_ENDINGS:
                (folder / f"{name}{ending}").unlink(missing_ok=True)
