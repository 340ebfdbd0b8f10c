"""The inputs of a layout: a sentence, a picture, a scan, a sketch, boxes, a 3D model, a script, or a layout file."""

from __future__ import annotations

import argparse
import math
import os
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.arranging.district import STREET_DISTRICTS
from lidardraft.cli.arguments import (
    DEFAULT_SENSOR,
    TOPIC_HELP,
    add_reading,
    add_seed,
    assignments,
    number,
    read_sensor,
    reading,
)
from lidardraft.cli.command import say
from lidardraft.errors import FormatError, LidarDraftError, MissingExtraError, TextError, extra, one_of
from lidardraft.files import named
from lidardraft.scene.box import Box
from lidardraft.scene.layout import AROUND, Layout
from lidardraft.scene.scenario import Scenario
from lidardraft.scene.sensor import Sensor

_PICTURES = (".png", ".jpg", ".jpeg", ".webp")
_MODELS = ("obj", "glb", "blender")
_TEXTS = ("text", "text_file")
_FILE, _METRES, _FLAG = {"metavar": "FILE"}, {"type": number, "metavar": "M"}, {"action": "store_true", "default": None}

# The inputs by their options: the name of a value, the endings of its files, and a description.
_INPUTS: dict[str, tuple[str, tuple[str, ...], str]] = {
    "text": ("SENTENCE", (), 'what is on the road, in English: "two cars on the left"'),
    "image": ("PHOTO.jpg", _PICTURES, "a picture of a road: JPEG, PNG or WebP"),
    "points": ("SCAN", (".bin", ".pcd", ".ply", ".npz", ".npy", ".las", ".gz", ".pcap", ".osf", ".mcap", ".db3"),
        "a scan: KITTI .bin (float32 x y z [m] and intensity), nuScenes .pcd.bin, PandaSet .pkl.gz, .pcd, .ply, .npz, "
        ".npy, .las, a ROS 2 bag (.mcap, .db3 or its folder), or an Ouster's .osf, or .pcap with its .json beside it"),
    "sketch": ("FILE", (".svg", *_PICTURES), "a sketch from above: .svg, or a painted picture (.png, .jpg)"),
    "boxes": ("FILE", (".json", ".txt", ".gz"), "boxes around objects: .boxes.json, KITTI's label_2, ..."),
    "obj": ("FILE.obj", (".obj",), "a 3D model: Wavefront OBJ with the ego vehicle at its origin"),
    "glb": ("FILE.glb", (".glb", ".gltf"), "a 3D model: binary glTF, as Blender exports it"),
    "blender": ("FILE.py", (".py",), "a Blender Python script; it is read as data, never run"),
    "layout": ("LAYOUT.json", (".json",),
        "a layout, as `lidardraft draft` writes it; by itself it gets no street (see --surroundings)"),
}  # fmt: skip

ENDINGS = {name: endings for name, (_, endings, _) in _INPUTS.items() if endings}

# Options that say more about inputs: the inputs, the type of a value, and the help.
_OPTIONS: dict[str, tuple[tuple[str, ...], dict[str, Any], str]] = {
    "labels": (("points",), _FILE,
        "labels of --points: SemanticKITTI's .label, lidarseg or masks (default: those in it or beside it)"),
    "segmenter": (("points",), _FILE,
        "weights of `lidardraft-train segmenter` for --points without labels (default: the packaged ones)"),
    "detail": (("points",), {"choices": ("fine", "objects")},
        "fine: as near to --points as their cast can be (default); objects: few whole ones, to edit by hand"),
    "sensor_height": (("points", "boxes"), _METRES,
        "height over the road of the sensor of --points or --boxes (default that of its sensor)"),
    "metres_per_pixel": (("sketch",), _METRES, "length of a pixel of --sketch, in metres"),
    "scale_bar": (("sketch",), _METRES, "length of the black bar in a painted --sketch"),
    "class": (_MODELS, {"dest": "classes", "action": "append", "metavar": "NAME=CLASS"},
        "class of the objects, materials or collections of that name in --obj, --glb or --blender, where their names "
        "say none or another; repeatable"),
    "strict": (("blender", *_TEXTS), _FLAG,
        "refuse a --text that is not understood or not shown as it says, and a --blender script in which the names of "
        "an object say no class, in place of a note"),
    "up": (("obj", "glb"), {"choices": ("y", "z")}, "axis that points up in --obj (default z) or --glb (default y)"),
    "scale": (_MODELS, _METRES,
        "length of a unit of --obj, --glb or --blender, in metres (default 1; 0.01 for centimetres)"),
    "recentre": (_MODELS, _FLAG,
        "move --obj, --glb or --blender: the middle of its ground becomes the origin, the place of the sensor"),
    "as_is": ((*_MODELS, "boxes"), _FLAG,
        "read --obj, --glb, --blender or --boxes whatever the sizes of vehicles and people in it say of its unit"),
    "frame": (("boxes", "points"), {"type": int, "metavar": "N"},
        "frame of KITTI's tracking labels in --boxes, or of a log in --points, from 0 (default 0)"),
    "topic": (("points",), {"metavar": "NAME"}, TOPIC_HELP),
    "explain": (_TEXTS, _FLAG, "report the effect of each word of --text, and words not understood"),
    "depth": (("image",), {"metavar": "MODEL"},
        "depth of --image: a metric depth network (id or folder), or an .npy file [m], 0 if unknown (default: Depth "
        "Anything V2, outdoor, small)"),
    "semantics": (("image",), {"metavar": "MODEL"},
        "classes of --image: a segmentation network (id or folder), or an .npy or .png file of Cityscapes train ids "
        "(default: EoMT on Cityscapes)"),
    "masks": (("image",), _FILE,
        "objects of --image: an .npz, .npy or .png file of masks, or a network for them such as SAM (id or folder) "
        "(default: points that touch)"),
    "intrinsics": (("image",), {"metavar": "FX,FY,CX,CY"},
        "camera of --image in pixels, or a file: .json, or a calibration of KITTI"),
    "hfov": (("image",), {"type": number, "metavar": "DEGREES"},
        "horizontal field of view of --image (default: from the focal length in the file)"),
    "camera_height": (("image",), _METRES, "height of the camera over the road, which sets the scale (default 1.65)"),
    "metric_depth": (("image",), _FLAG,
        "take depth of --image as metres: it sets the scale, and the height of the camera"),
    "llm_url": (_TEXTS, {"metavar": "URL"},
        "server that answers as OpenAI's does, as in http://localhost:11434/v1 (default $LIDARDRAFT_LLM_URL; '' is "
        "none); its key, if it wants one, is read from $LIDARDRAFT_LLM_KEY alone"),
    "llm_model": (_TEXTS, {"metavar": "NAME"}, "model of the server (default $LIDARDRAFT_LLM_MODEL)"),
    "llm_blender": (_TEXTS, _FLAG,
        "have the model write a Blender script, which is read as data, instead of relations"),
    "llm_cache": (_TEXTS, {"metavar": "FOLDER"},
        "folder for replies; the same request is not sent again (default: the user's cache folder)"),
    "llm_timeout": (_TEXTS, {"type": number, "metavar": "SECONDS"},
        "how long all replies together may take (default 120)"),
}  # fmt: skip
# Options of `add_reading` and of commands.
_OTHERS = {"intensity_scale": ("points",), "carla_tags": ("points",), "poses": ("street",)}

# Endings in folders; an .npy may be anything.
_SCANS = (".bin", ".pcd", ".ply", ".npz", ".las", ".pkl.gz", ".pcap", ".osf", ".mcap", ".db3")

_SENSORS = {".pcd.bin": "hdl32e", ".pkl.gz": "pandar64"}  # of nuScenes and PandaSet, by endings
_STREET_AROUND = ("text", "sketch", "boxes", "image")  # inputs with a street around them by default
_MOST_NOTES = 10  # printed
_URL = "LIDARDRAFT_LLM_URL"  # as in chat_server.py, which imports HTTP


# Inputs of many layouts, for some commands: their values and descriptions.
_MANY = {
    "text-file": ("FILE.txt", "sentences, one a line: a scan of each, and again with other seeds if -n is larger"),
    "world": (
        "FILE.world.json",
        "the state of a World or of the studio: its scan, in which all moves as it does there",
    ),
    "map": ("FILE", "a semantic map without ranges: .png or .npy of a class id for each ray, or a labelled scan"),
    "street": (
        "DISTRICT",
        f"invented streets with all their objects and traffic: any, {', '.join(STREET_DISTRICTS)}, or a word for one",
    ),
}


def add_inputs(parser: argparse.ArgumentParser, *many: str, required: bool = True) -> argparse._ArgumentGroup:
    """Add the inputs, exactly one of which a command takes, in a group of their own; `many` are those of `_MANY` that
    it takes."""
    names = ", ".join(f"--{name}" for name in (*_INPUTS, *many))
    group = parser.add_argument_group(f"input ({'exactly' if required else 'at most'} one of {names})")
    one = group.add_mutually_exclusive_group(required=required)
    for name, (value, _, text) in _INPUTS.items():
        one.add_argument(f"--{name}", metavar=value, help=text)
    for name in many:
        value, text = _MANY[name]
        one.add_argument(f"--{name}", metavar=value, help=text)
    add_reading(group)
    title = "language model (reads --text if its URL is given; else nothing is sent)"
    model = parser.add_argument_group(title)
    for name, (_, how, text) in _OPTIONS.items():
        (model if name.startswith("llm_") else group).add_argument(f"--{name.replace('_', '-')}", help=text, **how)
    usual = f"street with {', '.join(f'--{name}' for name in _STREET_AROUND)}, else bare"
    text = "street: buildings, plants, traffic and people around the input, which stays unchanged and in sight; "
    text += f"their ids begin with {AROUND}; level: the same on level ground; bare: nothing is added "
    text += f"(default: {usual})"
    group.add_argument("--surroundings", choices=("street", "level", "bare"), help=text)
    add_seed(group)
    return group


def district_named(word: str) -> str:
    """As `district_of`; raises `FormatError` where there is none."""
    from lidardraft.drafting.text.lexicon import district_of

    if (name := district_of(word)) is None:
        raise FormatError(f"--street is {word!r}; it must be {one_of(('any', *STREET_DISTRICTS), word)}")
    return name


def check_inputs(arguments: argparse.Namespace) -> None:
    """Raises `FormatError` if an option says more about an input that is not given."""
    given = {name for name, value in vars(arguments).items() if value is not None}
    for name, inputs in ({name: inputs for name, (inputs, *_) in _OPTIONS.items()} | _OTHERS).items():
        if ("classes" if name == "class" else name) in given and not given & set(inputs):
            needed = " or ".join(f"--{each.replace('_', '-')}" for each in inputs if hasattr(arguments, each))
            raise FormatError(f"--{name.replace('_', '-')} goes with {needed}")


def read_layout(arguments: argparse.Namespace) -> Layout:
    """The layout of the arguments; its notes on input left out or not understood are printed on stderr."""
    layout, name = layout_of_input(arguments), _name_of_input(arguments)
    if name != "layout":  # its notes were printed when it was made
        for note in notes_on(arguments, layout):
            say(note if name == "text" else f"{getattr(arguments, name)}: {note}")
    return layout


def layout_of_input(arguments: argparse.Namespace) -> Layout:
    """The layout of the arguments, without printing its notes."""
    check_inputs(arguments)
    name = _name_of_input(arguments)
    try:
        layout = _READERS[name](arguments)
        if name != "text":
            layout = _surrounded(arguments, layout, arguments.seed, usual=name in _STREET_AROUND)
    except LidarDraftError as error:
        raise type(error)(f"{error}{_other_option(name, getattr(arguments, name))}") from None
    return layout


def _surrounded(arguments: argparse.Namespace, layout: Layout, seed: int, *, usual: bool) -> Layout:
    """The layout with a street around it if --surroundings asks for one, or by default if that is `usual`."""
    wanted = arguments.surroundings or ("street" if usual else "bare")
    if wanted == "bare":
        return layout
    from lidardraft.simulation.around.surround import surround
    from lidardraft.simulation.on_relief import without_relief

    level = wanted == "level"
    has_relief = layout.roads is not None and layout.roads.relief is not None
    whole = layout if level and has_relief else surround(layout, seed=seed)
    return without_relief(whole) if level else whole


def around_it(layout: Layout) -> str:
    """The surroundings of a layout, as the end of a line; "" without any."""
    said = layout.provenance.get("surroundings", {})
    street = ", around it a street ({district}: {objects} objects; {in_sight:.0%} of the lines of sight are open)"
    return street.format(**said) if "district" in said else ""


def input_of(arguments: argparse.Namespace) -> str:
    """The name of the input in messages: its file, or --text."""
    name = _name_of_input(arguments)
    return "--text" if name == "text" else getattr(arguments, name)


def _other_option(name: str, file: str) -> str:
    """The end of a message on an input: the options that read files of its ending, if this one does not."""
    ending = Path(file).suffix.lower()
    others = [f"--{other}" for other, (_, endings, _) in _INPUTS.items() if ending in endings]
    return f"; {ending} is read by {' or '.join(others)}" if others and f"--{name}" not in ["--text", *others] else ""


def gives_input(arguments: argparse.Namespace) -> bool:
    """Whether the arguments give an input that is a layout."""
    return any(getattr(arguments, name) is not None for name in _READERS)


def _name_of_input(arguments: argparse.Namespace) -> str:
    return next(name for name in _READERS if getattr(arguments, name) is not None)


def sensor_of_file(file: str | Path) -> Sensor | None:
    """The sensor of a scan, if its files tell it: NAME.sensor.json beside NAME.bin and NAME.boxes.json, as `generate`
    writes it, the metadata of an Ouster's capture, or an ending of its data set. Else None."""
    from lidardraft.formats.ouster import metadata_beside, sensor_of_osf
    from lidardraft.formats.rosbag import is_bag, sensor_of_bag

    path = Path(file)
    beside = path.with_name(f"{path.name.removesuffix(path.suffix).removesuffix('.boxes')}.sensor.json")
    if beside.exists():
        return Sensor.load(beside)
    if path.suffix == ".pcap":
        return read_sensor(str(metadata_beside(path)))
    if path.suffix == ".osf" or is_bag(path):
        return sensor_of_osf(path) if path.suffix == ".osf" else sensor_of_bag(path)
    return next((Sensor.preset(name) for ending, name in _SENSORS.items() if path.name.endswith(ending)), None)


def sensor_of_scan(path: str | Path, name: str | None) -> Sensor:
    """The sensor of a scan: that of `name`, or of its file, or the default, which is reported."""
    if name is not None:
        return read_sensor(name)
    if sensor := sensor_of_file(path):
        return sensor
    say(f"{path} is taken for a scan of {DEFAULT_SENSOR}; if it is not, give its --sensor")
    return Sensor.preset(DEFAULT_SENSOR)


def boxes_of_scan(path: str | Path, given: str | None) -> list[Box] | None:
    """The boxes of a given file, or of the .boxes.json beside a scan; None if there is neither."""
    from lidardraft.formats.box_files import read_box_file

    beside = Path(path).with_suffix(".boxes.json")
    file = given or (beside if beside.exists() else None)
    return None if file is None else read_box_file(file)


def scan_files(given: Sequence[str]) -> list[Path]:
    """The scans of files and folders; of a folder without any, those in the folders below it, as in data sets.

    Raises `FormatError` for a folder without scans, and for a missing file or folder.
    """
    from lidardraft.formats.rosbag import is_bag

    files = list[Path]()
    for path in map(Path, given):
        if not path.exists():
            raise FormatError(f"{path}: no such file or folder")
        inside = (sorted(filter(_is_scan, path.glob(pattern))) for pattern in ("*", "**/*"))
        found = next(filter(None, inside), []) if path.is_dir() and not is_bag(path) else [path]
        if not found:
            kinds = f"{', '.join(_SCANS[:-1])} or {_SCANS[-1]}"
            raise FormatError(f"{path}: there is no {kinds} file in this folder or below it")
        files += found
    return files


def _is_scan(file: Path) -> bool:
    """Whether a file of a folder is a scan: no .npz beside a .bin, and only those of PandaSet's tables that are in
    lidar/."""
    is_another = file.with_suffix(".bin").exists() if file.suffix == ".npz" else file.parent.name != "lidar"
    return file.name.endswith(_SCANS) and not (file.suffix in (".npz", ".gz") and is_another)


def _sensor_height(arguments: argparse.Namespace, file: str) -> float:
    """The height over the road of the sensor whose frame the file uses."""
    if arguments.sensor_height is not None:
        return float(arguments.sensor_height)
    return (sensor_of_file(file) or read_sensor(arguments.sensor)).mount_height


def layout_of_text(arguments: argparse.Namespace, sentence: str, seed: int) -> Layout:
    """The layout of a sentence for a seed, with its surroundings; by the language model if one is named."""
    if _asks_language_model(arguments):
        from lidardraft.drafting.language_model.layout import layout_from_llm

        layout = layout_from_llm(
            sentence,
            seed=seed,
            url=arguments.llm_url,
            model=arguments.llm_model,
            blender=bool(arguments.llm_blender),
            cache=arguments.llm_cache,
            timeout=120.0 if arguments.llm_timeout is None else arguments.llm_timeout,
        )
        if arguments.strict and layout.notes:
            raise TextError(f"{'; '.join(layout.notes)}; without --strict these are notes")
    else:
        from lidardraft.drafting.text.layout import explain, layout_from_text

        if arguments.explain:
            for line in str(explain(sentence)).splitlines():
                say(line)
        layout = layout_from_text(sentence, seed=seed, strict=bool(arguments.strict))
    return _surrounded(arguments, layout, seed, usual=not arguments.llm_blender)


def notes_on(arguments: argparse.Namespace, layout: Layout) -> list[str]:
    """The first of the layout's notes, and the number of further ones."""
    is_sentence = any(getattr(arguments, name, None) for name in _TEXTS) and not _asks_language_model(arguments)
    more = "; --llm-url takes free text" * is_sentence
    notes = [note + more if note.startswith("not understood: ") else note for note in layout.notes[:_MOST_NOTES]]
    return notes + [f"and {len(layout.notes) - _MOST_NOTES} more, in its notes"] * (len(layout.notes) > _MOST_NOTES)


def _from_text(arguments: argparse.Namespace) -> Layout:
    return layout_of_text(arguments, arguments.text, arguments.seed)


def _from_points(arguments: argparse.Namespace) -> Layout:
    from lidardraft.drafting.cloud.layout import layout_from_cloud
    from lidardraft.formats.recording import read_returns

    if arguments.labels is not None and arguments.segmenter is not None:
        raise FormatError("--labels and --segmenter both give the classes of --points; use one of them")
    path = arguments.points
    points, fields = read_returns(path, arguments.labels, needs_intensity=False, **reading(arguments))
    height = _sensor_height(arguments, path)
    if arguments.segmenter is not None or "label" not in fields:
        fields = {"label": _predicted(path, arguments.segmenter, points, fields.get("intensity"), height)}
    classes = arguments.segmenter or arguments.labels
    with named(f"{path} with {classes}" if classes else path):  # either of the two files may be wrong
        layout = layout_from_cloud(
            points,
            fields["label"],
            instances=fields.get("instance"),
            sensor_height=height,
            detail=arguments.detail or "fine",
        )
    if len(layout) == 1:
        warnings.warn(
            f"{path}: the layout is a bare plane: the {len(points)} points show no ground and no object", stacklevel=2
        )
    return layout


def ego_of_points(arguments: argparse.Namespace) -> Scenario | None:
    """The trajectory in a bag of --points after its frame; None if there is none."""
    from lidardraft.formats.rosbag import ego_scenario, is_bag

    if arguments.points is None or not is_bag(arguments.points):
        return None
    return ego_scenario(arguments.points, arguments.frame or 0, arguments.topic)


def recorded_points(arguments: argparse.Namespace) -> np.ndarray:
    """The returns of --points relative to the road, float32 [N, 3]."""
    from lidardraft.formats.recording import read_returns

    points, _ = read_returns(arguments.points, None, needs_intensity=False, **reading(arguments))
    return np.asarray(points[:, :3] + (0.0, 0.0, _sensor_height(arguments, arguments.points)), np.float32)


def _predicted(
    path: str, weights: str | None, points: np.ndarray, intensity: np.ndarray | None, height: float
) -> np.ndarray:
    """The classes of --points, predicted by the weights of --segmenter or the packaged ones."""
    if weights is not None:
        from lidardraft.networks.weight_header import read_metadata

        read_metadata(weights)  # a broken file is reported before torch is loaded
    try:
        with extra():
            from lidardraft.perception.segmenter import SURE, Segmenter
    except MissingExtraError as error:
        raise FormatError(f"{path} has no labels: give --labels, or let a segmenter predict them ({error})") from None
    label, probability = Segmenter.from_pretrained(weights or "segmenter").predict(points, intensity, height)
    by, unsure = "the packaged segmenter" if weights is None else weights, probability < SURE
    said = f"{path} has no labels: {by} predicted them, with a mean probability of {probability.mean():.2f}"
    warnings.warn(f"{said}; {unsure.mean():.0%} of the points are less than half sure and have no class", stacklevel=2)
    return np.where(unsure, np.uint8(0), label)


def _from_sketch(arguments: argparse.Namespace) -> Layout:
    from lidardraft.drafting.sketch.layout import layout_from_sketch

    path, scale = arguments.sketch, arguments.metres_per_pixel
    return layout_from_sketch(path, metres_per_pixel=scale, scale_bar=arguments.scale_bar, seed=arguments.seed)


def _from_boxes(arguments: argparse.Namespace) -> Layout:
    from lidardraft.drafting.boxes import layout_from_boxes
    from lidardraft.formats.box_files import read_box_file

    boxes = read_box_file(arguments.boxes, frame=arguments.frame)
    height = _sensor_height(arguments, arguments.boxes)
    with named(arguments.boxes):
        return layout_from_boxes(boxes, sensor_height=height, as_is=bool(arguments.as_is))


def _of_model(arguments: argparse.Namespace) -> dict[str, Any]:
    """The classes, the unit and the place of a model, from the options."""
    classes = assignments(arguments.classes or [], "--class", "NAME=CLASS, as in Cube.001=car")
    scale = 1.0 if arguments.scale is None else arguments.scale
    return {"classes": classes, "scale": scale, "recentre": bool(arguments.recentre), "as_is": bool(arguments.as_is)}


def _from_obj(arguments: argparse.Namespace) -> Layout:
    from lidardraft.drafting.models import layout_from_obj

    return layout_from_obj(arguments.obj, up=arguments.up or "z", **_of_model(arguments))


def _from_glb(arguments: argparse.Namespace) -> Layout:
    from lidardraft.drafting.models import layout_from_glb

    return layout_from_glb(arguments.glb, up=arguments.up or "y", **_of_model(arguments))


def _from_blender(arguments: argparse.Namespace) -> Layout:
    from lidardraft.drafting.blender.layout import layout_from_blender

    return layout_from_blender(Path(arguments.blender), strict=bool(arguments.strict), **_of_model(arguments))


def _from_layout(arguments: argparse.Namespace) -> Layout:
    return Layout.load(arguments.layout)


def _from_image(arguments: argparse.Namespace) -> Layout:
    """The layout of --image; its scale is reported on stderr."""
    from lidardraft.array_files import read_npy
    from lidardraft.drafting.picture.layout import CAMERA_HEIGHT, DEPTH, SEMANTICS, layout_from_image
    from lidardraft.formats.cityscapes import read_semantics
    from lidardraft.formats.masks import read_masks

    if arguments.metric_depth and arguments.camera_height is not None:
        raise FormatError("--metric-depth and --camera-height both set the scale of --image; give one of them")
    height = CAMERA_HEIGHT if arguments.camera_height is None else arguments.camera_height
    depth, semantics = arguments.depth or DEPTH, arguments.semantics or SEMANTICS
    masks = arguments.masks
    with _naming_options(arguments, "depth", "semantics", "masks", "intrinsics"):
        return layout_from_image(
            Path(arguments.image),
            depth=read_npy(depth) if depth.endswith(".npy") else depth,
            semantics=read_semantics(semantics) if semantics.endswith((".npy", ".png")) else semantics,
            masks=read_masks(masks) if masks and masks.lower().endswith((".npy", ".npz", ".png")) else masks,
            intrinsics=_intrinsics(arguments.intrinsics),
            hfov=None if arguments.hfov is None else math.radians(arguments.hfov),
            camera_height=None if arguments.metric_depth else height,
        )


@contextmanager
def _naming_options(arguments: argparse.Namespace, *names: str) -> Iterator[None]:
    """Errors about an argument from an option end with the option and its value, which may be a file."""
    try:
        yield
    except LidarDraftError as error:
        given = {name: getattr(arguments, name) for name in names if re.search(rf"\b{name}\b", str(error))}
        about = [f"--{name} {value}" for name, value in given.items() if value and value not in str(error)]
        raise type(error)(f"{error} ({', '.join(about)})" if about else str(error)) from None


def _intrinsics(given: str | None) -> object | None:
    """fx, fy, cx and cy if the text is numbers with commas between them, else the file of that name."""
    if given is None or "," not in given:
        return given
    try:
        values = [float(part) for part in given.split(",")]
    except ValueError:
        values = []
    if len(values) != 4:
        raise FormatError(f"--intrinsics is {given!r}; it must be FX,FY,CX,CY in pixels, or a file")
    return values


def _asks_language_model(arguments: argparse.Namespace) -> bool:
    """Whether the arguments or the environment name a language model."""
    url = os.environ.get(_URL) if arguments.llm_url is None else arguments.llm_url
    return bool(url or arguments.llm_model or arguments.llm_blender)


# By the name of the option of the input.
_READERS = {
    "text": _from_text,
    "image": _from_image,
    "points": _from_points,
    "sketch": _from_sketch,
    "boxes": _from_boxes,
    "obj": _from_obj,
    "glb": _from_glb,
    "blender": _from_blender,
    "layout": _from_layout,
}
