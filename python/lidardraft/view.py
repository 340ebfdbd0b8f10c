"""Pictures, uint8 [H, W, 3], of layouts and range images; all points are in the layout's frame."""

from __future__ import annotations

import base64
import itertools
import json
import math
import os
import struct
import textwrap
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from lidardraft.drawing import Colour, Drawing, Eye, corners_of, font
from lidardraft.errors import LayoutError, extra
from lidardraft.files import written_whole
from lidardraft.scene.box import Box
from lidardraft.scene.layout import AROUND, Layout
from lidardraft.scene.pose import upright
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Hits, Raycaster, raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, CLASSES

# Those of Cityscapes, with brighter colours for moving objects: the palette is for a white background.
PALETTE = np.array([row.colour for row in CLASSES], dtype=np.uint8)
for _name, _colour in {
    "building": (150, 152, 164), "person": (255, 82, 110), "rider": (255, 120, 60), "car": (70, 170, 255),
    "truck": (160, 130, 255), "bus": (0, 224, 224), "train": (0, 170, 190), "motorcycle": (255, 100, 220),
    "bicycle": (255, 160, 120), "trunk": (170, 125, 90),
}.items():  # fmt: skip
    PALETTE[BY_NAME[_name].id] = _colour
_IS_THING = np.array([row.is_thing for row in CLASSES])
_WHITE: Colour = (255, 255, 255)
_BACKGROUND = np.array([24, 26, 32], dtype=np.uint8)
_RANGES = (2.0, 80.0)  # m, of the ramp of ranges
_RAMP = np.array(
    [[48, 18, 59], [70, 107, 227], [40, 188, 235], [50, 242, 152], [164, 252, 60], [249, 186, 56], [228, 69, 10]]
)
_LEVELS = (0.0, 0.5, 1.0, 2.0, 3.5, 6.0, 12.0)  # m over the road, and their colours
_LEVEL_COLOURS: list[Colour] = [
    (98, 110, 158), (50, 150, 170), (52, 196, 160), (130, 220, 110), (235, 222, 92), (252, 160, 70), (240, 92, 96)
]  # fmt: skip
_DIM, _LIT = 0.6, 0.6  # the brightness of a return without intensity, and the excess of the strongest
_GAP = 6
_VIEW_HEIGHT, _WIDE, _NARROW = 560, 7 / 4, 3 / 4  # rows of a view; columns of the two views over rows
_LARGE = (1800, 900)  # columns and rows of a large picture
_STRIP = 1 / 8  # rows of a range image over those of the view
_REACH = 50.0  # m, ahead and behind in a view from above
_SHOWN, _SHOWN_WITHIN, _SEEN = 10, 30.0, 5  # boxes in a view: their number, range [m], and least returns
_LONGEST_TITLE = 120
_FURTHEST = 1000.0  # m of a page; further points are not returns
_SENT: dict[str, tuple[str, float]] = {  # the integers and the unit of each field in a page
    "label": ("<i2", 1.0), "instance": ("<u4", 1.0), "intensity": ("<i2", 1 / 255), "row": ("<i4", 1.0),
    "column": ("<i4", 1.0), "range": ("<i4", 0.01), "time": ("<i4", 1e-6),
}  # fmt: skip
_FILM_COLOURS = 64  # of all frames of a GIF
_FILM_LOSS = "26"  # of H.264, 0 to 51; points stay distinct
_EYE = np.array(  # 16 m behind and 11 m over the ego vehicle, facing 24 degrees down
    [[0.9135, 0, 0.4067, -16.0], [0, 1, 0, 0], [-0.4067, 0, 0.9135, 11.0], [0, 0, 0, 1]]
)
_ABOVE_SMALL = Eye.above(width=360, height=360, reach=36.0)
_SEAT = Eye(upright((-0.2, 0.35, 1.25), 0.0), 420.0, 634, 360)
BEHIND, _BEHIND_SMALL = Eye(_EYE, 576.0, 720, 480), Eye(_EYE, 384.0, 480, 320)


def colour_by_label(label: np.ndarray) -> np.ndarray:
    """Class colours uint8 [..., 3]; returns without a class are white."""
    return np.where((label == 0)[..., None], np.uint8(255), PALETTE[label])


def colour_by_depth(depth: np.ndarray) -> np.ndarray:
    """A ramp over the logarithm of the range from 2 to 80 m, uint8 [..., 3]; black without a return."""
    share = np.log(np.maximum(depth, _RANGES[0]) / _RANGES[0]) * (254 / math.log(_RANGES[1] / _RANGES[0]))
    return _DEPTH_RAMP[np.where(depth > 0, np.minimum(share, 254).astype(np.uint8) + 1, 0)]


def colour_by_height(z: np.ndarray) -> np.ndarray:
    """A ramp over the height over the road from 0 to 12 m, uint8 [..., 3]."""
    return _HEIGHT_RAMP[np.clip(z * (255 / _LEVELS[-1]), 0, 255).astype(np.uint8)]


def colour_by_share(share: np.ndarray) -> np.ndarray:
    """The ramp of ranges over shares of 0 to 1, uint8 [..., 3]."""
    return _DEPTH_RAMP[1 + (np.clip(share, 0.0, 1.0) * 254).astype(np.uint8)]


def _ramp(places: Sequence[float] | np.ndarray, colours: np.ndarray, count: int) -> np.ndarray:
    """`count` colours, uint8 [count, 3], of evenly spaced values from 0 to the last of the places."""
    values = np.linspace(0.0, places[-1], count)
    return np.stack([np.interp(values, places, colours[:, c]) for c in range(3)], axis=-1).astype(np.uint8)


_DEPTH_RAMP = np.concatenate([np.zeros((1, 3), np.uint8), _ramp(np.arange(len(_RAMP)), _RAMP, 255)])
_HEIGHT_RAMP = _ramp(_LEVELS, np.array(_LEVEL_COLOURS), 256)


def colour_returns(image: RangeImage, z: np.ndarray, *, by_label: bool = False) -> np.ndarray:
    """The colours uint8 [N, 3] of a scan's returns at heights `z` [N]: things by class and the rest by height, or all
    by class. Stronger returns are brighter."""
    label = image.label[image.valid]
    colours = colour_by_height(z).astype(np.float32)
    by_class = (label > 0) if by_label else _IS_THING[label]
    colours[by_class] = PALETTE[label[by_class]]
    if image.intensity is None:
        return colours.astype(np.uint8)
    intensity = image.intensity[image.valid]
    most = max(float(np.percentile(intensity, 97)), 0.05) if len(intensity) else 1.0
    bright = _DIM + _LIT * np.minimum(intensity / most, 1)
    return np.minimum(colours * bright[:, None], 255).astype(np.uint8)


def render_layout(layout: Layout, eye: Eye = BEHIND) -> np.ndarray:
    """The shapes of a layout, shaded: uint8 [H, W, 3]."""
    hits = _looked_at(layout, eye)
    facing = np.abs(np.einsum("ij,ij->i", hits.normal, hits.directions))
    return _shaded(hits, 0.35 + 0.65 * facing, Drawing(eye).picture())


def render_points(points: np.ndarray, colours: np.ndarray, eye: Eye = BEHIND) -> np.ndarray:
    """Points [N, 3] in their colours uint8 [N, 3]: uint8 [H, W, 3]."""
    drawing = Drawing(eye)
    drawing.points(points, colours)
    return drawing.picture()


def title_of(layout: Layout) -> str:
    """The sentence of a layout, or the district of its street; "" if it has neither."""
    return layout.intent.sentence or layout.intent.district or ""


def points_on_road(image: RangeImage) -> np.ndarray:
    """The returns [N, 3] of a scan taken from its sensor's mount, relative to the road."""
    return image.points() + np.array([0.0, 0.0, image.sensor.mount_height])


def render_scan(image: RangeImage, pose: np.ndarray, *, by_label: bool = False, eye: Eye = BEHIND) -> np.ndarray:
    """The returns of a scan taken from world_from_sensor `pose`: uint8 [H, W, 3]."""
    points = image.points() @ pose[:3, :3].T + pose[:3, 3]
    return render_points(points, colour_returns(image, points[:, 2], by_label=by_label), eye)


def render_from_above(layout: Layout, *, size: int = 480, reach: float = _REACH) -> np.ndarray:
    """The classes of a layout's shapes from above, lighter with height: uint8 [size, size, 3].

    Forward is up, the edge is `reach` [m] away, and a cross marks the ego vehicle.
    """
    eye = Eye.above(width=size, height=size, reach=reach)
    hits = _looked_at(layout, eye)
    height = np.clip(eye.pose[2, 3] - hits.distance, 0.0, 12.0)
    background = np.broadcast_to(_BACKGROUND, (size, size, 3))
    picture = _shaded(hits, 0.75 + 0.25 * height / 12.0, background)
    middle = size // 2
    picture[middle - 1 : middle + 1, middle - 5 : middle + 6] = 255
    picture[middle - 8 : middle + 6, middle - 1 : middle + 1] = 255
    return picture


def _looked_at(layout: Layout, eye: Eye) -> Hits:
    return Raycaster(layout).cast(*eye.rays(), max_range=2000.0)


def _shaded(hits: Hits, shade: np.ndarray, background: np.ndarray) -> np.ndarray:
    colours = (PALETTE[hits.label] * shade[:, None]).astype(np.uint8).reshape(background.shape)
    return np.where(hits.valid.reshape(*background.shape[:2], 1), colours, background)


def render_returns(
    image: RangeImage,
    points: np.ndarray,
    *,
    boxes: Sequence[Box] = (),
    title: str = "",
    by_label: bool = False,
) -> np.ndarray:
    """The returns `points` [N, 3] of a scan: in a view of its boxes, from above, and as range images.

    uint8 [788, 1400, 3]. The legend explains the colours (`colour_returns`); rings are 10 m apart.
    """
    boxes, points = _with_returns(boxes, image), points.astype(np.float32)  # half the memory
    colours = colour_returns(image, points[:, 2], by_label=by_label)
    view, above = (_drawn(eye, points, colours, boxes) for eye in _eyes(boxes))
    _describe(view, image, boxes, title, by_label)
    return _over_strips(stack([view.picture(), above.picture()], across=True), image)


def render_frame(image: RangeImage, points: np.ndarray, *, boxes: Sequence[Box] = (), title: str = "") -> np.ndarray:
    """A frame of a film: the returns `points` [N, 3] and their boxes from above, beside the view from the driver's
    seat. uint8 [360, 1000, 3]."""
    boxes = _with_returns(boxes, image)
    colours = colour_returns(image, points[:, 2])
    above, seat = _drawn(_ABOVE_SMALL, points, colours, boxes), Drawing(_SEAT, rings=())
    seat.points(points, colours)
    seat.boxes(boxes, [_colour_of(BY_NAME[box.label].id) for box in boxes])
    seat.text((8.0, 6.0), textwrap.shorten(title, _LONGEST_TITLE * 2 // 3, placeholder=" ..."), 14)
    return stack([above.picture(), seat.picture()], across=True)


def render_large(
    image: RangeImage, points: np.ndarray, *, boxes: Sequence[Box] = (), title: str = "", by_label: bool = False
) -> np.ndarray:
    """As `render_returns`, but only the view of the boxes, large and smooth: uint8 [900, 1800, 3]."""
    width, height = _LARGE
    boxes = _with_returns(boxes, image)
    eye = Eye.showing(_shown(boxes), width=2 * width, height=2 * height)
    view = _drawn(eye, points, colour_returns(image, points[:, 2], by_label=by_label), boxes)
    _describe(view, image, boxes, title, by_label)
    smooth = Image.fromarray(np.ascontiguousarray(view.picture())).resize(_LARGE, Image.Resampling.BOX)
    return np.asarray(smooth) & 0xFC  # the last two bits are invisible, but make a file half as large again


def _drawn(eye: Eye, points: np.ndarray, colours: np.ndarray, boxes: Sequence[Box]) -> Drawing:
    drawing = Drawing(eye)
    drawing.points(points, colours)
    drawing.boxes(boxes, [_colour_of(BY_NAME[box.label].id) for box in boxes])
    drawing.ego()
    return drawing


def _with_returns(boxes: Sequence[Box], image: RangeImage) -> list[Box]:
    """The boxes of objects with more than a stray return."""
    if not boxes:
        return []
    if not image.instance.any():  # the returns of a recording have no instances
        return list(boxes)
    instances, counts = np.unique(image.instance[image.valid], return_counts=True)
    seen = set(instances[counts >= _SEEN].tolist())
    return [box for box in boxes if box.instance in seen]


def _eyes(boxes: Sequence[Box]) -> tuple[Eye, Eye]:
    """A view of the boxes, and one from above."""
    wide, narrow = round(_VIEW_HEIGHT * _WIDE), round(_VIEW_HEIGHT * _NARROW) - _GAP
    return (
        Eye.showing(_shown(boxes), width=wide, height=_VIEW_HEIGHT),
        Eye.above(width=narrow, height=_VIEW_HEIGHT, reach=_REACH),
    )


def _shown(boxes: Sequence[Box]) -> np.ndarray:
    """The corners [N, 3] of the boxes to be shown: the nearest ones, without surroundings."""
    asked = [box for box in boxes if not box.id.startswith(AROUND)]
    near = sorted(asked, key=lambda box: math.hypot(*box.center[:2]))[:_SHOWN]
    near = [box for number, box in enumerate(near) if not number or math.hypot(*box.center[:2]) < _SHOWN_WITHIN]
    return corners_of(near).reshape(-1, 3)


def _describe(drawing: Drawing, image: RangeImage, boxes: Sequence[Box], title: str, by_label: bool) -> None:
    """Write the title, the meaning of the colours, and the number of boxes of each class."""
    eye, line = drawing.eye, drawing.line
    small, edge, step = 13 * line, 12 * line, 19 * line
    row = float(edge)
    if title:
        drawing.title((edge, row), textwrap.shorten(title, _LONGEST_TITLE, placeholder=" ..."), 18 * line)
        row += 26 * line
    beams, columns = image.sensor.shape
    drawing.title((edge, row), f"{image.sensor.name}, {beams} x {columns}, {int(image.valid.sum()):,} returns", small)
    labels = np.bincount(image.label[image.valid], minlength=len(CLASSES))
    numbers = [k for k in np.argsort(-labels).tolist() if k and labels[k] and (by_label or _IS_THING[k])]
    counts = Counter(BY_NAME[box.label].id for box in boxes)
    entries = [(f"{CLASSES[k].name} {counts[k] or ''}".strip(), _colour_of(k)) for k in numbers]
    levels = [(f"{level:g} m", colour) for level, colour in zip(_LEVELS, _LEVEL_COLOURS, strict=True)]
    rows = [some for some in (entries, [] if by_label else levels) if some]
    for number, some in enumerate(rows):
        drawing.legend((edge, eye.height - edge - step * (len(rows) - number)), some, small)


def _colour_of(number: int) -> Colour:
    red, green, blue = PALETTE[number].tolist()
    return red, green, blue


def _strips(image: RangeImage) -> dict[str, np.ndarray]:
    """Range, class, and intensity if the image has it, uint8 [H, W, 3] each: a column is one azimuth, even if beams
    fire at other azimuths in a column."""
    rows, columns, inside = image.sensor.azimuth_grid()
    depth, label = (np.where(inside, values[rows, columns], 0) for values in (image.depth, image.label))
    strips = {"range": colour_by_depth(depth), "class": PALETTE[label]}
    if image.intensity is not None:
        grey = (np.sqrt(np.clip(image.intensity, 0, 1)) * 255).astype(np.uint8)[rows, columns] * inside
        strips["intensity"] = np.repeat(grey[..., None], 3, axis=2)
    return strips


def _over_strips(picture: np.ndarray, image: RangeImage, most: int = 3) -> np.ndarray:
    """The picture over the first `most` of the range images, at its width."""
    size = picture.shape[1], round(picture.shape[0] * _STRIP)
    strips = [
        caption(np.asarray(Image.fromarray(strip).resize(size, Image.Resampling.NEAREST)), name, size=12)
        for name, strip in list(_strips(image).items())[:most]
    ]
    return stack([picture, *strips])


def render_image(image: RangeImage) -> np.ndarray:
    """The range image itself, depth over label (over intensity, if it has one): uint8 [H', W, 3]."""
    scale = max(1, round(128 / image.sensor.shape[0]))
    return stack([np.repeat(strip, scale, axis=0) for strip in _strips(image).values()])


def render_preview(layout: Layout, scan: RangeImage, pose: np.ndarray) -> np.ndarray:
    """A layout from above beside a scan of it from world_from_sensor `pose`, by class: uint8 [H, W, 3]."""
    views = [
        caption(render_from_above(layout), "layout"),
        caption(render_scan(scan, pose, by_label=True), f"simulated scan, {scan.sensor.name}"),
    ]
    return stack(views, across=True)


def render_layout_and_cast(layout: Layout, sensor: Sensor) -> np.ndarray:
    """The shapes of a layout, in a view of its objects and from above, over their cast: uint8 [H, W, 3]."""
    views = [render_layout(layout, eye) for eye in _eyes(layout.boxes())]
    return _over_strips(stack(views, across=True), raycast(layout, sensor))


def render_pair(scan: RangeImage, condition_image: RangeImage) -> np.ndarray:
    """A training pair, the condition image beside the scan, each over its range image: uint8 [H, W, 3]."""
    views = [
        _over_strips(caption(render_scan(image, image.sensor.pose(), eye=_BEHIND_SMALL), name), image, 2)
        for name, image in (("condition image", condition_image), ("scan", scan))
    ]
    return stack(views, across=True)


def sheet(pictures: Sequence[np.ndarray], columns: int = 2) -> np.ndarray:
    """Pictures of one size in rows of `columns`: uint8 [H, W, 3]."""
    rows = [list(pictures[first : first + columns]) for first in range(0, len(pictures), columns)]
    return stack([stack(row, across=True) for row in rows])


def stack(pictures: list[np.ndarray], *, across: bool = False) -> np.ndarray:
    """Pictures below (or beside) each other, padded to one width (height): uint8 [H, W, 3]."""
    along, other = (1, 0) if across else (0, 1)
    shape = [0, 0, 3]
    shape[along] = sum(picture.shape[along] for picture in pictures) + _GAP * (len(pictures) - 1)
    shape[other] = max(picture.shape[other] for picture in pictures)
    whole, start = np.zeros(shape, dtype=np.uint8), 0
    for picture in pictures:
        height, width, _ = picture.shape
        row, column = (0, start) if across else (start, 0)
        whole[row : row + height, column : column + width] = picture
        start += picture.shape[along] + _GAP
    return whole


def caption(picture: np.ndarray, text: str, *, size: int = 18) -> np.ndarray:
    """The picture with a line of text, `size` pixels high, in its upper left corner."""
    image = Image.fromarray(picture)
    pen, place = ImageDraw.Draw(image), (size / 2, size / 3)
    left, top, right, bottom = pen.textbbox(place, text, font=font(size))
    pen.rectangle((left - 4, top - 3, right + 4, bottom + 3), fill=(0, 0, 0))
    pen.text(place, text, fill=(255, 255, 255), font=font(size))
    return np.asarray(image)


def fields_of(image: RangeImage) -> dict[str, np.ndarray]:
    """The known values of each return [N] of an image, by their names in `html_page`."""
    row, column = np.nonzero(image.valid)
    kept = {name: getattr(image, name) for name in ("label", "instance", "intensity")}
    known = {name: values[image.valid] for name, values in kept.items() if values is not None}
    return {"row": row, "column": column, "range": image.depth[image.valid], "time": image.times(), **known}


def html_page(points: np.ndarray, fields: Mapping[str, np.ndarray], *, boxes: Sequence[Box], title: str) -> str:
    """One self-contained page of HTML that shows points [N, 3] with boxes, can be turned, and shows the fields of a
    point.

    `fields` [N] are class ids (`label`), instances as in the boxes (`instance`), `intensity` of 0 to 1, `row`,
    `column`, `range` [m] and `time` in the sweep [s]; any may be missing. Points more than 1000 m away are left out,
    and coordinates rounded to the 32767th part of the furthest. Raises `LayoutError` if arrays do not fit.
    """
    fields = {"label": np.zeros(len(points), np.uint8), **fields}
    if wrong := [name for name, values in fields.items() if values.shape != (len(points),)]:
        raise LayoutError(f"{' and '.join(wrong)} must have a value for each of {len(points)} points")
    within = np.abs(points).max(axis=1, initial=0.0) <= _FURTHEST
    points, fields = points[within], {name: values[within] for name, values in fields.items()}
    furthest = float(np.abs(points).max(initial=1.0))
    sent = {axis: (points[:, c], "<i2", furthest / 32767) for c, axis in enumerate("xyz")}
    sent |= {name: (values, *_SENT[name]) for name, values in fields.items()}
    packed = zlib.compress(b"".join(_planes(*each) for each in sent.values()), 6)
    near = min(boxes, key=lambda box: math.hypot(*box.center[:2]), default=None)
    data = {
        "title": title or "LiDAR scan",
        "count": len(points),
        "fields": [(name, np.dtype(kind).itemsize, unit) for name, (_, kind, unit) in sent.items()],
        "packed": base64.b64encode(packed).decode(),
        "classes": [(row.name, _colour_of(row.id) if row.id else _WHITE, row.is_thing) for row in CLASSES],
        "levels": list(zip(_LEVELS, _LEVEL_COLOURS, strict=True)),
        "boxes": [
            {"id": box.id, "label": BY_NAME[box.label].id, "instance": box.instance, "corners": corners}
            for box, corners in zip(boxes, corners_of(boxes).round(3).tolist(), strict=True)
        ],
        "reach": min(furthest, 100.0),
        "target": list(near.center) if near and math.hypot(*near.center[:2]) < _SHOWN_WITHIN else [0.0, 0.0, 0.0],
    }
    page = Path(__file__).with_name("view.html").read_text(encoding="utf-8")
    return page.replace("DATA", json.dumps(data).replace("<", "\\u003c"), 1)


def _planes(values: np.ndarray, kind: str, unit: float) -> bytes:
    """The bytes of values in units, as differences from the previous value: all lowest bytes first, which zlib
    compresses better."""
    steps = np.diff(np.round(values / unit).astype(kind), prepend=np.zeros(1, kind))
    return steps.view(np.uint8).reshape(len(values), steps.itemsize).T.tobytes()


def save_png(path: str | os.PathLike[str], picture: np.ndarray) -> None:
    """Write the picture uint8 [H, W, 3]."""
    height, width, _ = picture.shape
    # The filters that Pillow tries for each row take three times as long, and make drawings larger.
    rows = np.zeros((height, 1 + 3 * width), dtype=np.uint8)
    rows[:, 1:] = picture.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = {b"IHDR": head, b"IDAT": zlib.compress(rows.data, 1), b"IEND": b""}
    parts = [
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks.items()
    ]
    with written_whole(path) as temporary:
        temporary.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))


def save_gif(path: str | os.PathLike[str], pictures: Iterable[np.ndarray], seconds: float) -> None:
    """Write pictures uint8 [H, W, 3] as an endless GIF film that shows each for `seconds`."""
    frames = iter(map(Image.fromarray, pictures))
    first = next(frames).quantize(_FILM_COLOURS, Image.Quantize.FASTOCTREE)
    rest = (frame.quantize(palette=first, dither=Image.Dither.NONE) for frame in frames)
    with written_whole(path) as temporary:
        shown = max(20, round(1000 * seconds))  # many viewers slow shorter frames down
        first.save(temporary, "GIF", save_all=True, append_images=rest, duration=shown, loop=0)


def save_mp4(path: str | os.PathLike[str], pictures: Iterable[np.ndarray], seconds: float) -> None:
    """Write pictures uint8 [H, W, 3] as a film (H.264) that shows each for `seconds`; a last odd row or column is left
    out. Raises `MissingExtraError` if PyAV is not installed."""
    with extra():
        import av
    frames = iter(pictures)
    first = next(frames)
    height, width = (extent // 2 * 2 for extent in first.shape[:2])  # colours are stored for four pixels at once
    with written_whole(path) as temporary, av.open(os.fspath(temporary), "w", format="mp4") as film:
        stream = film.add_stream(
            "libx264", rate=Fraction(1 / seconds).limit_denominator(1000), options={"crf": _FILM_LOSS}
        )
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for picture in itertools.chain([first], frames):
            film.mux(stream.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(picture[:height, :width]))))
        film.mux(stream.encode())
