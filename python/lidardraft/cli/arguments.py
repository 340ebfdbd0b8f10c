"""Options that several commands have, and what their values may be."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from lidardraft.scene.sensor import PRESETS

if TYPE_CHECKING:
    Options = argparse.ArgumentParser | argparse._ArgumentGroup  # what options can be added to

DEFAULT_SENSOR = "hdl64e"


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


def minutes(text: str) -> float:
    """The type of an option that takes minutes: a number over 0, or inf."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not value > 0:  # nan is not
        raise argparse.ArgumentTypeError(f"{text!r} is not a number over 0")
    return value


def add_sensor(parser: Options, *, default: str | None = DEFAULT_SENSOR, of: str = "") -> None:
    """--sensor; `of` says which sensor is meant."""
    text = f"sensor{of}: {', '.join(PRESETS)}, or a .json file (default {DEFAULT_SENSOR})"
    parser.add_argument("--sensor", default=default, metavar="NAME", help=text)


def add_seed(parser: Options, *, default: int = 0) -> None:
    """--seed."""
    text = f"seed of all random choices: the same seed gives the same result (default {default})"
    parser.add_argument("--seed", type=whole_number(0, 2**32 - 1), default=default, metavar="S", help=text)


def add_weights(parser: Options) -> None:
    """What runs the diffusion model: --weights, --steps, --device."""
    parser.add_argument(
        "--weights",
        default="street",
        metavar="NAME",
        help="weights of the diffusion model: packaged ones by name, or a .safetensors file (default street)",
    )
    text = "steps of denoising: more are slower and a little better (default 20)"
    parser.add_argument("--steps", type=whole_number(1), default=20, metavar="N", help=text)
    parser.add_argument("--device", default="cpu", help="where torch runs the model: cpu, cuda, ... (default cpu)")
