"""Pictures, uint8 [H, W, 3], of layouts and range images. The camera is a sensor that casts and projects."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from lidardraft.errors import FormatError
from lidardraft.files import written_whole
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.semantickitti import read_label
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, CLASSES

PALETTE = np.array([row.colour for row in CLASSES], dtype=np.uint8)
_BACKGROUND = np.array([24, 26, 32], dtype=np.uint8)
_RAMP = np.array(
    [[48, 18, 59], [70, 107, 227], [40, 188, 235], [50, 242, 152], [164, 252, 60], [249, 186, 56], [228, 69, 10]]
)
_GAP = 6
_SKY = 1000.0  # m, the height from which a layout is looked at from above


def _camera() -> Sensor:
    """A sensor that looks along its x axis with rays as dense as a picture's, equal angles apart."""
    width, height, field_of_view = 720, 480, math.radians(64)
    half = field_of_view / 2 * height / width
    return Sensor(
        name="camera",
        elevations=tuple(np.linspace(half, -half, height).tolist()),
        columns=width,
        azimuth_start=field_of_view / 2,
        azimuth_span=field_of_view,
        min_range=0.1,
        max_range=500.0,
    )


def _camera_pose() -> np.ndarray:
    """world_from_camera [4, 4]: 16 m behind and 11 m over the ego vehicle, looking 24 degrees down."""
    cos, sin = math.cos(math.radians(24)), math.sin(math.radians(24))
    return np.array([[cos, 0, sin, -16.0], [0, 1, 0, 0], [-sin, 0, cos, 11.0], [0, 0, 0, 1]], dtype=np.float64)


def render_layout(layout: Layout) -> np.ndarray:
    """The shapes of a layout, shaded, seen by the camera: uint8 [H, W, 3]."""
    image = raycast(layout, _camera(), _camera_pose(), incidence=True)
    assert image.incidence is not None
    shade = 0.35 + 0.65 * image.incidence[..., None]
    return np.where(image.valid[..., None], PALETTE[image.label] * shade, _BACKGROUND).astype(np.uint8)


def render_points(points: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """Points [N, 3] of the layout's frame in their colours uint8 [N, 3], seen by the camera: uint8 [H, W, 3]."""
    sensor, pose = _camera(), _camera_pose()
    image = RangeImage.project((points - pose[:3, 3]) @ pose[:3, :3], sensor, instance=np.arange(1, len(points) + 1))
    picture = np.broadcast_to(_BACKGROUND, (*sensor.shape, 3)).copy()
    # A point is two pixels wide: the copies go first, so that no copy hides a point.
    for down, right in ((1, 1), (0, 1), (1, 0), (0, 0)):
        rows, columns = np.nonzero(image.valid)
        target = np.minimum(rows + down, sensor.shape[0] - 1), np.minimum(columns + right, sensor.shape[1] - 1)
        picture[target] = colours[image.instance[rows, columns] - 1]
    return picture


def colour_by_label(label: np.ndarray) -> np.ndarray:
    """Class colours uint8 [..., 3]; returns without a class are white."""
    return np.where((label == 0)[..., None], np.uint8(255), PALETTE[label])


def colour_by_depth(depth: np.ndarray) -> np.ndarray:
    """A ramp over the logarithm of the range from 2 to 80 m, uint8 [..., 3]; black where there is no return."""
    near, far = 2.0, 80.0
    share = np.log(np.clip(depth, near, far) / near) / math.log(far / near) * (len(_RAMP) - 1)
    colours = np.stack([np.interp(share, np.arange(len(_RAMP)), _RAMP[:, c]) for c in range(3)], axis=-1)
    return np.where(depth[..., None] > 0, colours, 0).astype(np.uint8)


def colour_by_height(z: np.ndarray) -> np.ndarray:
    """A ramp over the height over the road from -0.5 to 7 m, uint8 [..., 3]."""
    low, high = -0.5, 7.0
    share = (np.clip(z, low, high) - low) / (high - low) * (len(_RAMP) - 2) + 1
    return np.stack([np.interp(share, np.arange(len(_RAMP)), _RAMP[:, c]) for c in range(3)], axis=-1).astype(np.uint8)


def render_image(image: RangeImage) -> np.ndarray:
    """The range image itself, depth over label (over intensity, where it has one): uint8 [H', W, 3].

    A column of the picture is one azimuth, also where beams look aside from the column that they fire in.
    """
    strips = [colour_by_depth(image.depth), PALETTE[image.label]]  # uint8 [H, W, 3] each
    if image.intensity is not None:
        grey = (np.sqrt(np.clip(image.intensity, 0, 1)) * 255).astype(np.uint8)
        strips.append(np.repeat(grey[..., None], 3, axis=2))
    scale = max(1, round(128 / image.sensor.shape[0]))
    return stack([np.repeat(_by_azimuth(strip, image.sensor), scale, axis=0) for strip in strips])


def _by_azimuth(picture: np.ndarray, sensor: Sensor) -> np.ndarray:
    """Rows [H, W, 3] of a sensor whose beams look to different azimuths, shifted so that what is upright looks so."""
    if not (sensor.azimuth_offsets and sensor.wraps):
        return picture
    shifts = np.rint(np.array(sensor.azimuth_offsets) * sensor.columns / sensor.azimuth_span).astype(np.int64)
    columns = (np.arange(sensor.columns) + shifts[:, None]) % sensor.columns
    return np.take_along_axis(picture, columns[..., None], axis=1)


def render_scan(image: RangeImage, pose: np.ndarray, *, by_label: bool = False) -> np.ndarray:
    """The returns of a scan taken from world_from_sensor `pose`, seen by the camera: uint8 [H, W, 3]."""
    points = image.points() @ pose[:3, :3].T + pose[:3, 3]
    colours = colour_by_label(image.label[image.valid]) if by_label else colour_by_height(points[:, 2])
    return render_points(points, colours)


def render_top_view(
    image: RangeImage, layout: Layout, pose: np.ndarray, *, size: int = 512, reach: float = 50.0
) -> np.ndarray:
    """The returns of a scan from above, coloured by height, with the outlines of the layout's shapes over them.

    uint8 [size, size, 3]; forward is up, and the edge is `reach` [m] away.
    """
    points = image.points() @ pose[:3, :3].T + pose[:3, 3]
    scale = size / 2 / reach

    def pixels(xy: np.ndarray) -> np.ndarray:
        return np.stack([size / 2 - xy[:, 1] * scale, size / 2 - xy[:, 0] * scale], axis=-1)

    at = pixels(points[:, :2]).astype(np.int64)
    inside = ((at >= 0) & (at < size)).all(axis=1)
    order = np.argsort(points[inside, 2], kind="stable")  # what is high covers what is low
    picture = np.broadcast_to(_BACKGROUND, (size, size, 3)).copy()
    picture[at[inside, 1][order], at[inside, 0][order]] = colour_by_height(points[inside, 2][order])
    canvas = Image.fromarray(picture)
    pen = ImageDraw.Draw(canvas)
    for primitive in layout.primitives:
        if primitive.shape in ("plane", "mesh"):
            continue
        half = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * primitive.size[:2] / 2
        cos, sin = math.cos(primitive.yaw), math.sin(primitive.yaw)
        corners = half @ np.array([[cos, sin], [-sin, cos]]) + primitive.center[:2]
        colour = tuple(PALETTE[BY_NAME[primitive.label].id].tolist())
        ring = pixels(corners)
        if primitive.shape == "box":
            pen.polygon([tuple(corner) for corner in ring.tolist()], outline=colour)
        else:
            middle, radius = pixels(np.array([primitive.center[:2]]))[0], max(primitive.size[:2]) / 2 * scale
            pen.ellipse((*(middle - radius).tolist(), *(middle + radius).tolist()), outline=colour)
    return np.asarray(canvas)


def render_from_above(layout: Layout, *, size: int = 480, reach: float = 50.0) -> np.ndarray:
    """The classes of a layout's shapes from above, what is higher being lighter: uint8 [size, size, 3].

    Forward is up, the edge is `reach` [m] away, and a cross marks the ego vehicle.
    """
    middles = reach - (np.arange(size) + 0.5) * 2 * reach / size
    origins = np.stack([*np.meshgrid(middles, middles, indexing="ij"), np.full((size, size), _SKY)], axis=-1)
    origins = origins.reshape(-1, 3)
    hits = Raycaster(layout).cast(origins, np.broadcast_to([0.0, 0.0, -1.0], origins.shape), max_range=2 * _SKY)
    height = np.clip(_SKY - hits.distance, 0.0, 12.0)
    shade = (0.75 + 0.25 * height / 12.0)[:, None]
    colours = np.where((hits.label > 0)[:, None], PALETTE[hits.label] * shade, _BACKGROUND).astype(np.uint8)
    canvas = Image.fromarray(colours.reshape(size, size, 3))
    pen, middle = ImageDraw.Draw(canvas), size / 2
    pen.line((middle - 5, middle, middle + 5, middle), fill=(255, 255, 255), width=2)
    pen.line((middle, middle - 8, middle, middle + 5), fill=(255, 255, 255), width=2)
    return np.asarray(canvas)


def render_preview(layout: Layout, scan: RangeImage, pose: np.ndarray) -> np.ndarray:
    """A layout from above beside a scan of it from world_from_sensor `pose`, by class: uint8 [H, W, 3]."""
    views = [
        caption(render_from_above(layout), "layout"),
        caption(render_scan(scan, pose, by_label=True), f"simulated scan, {scan.sensor.name}"),
    ]
    return stack(views, across=True)


def render_scans_of_layout(layout: Layout, pose: np.ndarray, images: dict[str, RangeImage]) -> np.ndarray:
    """A layout and scans of it from world_from_sensor `pose`, by their names: uint8 [H, W, 3].

    The scans are shown beside the layout, and their range images below.
    """
    scans = {name: render_scan(image, pose, by_label=True) for name, image in images.items()}
    views = {"layout": render_layout(layout), **scans}
    strips = {name: render_image(image) for name, image in images.items()}
    rows = [[caption(picture, name) for name, picture in row.items()] for row in (views, strips)]
    return stack([stack(row, across=True) for row in rows])


def render_pair(scan: RangeImage, condition_image: RangeImage) -> np.ndarray:
    """A training pair, the condition image over the scan: uint8 [H, W, 3]."""
    return stack([caption(render_image(condition_image), "condition image"), caption(render_image(scan), "scan")])


def render_file(path: Path, sensor: Sensor) -> np.ndarray:
    """The picture of a file, uint8 [H, W, 3]: a `.json` layout, seen by `sensor`; a `.bin` scan, taken by `sensor`,
    with the `.label` beside it if there is one; an `.npz` range image. Raises `FormatError` for any other file."""
    if path.suffix == ".json":
        return _render_layout_and_cast(Layout.load(path), sensor)
    if path.suffix == ".bin":
        return render_range_image(_read_scan(path, sensor))
    if path.suffix == ".npz":
        return render_range_image(RangeImage.load(path))
    kind = path.suffix or "a file without an ending"
    raise FormatError(f"{path}: there is no picture of {kind}; it must be .bin, .npz or .json")


def _render_layout_and_cast(layout: Layout, sensor: Sensor) -> np.ndarray:
    image = raycast(layout, sensor)
    views = [render_layout(layout), render_scan(image, sensor.pose(), by_label=True)]
    return stack([stack(views, across=True), render_image(image)])


def render_range_image(image: RangeImage) -> np.ndarray:
    """A scan on its sensor's mount by height and by label, over the range image itself: uint8 [H, W, 3]."""
    pose = image.sensor.pose()
    views = [render_scan(image, pose), render_scan(image, pose, by_label=True)]
    return stack([stack(views, across=True), render_image(image)])


def _read_scan(path: Path, sensor: Sensor) -> RangeImage:
    points, intensity = read_bin(path)
    labels = path.with_suffix(".label")
    label, instance = read_label(labels, len(points)) if labels.exists() else (None, None)
    return RangeImage.project(points, sensor, label=label, instance=instance, intensity=intensity)


def stack(pictures: list[np.ndarray], *, across: bool = False) -> np.ndarray:
    """Pictures below (or beside) each other, padded to one width (height): uint8 [H, W, 3]."""
    axis, other = (1, 0) if across else (0, 1)
    extent = max(picture.shape[other] for picture in pictures)
    rows: list[np.ndarray] = []
    for picture in pictures:
        padding = [(0, 0), (0, 0), (0, 0)]
        padding[other] = (0, extent - picture.shape[other])
        if rows:
            padding[axis] = (_GAP, 0)
        rows.append(np.pad(picture, padding))
    return np.concatenate(rows, axis=axis)


def caption(picture: np.ndarray, text: str) -> np.ndarray:
    """The picture with a line of text in its upper left corner."""
    image = Image.fromarray(picture)
    pen = ImageDraw.Draw(image)
    left, top, right, bottom = pen.textbbox((8, 6), text, font_size=18)
    pen.rectangle((left - 4, top - 3, right + 4, bottom + 3), fill=(0, 0, 0))
    pen.text((8, 6), text, fill=(255, 255, 255), font_size=18)
    return np.asarray(image)


def save_png(path: str | os.PathLike[str], picture: np.ndarray) -> None:
    """Write the picture uint8 [H, W, 3]."""
    with written_whole(path) as temporary:
        Image.fromarray(picture).save(temporary, format="png")
