"""`lidardraft studio`: a page in the browser in which scenes are made, changed, scanned and kept."""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import add_sensor, add_weather, read_sensor, read_weather, whole_number
from lidardraft.cli.command import Parser, say
from lidardraft.cli.inputs import (
    ENDINGS,
    add_inputs,
    check_inputs,
    gives_input,
    layout_of_input,
    read_layout,
    recorded_points,
)
from lidardraft.errors import FormatError, extra
from lidardraft.files import named
from lidardraft.scene.layout import Layout

if TYPE_CHECKING:
    from lidardraft.studio.page import Inputs

_PORT = 8080


def studio(arguments: argparse.Namespace) -> None:
    """Serve the page until Ctrl-C."""
    from lidardraft.studio.editor import Editor
    from lidardraft.studio.page import SENTENCE
    from lidardraft.studio.server import served
    from lidardraft.world.state import WorldState

    sensor, weather, seed = read_sensor(arguments.sensor), read_weather(arguments.weather), arguments.seed
    model = {name: value for name, value in vars(arguments).items() if name.startswith("llm_")}
    given = argparse.Namespace(**vars(arguments) | ({} if arguments.text else dict.fromkeys(model)))
    check_inputs(given)
    if arguments.world is not None and arguments.surroundings is not None:
        raise FormatError("--surroundings does not go with --world, whose state is complete")
    if arguments.world is not None:
        state = WorldState.load(arguments.world)
        first: Layout | WorldState = state
        seed = state.seed
    else:
        first = read_layout(given if gives_input(given) else _asked(arguments.sensor, seed, f"--text={SENTENCE}"))
    with named(arguments.world or "the scene"):  # a scene that cannot be scanned ends the command before the page
        ready = [Editor(first, (sensor,), seed=seed, weather=weather)]

    def begin() -> Editor:
        return ready.pop() if ready else Editor(first, (sensor,), seed=seed, weather=weather)

    inputs = inputs_of(arguments.sensor, None if arguments.output is None else Path(arguments.output), model)
    with served(begin, inputs, arguments.port) as running:
        if running.port != arguments.port:
            say(f"port {arguments.port} is taken; the studio is on {running.port}")
        print(f"{running.url}  (Ctrl-C ends it)", flush=True)
        while True:
            time.sleep(10.0)
            running.tidy()


def inputs_of(sensor: str, folder: Path | None, model: Mapping[str, object] | None = None) -> Inputs:
    """The readers of all inputs, as in commands; files without a sensor are of `sensor`, and `model` are the options of
    a language model that reads sentences."""
    from lidardraft.studio.page import Inputs
    from lidardraft.studio.session import Draft

    def read(kind: str, value: str, seed: int, scale: float = 0.0) -> Draft:
        unit = {"sketch": "metres-per-pixel", "obj": "scale", "glb": "scale", "blender": "scale"}.get(kind)
        more = [f"--{unit}={scale}"] if unit and scale else []
        asked = _asked(sensor, seed, f"--{kind}={value}", *more)
        if kind == "text":
            vars(asked).update(model or {})
        with extra():
            layout = layout_of_input(asked)
        return Draft(layout, recorded_points(asked)) if kind == "points" else Draft(layout)

    def generator() -> object:
        with extra("generate"):
            from lidardraft.pipeline import Pipeline

        return Pipeline.from_pretrained()

    return Inputs(read, read_sensor, ENDINGS, generator, folder)


def _asked(sensor: str, seed: int, *given: str) -> argparse.Namespace:
    """The arguments of an input alone, as from the command line."""
    parser = Parser(add_help=False)
    add_inputs(parser)
    add_sensor(parser)
    return parser.parse_args([*given, f"--sensor={sensor}", f"--seed={seed}"])


def studio_options(parser: argparse.ArgumentParser) -> None:
    """The options of `studio`."""
    parser.epilog = (
        "The page is on this machine alone. From another one, open a tunnel first, as in `ssh -L 8080:localhost:8080 "
        "HOST`. Each visitor has a scene of their own. Where --llm-url or $LIDARDRAFT_LLM_URL names a language model, "
        "it reads the sentences."
    )
    add_inputs(parser, "world", required=False)
    add_sensor(parser.add_argument_group("sensor"))
    add_weather(parser)
    text = f"port of the page, or the next one that is free (default {_PORT})"
    parser.add_argument("--port", type=whole_number(1, 65535), default=_PORT, metavar="P", help=text)
    text = "folder on this machine for files that visitors keep (default: they are downloads)"
    parser.add_argument("-o", "--output", metavar="FOLDER", help=text)
