"""`lidardraft observe`: what a sensor reports of casts that another renderer made."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import add_seed, add_sensor, add_weather, assignments, read_sensor, read_weather
from lidardraft.cli.scan_folder import add_folder, check_output, write_observed
from lidardraft.errors import FormatError
from lidardraft.files import named
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather

if TYPE_CHECKING:
    from lidardraft.scene.range_image import RangeImage


def observe(arguments: argparse.Namespace) -> None:
    """Add ray drop, noise and intensity to the casts of another renderer, which keep their labels: range and class
    images, or clouds of CARLA's semantic LiDAR."""
    check_output(arguments)
    sensor = None if arguments.sensor is None else read_sensor(arguments.sensor)
    materials = assignments(arguments.materials, "--material", "CLASS=MATERIAL, as in car=dark-paint")
    weather = read_weather(arguments.weather)
    write_observed(arguments, _observed(arguments, sensor, materials, weather))


def _observed(
    arguments: argparse.Namespace, sensor: Sensor | None, materials: dict[str, str], weather: Weather
) -> Iterator[RangeImage]:
    from tqdm import tqdm

    from lidardraft.formats.carla import read_carla
    from lidardraft.formats.cast import read_cast
    from lidardraft.simulation.observe_cast import observe_cast, observe_points

    for number, path in enumerate(tqdm(arguments.casts, unit="cast", disable=None)):
        seed = arguments.seed + number
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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
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
    add_folder(parser)
