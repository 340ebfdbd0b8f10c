"""The pictures of docs, and others to look at: `python benches/pictures.py NAME [-o PICTURE]`.

    inputs        each input with the layout that it becomes; -o is the folder, docs/images
    formats       a scan in each format, drawn as the readers of `foreign_readers.py` find it
    clouds        a recorded sweep of PandaSet (Xiao et al., ITSC 2021; CC BY 4.0) beside its layouts
    simulated     ten sentences in streets; clusterings of five recorded sweeps, and three coarse layouts of streets;
                  then two of these sweeps as recorded, and the streets themselves; brightness is intensity
    surroundings  ordinary sentences, -n of 25, without and with the street around them
    panoramas     recorded sweeps of PandaSet and Ouster above three simulated ones each: range, and intensity below it
    generated     what --weights make of unseen streets, between the layout's cast and the detailed scan
    studio        a studio in a real Chromium, step by step; -o is the folder, docs/images

Colours are classes. Recordings are those of PandaSet and ika in the folder --data (by default LIDARDRAFT_DATA).
`pytest tests/benches` tells when those of inputs are out of date.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import os
import tempfile
import textwrap
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

import lidardraft
import recordings
from chromium import chromium, handle_of, pixel_of, until
from foreign_readers import READERS, Found
from lidardraft import Box, Layout, Pipeline, Sensor, layout_from_cloud, layout_from_text, simulate, surround, view
from lidardraft.cli.arguments import whole_number
from lidardraft.cli.studio import inputs_of
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.drawing import Drawing, Eye
from lidardraft.evaluation import unseen_streets
from lidardraft.formats.frame import writer_of
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets import StreetConfig, streets
from lidardraft.view import caption, render_from_above, render_layout, render_points, render_scan, save_png, stack
from rendered_pictures import render
from report_detail import SENTENCES

ROOT = Path(__file__).parents[1]
DOCS, IMAGES, SKETCHES = ROOT / "docs", ROOT / "docs" / "images", ROOT / "examples" / "sketches"
SENTENCE = "a busy crossroads, a bus turning left, people on the right pavement, trees and houses on both sides"
ORDINARY = (
    "two pedestrians at a crosswalk",
    "a bus 15 m ahead, three parked cars on the right",
    "a motorway with two trucks ahead",
    "a narrow alley between tall buildings, two people ahead",
    "a busy downtown intersection",
    "a quiet residential street with parked cars on both sides",
    "a crossroads with traffic lights, a bus waits",
    "a child runs onto the street between two parked cars",
    "a roundabout with three cars",
    "a country road with a tractor ahead",
    "a van overtakes a cyclist",
    "people waiting at a bus stop on the right",
    "a village street, an old man crosses the road",
    "a car comes towards us around a bend",
    "roadworks with cones on the right lane",
    "a tram ahead and cars on both sides",
    "a parking lot with many cars and a woman with a pram",
    "a school in the morning with many children",
    "a forest road, a deer 30 m ahead",
    "a fire truck at a T-junction",
    "a delivery van double parked, cars behind us",
    "an empty street at night",
    "an industrial area with a truck turning left",
    "a shopping street with a market stall and cyclists",
    "four cars in a queue at a red light",
)
STREETS = (2, 7, 11)  # pairs of seed 0
PANORAMAS = ("a street in a town", "a residential street with parked cars on both sides", "a busy downtown street")
FIELDS = ("points", "intensity")
PANORAMA = (720, 96)  # pixels
VIEW, SPLIT_SIZE = (980, 560), (700, 400)  # pixels of the view of a scan's picture, and of it with surroundings
COLUMNS, GAP, TITLE_HEIGHT = 6, 4, 15
ABOVE = Eye.above(width=360, height=360, reach=32.0)
ORANGE, RED = (255, 190, 70), (255, 80, 80)
LARGEST = 150_000  # bytes of a picture of the studio


def inputs() -> Iterator[tuple[str, np.ndarray]]:
    """Name and pixels u8 [H, W, 3] of each picture."""
    layout = lidardraft.layout_from_text(SENTENCE, seed=1)
    yield "sentences", _shown(layout)
    yield "boxes", _shown(lidardraft.layout_from_boxes(layout.boxes()))
    yield "language-models", _shown(layout_from_spec(_reply_of_the_page()))
    yield "images", _photograph()
    with Image.open(SKETCHES / "crossroads.png") as image:
        sheet = np.asarray(image.convert("RGB").resize((480, 480), Image.Resampling.BOX))
    painted = lidardraft.layout_from_sketch(SKETCHES / "crossroads.png", scale_bar=10.0)
    named = lidardraft.layout_from_sketch(SKETCHES / "bend.svg")
    rows = [[caption(sheet, "crossroads.png"), _shown(painted)], [_shown(named, "bend.svg as a layout"), _cast(named)]]
    yield "sketches", stack([stack(row, across=True) for row in rows])


def _reply_of_the_page() -> SceneSpec:
    """What a language model wrote, as the page shows it."""
    return SceneSpec.from_dict(
        json.loads((DOCS / "how-to/language-models.md").read_text(encoding="utf-8").split("```json")[1].split("```")[0])
    )


def _photograph() -> np.ndarray:
    """A rendered picture, and what its layout shows."""
    sentence = "a street with three parked cars on the left, two cars ahead, a person on the right, trees and houses"
    picture = render(lidardraft.layout_from_text(sentence, seed=3), Pinhole.from_hfov(math.radians(80), 720, 480))
    known = {"depth": picture.depth, "semantics": picture.labels, "hfov": math.radians(80)}
    layout = lidardraft.layout_from_image(picture.pixels, **known)
    return stack([caption(picture.pixels, "picture"), _shown(layout)], across=True)


def _shown(layout: Layout, name: str = "layout") -> np.ndarray:
    return stack([caption(render_from_above(layout), name), render_layout(layout)], across=True)


def _cast(layout: Layout) -> np.ndarray:
    """What a sensor sees of it, bare: the sensor model, which may change, has no part in these pictures."""
    sensor = lidardraft.Sensor.preset("hdl64e")
    cast = render_scan(lidardraft.raycast(layout, sensor), sensor.pose(), by_label=True)
    return caption(cast[:, :480], "its cast, by class")


def found_in(name: str, found: Found, mount: float) -> np.ndarray:
    """What a reader found, from above: uint8 [360, 360, 3]."""
    drawing, points = Drawing(ABOVE, rings=(10, 20, 30)), found.points[:, :3] + (0.0, 0.0, mount)
    colours = view.colour_by_height(points[:, 2])
    said = f"{name}: {len(points):,} points"
    if found.boxes is None:
        colours[found.fields["instance"] > 0] = RED
    drawing.points(points, colours)
    if found.boxes is not None:
        boxes = [Box(each.name, "car", 1, tuple(each.center), tuple(each.size), each.yaw) for each in found.boxes]
        boxes = [box.raised(mount) for box in boxes]
        drawing.boxes(boxes, [ORANGE] * len(boxes))
        said += f", {len(boxes)} boxes"
    drawing.ego()
    return caption(drawing.picture(), said, size=13)


def formats() -> np.ndarray:
    """What each reader found; formats without boxes show objects by what they say of each point."""
    sensor, sentence = Sensor.preset("hdl32e"), "a busy crossroads with a bus, cyclists and pedestrians"
    frame = simulate(surround(layout_from_text(sentence, seed=3), seed=3), sensor, seed=3).frame()
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for name, read in READERS.items():
            writer_of(name)(Path(folder, name), [[frame]])
            pictures.append(found_in(name, next(iter(read(Path(folder, name)))), sensor.mount_height))
    return view.sheet(pictures, columns=5)


def clouds(folder: Path) -> np.ndarray:
    """A sweep, and its layouts."""
    sensor = PRESETS["pandar64"]
    sweep = recordings.pandar64(folder, 1800).labelled["PandaSet 002"][0]
    assert sweep.label is not None
    seen = sweep.valid & (sweep.label > 0)
    points, labels = sweep.points[seen], sweep.label[seen]
    picture = render_points(points + np.array([0.0, 0.0, sensor.mount_height]), view.colour_by_label(labels))
    pictures = [caption(picture, "PandaSet: returns by class")]
    for detail in ("fine", "objects"):
        layout = layout_from_cloud(points, labels, sensor_height=sensor.mount_height, detail=detail)
        pictures.append(caption(render_layout(layout), f'detail="{detail}": {len(layout)} shapes'))
    return stack(pictures)


def cell(points: np.ndarray, label: np.ndarray, intensity: np.ndarray, title: str) -> np.ndarray:
    """Points [N, 3] of the layout's frame in the colours of their classes, uint8 [240, 360, 3]."""
    bright = 0.4 + 0.6 * np.sqrt(intensity / max(float(np.percentile(intensity, 95)), 0.05)).clip(0.0, 1.0)
    colours = (view.colour_by_label(label) * bright[:, None]).astype(np.uint8)
    large = render_points(points, colours)
    height, width, _ = large.shape
    picture = Image.fromarray(large.reshape(height // 2, 2, width // 2, 2, 3).max(axis=(1, 3)))
    pen = ImageDraw.Draw(picture)
    pen.rectangle((0, 0, picture.width, TITLE_HEIGHT), fill=(0, 0, 0))
    pen.text((5, 2), title, fill=(210, 210, 210))
    return np.asarray(picture)


def simulated_cell(layout: Layout, sensor: Sensor, seed: int, title: str) -> np.ndarray:
    """The cell of a layout."""
    scan = simulate(layout, sensor, seed=seed)
    points = scan.points() @ scan.pose[:3, :3].T + scan.pose[:3, 3]
    return cell(points, scan.labels(), scan.intensities(), title)


def recorded_cell(sweep: Sweep, sensor: Sensor, title: str) -> np.ndarray:
    """The cell of a sweep."""
    assert sweep.label is not None
    assert sweep.intensity is not None
    points = sweep.points[sweep.valid] + [0.0, 0.0, sensor.mount_height]
    return cell(points, sweep.label[sweep.valid], sweep.intensity[sweep.valid], title)


def sweeps_of(folder: Path) -> Iterator[tuple[Sweep, Sensor, str]]:
    """Five sweeps: three of PandaSet, two of ika."""
    pandaset = recordings.pandar64(folder, 1800).labelled
    for place, number in (("PandaSet 001", 0), ("PandaSet 002", 0), ("PandaSet 002", 5)):
        yield pandaset[place][number], PRESETS["pandar64"], f"{place}, {number}"
    ika = recordings.vlp32c(folder, 1800).labelled
    for half, number in (("first half", 2), ("second half", 8)):
        yield ika[half][number], PRESETS["vlp32c"], f"ika, {half}, {number}"


def cells(folder: Path | None) -> Iterator[np.ndarray]:
    """All of them, in order."""
    for seed, sentence in enumerate(SENTENCES):
        layout = surround(layout_from_text(sentence, seed=seed), seed=seed)
        yield simulated_cell(layout, PRESETS["hdl64e"], seed, textwrap.shorten(sentence, 60))
    sweeps = list(sweeps_of(folder)) if folder is not None else []
    for sweep, sensor, name in sweeps:
        assert sweep.label is not None
        seen = sweep.valid & (sweep.label > 0)
        layout = layout_from_cloud(sweep.points[seen], sweep.label[seen], sensor_height=sensor.mount_height)
        yield simulated_cell(layout, sensor, 0, f"clustering of {name}")
    pairs = [
        next(islice(streets(seed=0, config=StreetConfig(poses_per_street=1), start=number), 1)) for number in STREETS
    ]
    for pair in pairs:
        yield simulated_cell(pair.layout, PRESETS["hdl64e"], 0, f"layout of a street, {pair.style.source}")
    for sweep, sensor, name in sweeps[1:4:2]:
        yield recorded_cell(sweep, sensor, f"recorded: {name}")
    for pair in pairs:
        scan = pair.scan
        assert scan.intensity is not None
        points = scan.points(pair.poses())
        yield cell(points, scan.label[scan.valid], scan.intensity[scan.valid], f"street itself, {pair.district}")


def sheet(pictures: list[np.ndarray]) -> np.ndarray:
    """The cells in rows."""
    height, width, _ = pictures[0].shape
    rows = -(-len(pictures) // COLUMNS)
    whole = np.zeros((rows * (height + GAP) - GAP, COLUMNS * (width + GAP) - GAP, 3), dtype=np.uint8)
    for number, picture in enumerate(pictures):
        top, left = number // COLUMNS * (height + GAP), number % COLUMNS * (width + GAP)
        whole[top : top + height, left : left + width] = picture
    return whole


def pairs_of_sentences(count: int) -> Iterator[np.ndarray]:
    """Scans of sentences as `Scan.picture` has them, without the street around them and with it."""
    for seed, sentence in enumerate(ORDINARY[:count]):
        bare = layout_from_text(sentence, seed=seed)
        for layout in (bare, surround(bare, seed=seed)):
            scan = simulate(layout, PRESETS["os1-128"], seed=seed)
            points, boxes = view.points_on_road(scan.image), layout.boxes()
            whole = Image.fromarray(view.render_returns(scan.image, points, boxes=boxes, title=sentence))
            yield np.asarray(whole.crop((0, 0, *VIEW)).resize(SPLIT_SIZE, Image.Resampling.LANCZOS))


def panoramas(folder: Path) -> np.ndarray:
    """A column a sensor: its recorded sweep, then three simulated ones."""
    pandaset = recordings.pandar64(folder, PRESETS["pandar64"].columns).labelled["PandaSet 002"][4]
    ouster = recordings.os1_32(folder, PRESETS["os1-32"].columns).plain
    halves = [sweep for half in ("left", "right") for sweep in ouster[half]]
    points, intensity = (np.concatenate([getattr(half, name) for half in halves], axis=1) for name in FIELDS)
    seen = points.any(axis=2)
    height, width = seen.shape
    whole = Sweep.from_points(
        points[seen], np.nonzero(seen)[0], height=height, columns=width, intensity=intensity[seen]
    )
    columns = []
    for name, title, recorded in (("pandar64", "PandaSet", pandaset), ("os1-32", "Ouster OS1-32", whole)):
        assert recorded.intensity is not None
        bright = float(np.percentile(recorded.intensity[recorded.valid], 95))
        made = [simulate(text, PRESETS[name], seed=seed).image for seed, text in enumerate(PANORAMAS)]
        sweeps = {f"{title}, recorded": recorded}
        sweeps |= {f"{name}: {text}": Sweep.by_azimuth(scan) for text, scan in zip(PANORAMAS, made, strict=True)}
        columns.append(stack([panorama(sweep, bright, said) for said, sweep in sweeps.items()]))
    return stack(columns, across=True)


def panorama(sweep: Sweep, bright: float, title: str) -> np.ndarray:
    """Range above intensity, black without a return; `bright` is the intensity that is white."""
    assert sweep.intensity is not None
    share = np.sqrt(np.clip(sweep.intensity / bright, 0.0, 1.0)) * (255 - 40) + 40
    grey = np.where(sweep.valid, share, 0).astype(np.uint8)
    pictures = [view.colour_by_depth(sweep.depth), np.repeat(grey[..., None], 3, axis=2)]
    sized = [np.asarray(Image.fromarray(one).resize(PANORAMA, Image.Resampling.NEAREST)) for one in pictures]
    return stack([caption(sized[0], title, size=11), sized[1]])


def generated(pipelines: dict[str, Pipeline], numbers: list[int]) -> Iterator[list[np.ndarray]]:
    """A row of pictures each street."""
    found = unseen_streets(max(numbers), sensor=Sensor.preset("hdl64e"))
    for pair in (found[number - 1] for number in numbers):
        scans = {"layout": pair.condition_image}
        for name, pipeline in pipelines.items():
            scans[name] = pipeline.generate(pair.condition_image, seed=pair.index)
        scans["detailed scan"] = pair.scan
        yield [caption(render_scan(scan, pair.pose, by_label=True), name) for name, scan in scans.items()]


def save_jpeg(pictures: list[Image.Image], path: Path) -> None:
    """Write pictures beside each other, as small as it has to be."""
    height = min(picture.height for picture in pictures)
    whole = Image.new("RGB", (sum(picture.width for picture in pictures) + 6 * (len(pictures) - 1), height), "white")
    left = 0
    for picture in pictures:
        whole.paste(picture, (left, 0))
        left += picture.width + 6
    for quality in range(86, 30, -6):
        content = io.BytesIO()
        whole.save(content, "JPEG", quality=quality, optimize=True)
        if content.tell() <= LARGEST:
            break
    path.write_bytes(content.getvalue())
    print(path, content.tell())


def shot(page: Any, session: Any, clip: dict[str, int] | None = None) -> Image.Image:
    """What is on the screen when all is settled."""
    session.join()
    page.wait_for_timeout(2500)
    return Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")


def press(page: Any, name: str) -> None:
    """A button of that name."""
    page.get_by_role("button", name=name, exact=True).first.click()


def choose(page: Any, label: str, option: str) -> None:
    """An option of a dropdown."""
    box = page.get_by_label(label, exact=True).first
    box.click()
    box.fill(option)
    page.get_by_role("option", name=option, exact=True).first.click()
    page.wait_for_timeout(800)


def steps(page: Any, session: Any, folder: Path) -> None:
    """Step by step."""
    if page.locator(".mantine-Notification-closeButton").count():  # a note on WebGL in software
        page.locator(".mantine-Notification-closeButton").first.click()
    session.post(lambda one: one.select("car_8"))
    save_jpeg([shot(page, session)], folder / "studio.jpg")
    view = {"x": 120, "y": 140, "width": 640, "height": 430}
    session.post(lambda one: one.page._see_from(one, "Object"))
    before = shot(page, session, view)
    x, y = handle_of(session)
    page.mouse.move(x, y)
    page.wait_for_timeout(400)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x + 14 * k, y - 5 * k)
    page.mouse.up()
    until(lambda: len(session.editor.document.states) > 1)
    save_jpeg([before, shot(page, session, view)], folder / "studio-drag.jpg")
    page.get_by_role("tab", name="Look").click()
    session.post(lambda one: one.page._see_from(one, "Behind"))
    choose(page, "Colours", "range")
    page.get_by_label("Labels", exact=True).first.click()
    session.join()
    page.wait_for_timeout(1500)
    frame = session.frame()
    label = frame.scans[0].layout.boxes()
    bus = next(box for box in label if box.label == "bus")
    near = frame.points[np.argmin(np.linalg.norm(frame.points - np.array(bus.center), axis=1))]
    page.mouse.click(*pixel_of(session.page.client.camera, near))
    save_jpeg([shot(page, session)], folder / "studio-look.jpg")
    choose(page, "Colours", "objects and height")
    page.get_by_label("Labels", exact=True).first.click()
    page.get_by_role("tab", name="Sensor").click()
    choose(page, "Beside it", "os1-32")
    save_jpeg([shot(page, session)], folder / "studio-sensor.jpg")
    choose(page, "Beside it", "none")
    page.get_by_role("tab", name="Play").click()
    press(page, "Seat")
    press(page, "Run")
    until(lambda: session.editor.world.time > 1.0, 60.0)
    press(page, "Pause")
    save_jpeg([shot(page, session)], folder / "studio-play.jpg")
    page.get_by_role("tab", name="Keep").click()
    session.post(lambda one: one.page._see_from(one, "Behind"))
    press(page, "Command")
    save_jpeg([shot(page, session)], folder / "studio-keep.jpg")


def studio(folder: Path) -> None:
    """Write all pictures of a studio."""
    from lidardraft.studio.editor import Editor
    from lidardraft.studio.page import SENTENCE
    from lidardraft.studio.server import served

    layout = surround(layout_from_text(SENTENCE, seed=7), seed=7)
    with (
        served(lambda: Editor(layout, (Sensor.preset("hdl64e"),), seed=7), inputs_of("hdl64e", None), 8700) as server,
        chromium() as browser,
    ):
        page = browser.new_page(viewport={"width": 1280, "height": 760})
        page.goto(server.url)
        page.wait_for_selector("text=returns", timeout=60_000)
        (session,) = server.sessions.values()
        steps(page, session, folder)


def save_palette(picture: np.ndarray, path: Path, colours: int = 256, **options: Any) -> None:
    """Write a picture in as many colours."""
    Image.fromarray(picture).quantize(colours, **options).save(path, optimize=True)


def main() -> None:
    """Write one picture, or those of a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = ("inputs", "formats", "clouds", "simulated", "surroundings", "panoramas", "generated", "studio")
    parser.add_argument("name", choices=names, metavar="NAME")
    parser.add_argument("-o", "--output", type=Path, help="a .png file (default docs/images/NAME.png)")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    parser.add_argument("-n", "--num", type=whole_number(1), default=5, help="sentences of surroundings (default 5)")
    parser.add_argument("--weights", nargs="+", default=["paper"], help="packaged ones by name, or .safetensors files")
    parser.add_argument("--steps", type=whole_number(1), metavar="N", help="steps of denoising (default: as stored)")
    text = "which streets, counted from 1 (default 1 2 3 4)"
    parser.add_argument("--rows", type=whole_number(1), nargs="+", default=[1, 2, 3, 4], metavar="K", help=text)
    given = parser.parse_args()
    folder = None if given.data is None else Path(given.data)
    output = given.output or (IMAGES if given.name in ("inputs", "studio") else IMAGES / f"{given.name}.png")
    if given.name == "inputs":
        for name, picture in inputs():
            save_png(output / f"{name}.png", picture)
    elif given.name == "formats":
        output.parent.mkdir(parents=True, exist_ok=True)
        save_png(output, formats())
    elif given.name == "clouds":
        if folder is None:
            parser.error("give the folder of the recordings as --data or LIDARDRAFT_DATA")
        save_png(output, clouds(folder))
    elif given.name == "simulated":
        save_palette(sheet(list(cells(folder))), output, 160, dither=Image.Dither.NONE)
    elif given.name == "surroundings":
        save_palette(view.sheet(list(pairs_of_sentences(given.num))), output)
    elif given.name == "panoramas":
        if folder is None:
            parser.error("give the folder of the recordings as --data or LIDARDRAFT_DATA")
        Image.fromarray(panoramas(folder)).save(output.with_suffix(".jpg"), quality=78, optimize=True)
    elif given.name == "generated":
        pipelines = {Path(name).stem: Pipeline.from_pretrained(name, steps=given.steps) for name in given.weights}
        save_png(output, stack([stack(row, across=True) for row in generated(pipelines, given.rows)]))
    else:
        studio(output)


if __name__ == "__main__":
    main()
