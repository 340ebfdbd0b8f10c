"""Options shared by several commands, and checks of their values."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lidardraft.diffusion.denoiser_config import GUIDANCE, STEPS
from lidardraft.errors import FormatError, SensorError, one_of
from lidardraft.files import read_text
from lidardraft.formats.carla import TAGS, VERSIONS
from lidardraft.formats.ouster import is_ouster_metadata, read_ouster_metadata
from lidardraft.scene.layout import Layout
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.weather import Weather

if TYPE_CHECKING:
    from lidardraft.pipeline import Pipeline

    Options = argparse.ArgumentParser | argparse._ArgumentGroup  # options can be added to these

DEFAULT_SENSOR = "hdl64e"
_MOST_PIXELS = 2**22  # of the images of a sensor in a file, eight times those of the largest sensors
# The names of the numbers of `Weather` in --weather, and the unit that may follow the amount.
_WEATHER = {"rain": ("rain", "mm"), "snow": ("snow", "mm"), "fog": ("visibility", "m"), "wet": ("wetness", "")}
FRAME_HELP = "scan of a log, .mcap, .db3, .pcap or .osf, by its number, from 0 (default 0)"
TOPIC_HELP = "topic of points in a ROS 2 bag that has several"


def whole_number(least: int, most: int | None = None) -> Callable[[str], int]:
    """The type of an option that takes whole numbers from `least` to `most`."""
    limits = f"of {least} or more" if most is None else f"from {least} to {most}"

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least or (most is not None and value > most):
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number {limits}")
        return value

    return parse


def number(text: str) -> float:
    """The type of an option that takes any finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number")
    return value


def assignments(texts: list[str], option: str, form: str) -> dict[str, str]:
    """The values of a repeatable option of the `form` NAME=VALUE; raises `FormatError` for any other form."""
    given = {}
    for text in texts:
        name, sign, value = text.rpartition("=")
        if not (name and sign and value):
            raise FormatError(f"{option} is {text!r}; it must be {form}")
        given[name] = value
    return given


def positive(text: str) -> float:
    """The type of an option that takes any finite number over 0."""
    value = number(text)
    if not value > 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number over 0")
    return value


def minutes(text: str) -> float:
    """The type of an option that takes minutes: a number over 0, or inf."""
    return math.inf if text == "inf" else positive(text)


def in_folder(output: str, name: str) -> str:
    """The file of --output: itself, or `name` in it if it is a folder, which is created if it ends in a slash."""
    folder = Path(output)
    if output.endswith("/"):
        folder.mkdir(parents=True, exist_ok=True)
    return str(folder / name) if folder.is_dir() else output


def add_sensor(parser: Options, *, default: str | None = DEFAULT_SENSOR, of: str = "") -> None:
    """Add --sensor; `of` says which sensor it is."""
    text = f"sensor{of}: {', '.join(PRESETS)}, or a .json file, Ouster's metadata too"
    text += f" (default {default})" if default else ""
    parser.add_argument("--sensor", default=default, metavar="NAME", help=text)


def add_reading(parser: Options) -> None:
    """Add the options of how a scan is read, --intensity-scale and --carla-tags, for `reading`."""
    text = "number for an intensity of 1 in the scan, such as 255 (default: that of its format, or of whole "
    text += "numbers by their type; else 1)"
    parser.add_argument("--intensity-scale", type=positive, metavar="X", help=text)
    add_carla_tags(parser)


def add_log(parser: Options) -> None:
    """Add the choice of a scan in a log, --frame and --topic, for `reading`."""
    parser.add_argument("--frame", type=whole_number(0), metavar="N", help=FRAME_HELP)
    parser.add_argument("--topic", metavar="NAME", help=TOPIC_HELP)


def add_carla_tags(parser: Options) -> None:
    """Add --carla-tags."""
    text = "tags in a cloud of CARLA's semantic LiDAR: of 0.9.13 and before, or of 0.9.14 and later (default)"
    parser.add_argument("--carla-tags", choices=VERSIONS, help=text)


def reading(arguments: argparse.Namespace) -> dict[str, Any]:
    """The arguments of `read_points` from the options of `add_reading`."""
    said = {"intensity_scale": arguments.intensity_scale, "carla_tags": VERSIONS.get(arguments.carla_tags, TAGS)}
    return said | {name: getattr(arguments, name, None) for name in ("frame", "topic")}


def read_sensor(name: str) -> Sensor:
    """The sensor of a value of --sensor: a file of lidardraft or Ouster's metadata, or a preset; else raises
    `SensorError`. Errors name the file."""
    if Path(name).suffix == ".json":
        sensor = read_ouster_metadata(name) if is_ouster_metadata(read_text(name)) else Sensor.load(name)
        if math.prod(sensor.shape) > _MOST_PIXELS:
            size = "{} x {}".format(*sensor.shape)
            raise SensorError(f"{name}: {size} pixels; images of up to {_MOST_PIXELS} are made")
        return sensor
    if name not in PRESETS:
        raise SensorError(f"sensor is {name!r}; it must be a .json file or {one_of(PRESETS, name)}")
    return Sensor.preset(name)


def add_carrier(parser: Options) -> None:
    """Add --carrier, for `read_carrier`, and --own-returns."""
    text = "vehicle of the sensor, which hides the ground: car (that of the preset), none, or a layout file with its "
    text += "shapes around the origin (default car)"
    parser.add_argument("--carrier", default="car", metavar="VEHICLE", help=text)
    parser.add_argument("--own-returns", action="store_true", help="keep the returns of the vehicle itself")


def read_carrier(name: str) -> bool | Layout:
    """The carrier of a value of --carrier, as in `simulate`."""
    return name == "car" if name in ("car", "none") else Layout.load(name)


def add_seed(parser: Options, *, default: int = 0) -> None:
    """Add --seed."""
    text = f"seed of all random choices: the same seed gives the same result (default {default})"
    parser.add_argument("--seed", type=whole_number(0, 2**32 - 1), default=default, metavar="S", help=text)


def add_minutes(parser: Options) -> None:
    """Add --minutes of a training."""
    text = "stop after so many minutes; the same call goes on (default: no limit)"
    parser.add_argument("--minutes", type=minutes, default=math.inf, metavar="M", help=text)


def add_training_device(parser: Options) -> None:
    """Add --device of a training."""
    text = "device for training: cpu, cuda, ... (default: the GPU if there is one, else cpu)"
    parser.add_argument("--device", help=text)


def add_weights(parser: Options) -> None:
    """Add the options of the diffusion model, --weights, --steps, --guidance and --device, for `read_pipeline`."""
    parser.add_argument(
        "--weights",
        default="paper",
        metavar="NAME",
        help="weights of the diffusion model: packaged ones by name, or a .safetensors file (default paper)",
    )
    stored = "(default: as stored with the weights, else"
    text = f"steps of denoising, a call of the network each, two with `paper` {stored} {STEPS})"
    parser.add_argument("--steps", type=whole_number(1), metavar="N", help=text)
    text = f"weight of the ControlNet; 1 takes one call of the network a step {stored} {GUIDANCE:g})"
    parser.add_argument("--guidance", type=positive, metavar="W", help=text)
    parser.add_argument("--device", default="cpu", help="device for the model: cpu, cuda, ... (default cpu)")


def read_pipeline(arguments: argparse.Namespace) -> Pipeline:
    """The diffusion model that the options of `add_weights` name."""
    from lidardraft.pipeline import Pipeline

    return Pipeline.from_pretrained(
        arguments.weights, device=arguments.device, steps=arguments.steps, guidance=arguments.guidance
    )


def add_speed(parser: Options, more: str = "") -> None:
    """Add --speed."""
    text = f"how fast the sensor moves ahead while it sweeps [m/s] (default 0{more})"
    parser.add_argument("--speed", type=number, metavar="V", help=text)


def add_weather(parser: Options) -> None:
    """Add --weather, for `read_weather`."""
    text = "rain:10mm or snow:2mm (of water, an hour), fog:100m (visibility), wet:0.5 (of the ground); repeatable "
    text += "(default: that of --text, or clear and dry)"
    parser.add_argument("--weather", action="append", default=[], metavar="KIND:AMOUNT", help=text)


def read_weather(texts: Iterable[str]) -> Weather | None:
    """The weather of the values of --weather, as in `rain:10mm`; None without any.

    Raises `FormatError` on another text, `SensorError` on an invalid amount.
    """
    amounts = {}
    for text in texts:
        kind, _, amount = text.partition(":")
        if kind not in _WEATHER:
            raise FormatError(f"--weather is {text!r}; its kind must be {one_of(_WEATHER, kind)}")
        field, unit = _WEATHER[kind]
        if not re.fullmatch(rf"\d+(\.\d+)?({unit})?", amount):
            raise FormatError(f"--weather is {text!r}; it must be {kind} and an amount, as in {kind}:0.5{unit}")
        if field in amounts:
            raise FormatError(f"--weather has {kind} twice")
        amounts[field] = float(amount.removesuffix(unit))
    return Weather(**amounts) if amounts else None


def check_empty(folder: Path, otherwise: str, *, but: str = "") -> None:
    """Raises `FormatError` if the folder is a file, or has contents other than hidden files and matches of `but`.

    `otherwise` is the user's alternative, for the message.
    """
    if folder.exists() and not folder.is_dir():
        raise FormatError(f"{folder} is a file; it must be a folder")
    content = sorted(path.name for path in folder.glob("[!.]*") if not re.fullmatch(but, path.name))
    if content:
        more = f" and {len(content) - 1} more" if len(content) > 1 else ""
        raise FormatError(f"{folder} is not empty ({content[0]}{more}); use another folder{otherwise}")
