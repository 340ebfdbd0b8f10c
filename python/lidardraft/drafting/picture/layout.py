"""A picture becomes a layout: depth and classes of its pixels become a pseudo point cloud, and its clusters shapes.

Networks predict depth and classes if these are not given; nothing else here depends on networks.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from PIL import Image

from lidardraft.drafting.cloud.ground import GROUND_IDS
from lidardraft.drafting.cloud.layout import clusters_of, layout_from_cloud
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.drafting.picture.points import PseudoCloud, pseudo_cloud
from lidardraft.drafting.picture.road import RoadPlane, corrected_depth, find_road_plane
from lidardraft.errors import LayoutError, check_type
from lidardraft.files import named
from lidardraft.formats.intrinsics import read_intrinsics
from lidardraft.formats.picture import Picture, read_picture
from lidardraft.json_fields import are_numbers, is_number
from lidardraft.perception.mask_votes import number_objects
from lidardraft.scene.edit import placed
from lidardraft.scene.layout import Layout
from lidardraft.semantics import NUM_CLASSES

DEPTH = "depth-anything/Depth-Anything-V2-Metric-Outdoor-Small-hf"
SEMANTICS = "tue-mps/cityscapes_semantic_eomt_large_1024"
CAMERA_HEIGHT = 1.65  # m, of the cameras on KITTI's car (Geiger et al., IJRR 2013)
_LONGEST_SIDE = 2048  # pixels; finer than `pseudo_cloud.CELL` in a picture of up to 170 degrees
_FURTHEST = 100.0  # m; depth further away is unreliable
_BEYOND = 1e9  # m, the limit of depths, so that their products are finite
_VOXEL = 0.1  # m, a cell with one point
_TOGETHER = 1.0  # m; the largest gap in an object, as behind a pole
_MOST_MASKS = 1000  # SAM finds some 100 to 200 in a picture
_FOOT = 0.1  # m over the road; lower points are road, with the class of an object behind it

PathLike = str | os.PathLike[str]
Network = Callable[[np.ndarray], np.ndarray]  # pixels u8 [h, w, 3] -> a value a pixel [h, w]
MaskNetwork = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def layout_from_image(
    image: np.ndarray | PathLike,
    *,
    depth: np.ndarray | PathLike | Network = DEPTH,
    semantics: np.ndarray | PathLike | Network = SEMANTICS,
    masks: np.ndarray | PathLike | MaskNetwork | None = None,
    intrinsics: object | None = None,
    hfov: float | None = None,
    camera_height: float | None = CAMERA_HEIGHT,
    place: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Layout:
    """The layout of one picture.

    `image`: u8 [H, W, 3] or a JPEG, PNG or WebP file. `depth`: f [H, W] along the axis of the camera, 0 if unknown; or
    a network for metric depth: its id, its folder, or a `DepthNetwork`. `semantics`: class ids [H, W] of
    `semantics.CLASSES`, 0 for the sky and unknown pixels; or a network, likewise.

    `masks` of objects, each of which gets the class of most of its pixels: bool [M, H, W], the best first; their
    numbers [H, W], 0 if unknown; or a network for masks, such as SAM. `intrinsics`: K [3, 3] or (fx, fy, cx, cy) in
    pixels, or a file of them: JSON, or a calibration of KITTI; else `hfov`, the horizontal field of view [rad]; else
    the focal length in the file. `camera_height` [m] over the road sets the scale; with None depth is in metres. The
    tilt comes from the road. `place`: (x, y, yaw) of the camera in the frame of the layout [m, rad].

    `coverage` of the layout is the field of view of the picture; `surround` puts a street around it. Raises
    `LayoutError` on invalid values or if no ground is visible, `FormatError` on a file that is not a picture,
    `CheckpointError` if a network is missing.
    """
    check_type("image", image, np.ndarray, str, os.PathLike)
    if isinstance(intrinsics, str | os.PathLike):
        intrinsics = read_intrinsics(intrinsics)
    options = (depth, semantics, masks, intrinsics, hfov, camera_height, place)
    if isinstance(image, np.ndarray):
        return _layout(Picture(image), *options)
    picture = read_picture(image)
    with named(image):
        return _layout(picture, *options)


def _layout(
    picture: Picture,
    depth: Any,
    semantics: Any,
    masks: Any,
    intrinsics: object | None,
    hfov: float | None,
    camera_height: float | None,
    place: tuple[float, float, float],
) -> Layout:
    pixels = picture.pixels
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
        raise LayoutError(f"the picture is {pixels.dtype} {list(pixels.shape)}; it must be uint8 [H, W, 3]")
    height, width = pixels.shape[:2]
    camera = _camera(width, height, intrinsics, hfov, picture.film_focal_length)
    _check_numbers(camera_height, place)
    _check_masks(masks, (height, width))
    # Arrays are checked before any network is loaded, which takes seconds.
    for name, given in (("depth", depth), ("semantics", semantics), ("masks", masks)):
        if isinstance(given, np.ndarray) and name != "masks":
            _check_array(name, given, (height, width))
        elif not isinstance(given, np.ndarray | None) and (pixels == pixels[0, 0]).all():
            raise LayoutError("the picture is of one colour; nothing is to be seen in it")
    scale = min(1.0, _LONGEST_SIDE / max(height, width))
    camera = camera.resized(max(1, round(width * scale)), max(1, round(height * scale)))
    small = np.asarray(Image.fromarray(pixels).resize((camera.width, camera.height), Image.Resampling.BOX))
    seen, labels, numbers = _seen(small, depth, semantics, masks)
    cloud = pseudo_cloud(seen, labels, numbers, camera)
    plane = find_road_plane(cloud.points, cloud.labels)
    stands = plane.height
    if camera_height is not None:
        stands = float(camera_height)
        cloud = pseudo_cloud(corrected_depth(seen, labels, camera, plane, stands), labels, numbers, camera)
    layout = _levelled_layout(cloud, plane, stands, _coverage(camera, plane))
    provenance = {
        "source": "image",
        "depth": _name(depth),
        "semantics": _name(semantics),
        "hfov": 2 * math.atan(camera.width / 2 / camera.fx),
        "sensor_height": stands,
        "scale": stands / plane.height,
    }
    note = f"depth times {stands / plane.height:.2f}, so that the camera is {stands:g} m over the road"
    return _placed(replace(layout, provenance=provenance, notes=(note,)), place)


def _levelled_layout(cloud: PseudoCloud, plane: RoadPlane, stands: float, coverage: tuple[float, float]) -> Layout:
    points = cloud.points @ plane.level.T * (stands / plane.height)
    kept = np.linalg.norm(points, axis=1) < _FURTHEST
    kept &= np.isin(cloud.labels, GROUND_IDS) | (np.abs(points[:, 2] + stands) > _FOOT)
    points, labels, instances = points[kept], cloud.labels[kept], cloud.instances[kept]
    kept, rays = _thinned(points)
    points, labels, instances = points[kept], labels[kept], instances[kept]
    labels[_over_edges(points, labels, instances, rays)] = 0
    layout = layout_from_cloud(points, labels, instances=instances, weights=rays, sensor_height=stands, source="image")
    return replace(layout, coverage=coverage)


def _thinned(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The indices [M] of one point a cell, and the number of points [M] in each cell."""
    cells = np.floor((points - points.min(axis=0)) / _VOXEL).astype(np.int64)
    x, y, _ = cells.max(axis=0) + 1
    _, kept, count = np.unique(cells @ np.array([1, x, x * y]), return_index=True, return_counts=True)
    return kept, count


def _over_edges(points: np.ndarray, labels: np.ndarray, instances: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """bool [N]: points of numbered objects in other clusters than the one with most of the object's `rays` [N].

    A mask that reaches over the edge of its object includes points behind it, and the box of all would be as deep.
    """
    over = np.zeros(len(points), dtype=bool)
    objects = np.where(instances > 0, instances.astype(np.int64) * NUM_CLASSES + labels, 0)
    for number in np.unique(objects[objects > 0]):
        mine = np.flatnonzero(objects == number)
        parts = [mine[part] for part in clusters_of(points[mine], _TOGETHER, min_points=1)]
        over[mine] = True
        over[max(parts, key=lambda part: rays[part].sum())] = False
    return over


def _camera(
    width: int, height: int, intrinsics: object | None, hfov: float | None, film_focal_length: float | None
) -> Pinhole:
    if intrinsics is not None and hfov is not None:
        raise LayoutError("intrinsics and hfov both set the focal length; give one of them")
    if intrinsics is not None:
        return Pinhole.from_matrix(intrinsics, width, height)
    if hfov is not None:
        return Pinhole.from_hfov(hfov, width, height)
    if film_focal_length is not None:
        return Pinhole.from_film(film_focal_length, width, height)
    raise LayoutError(
        "the picture has no focal length; give hfov (--hfov), its horizontal field of view: 65 to 75 degrees "
        "for most telephones, 80 for KITTI"
    )


def _check_numbers(camera_height: float | None, place: tuple[float, float, float]) -> None:
    if camera_height is not None and not (is_number(camera_height) and 0.1 <= camera_height <= 100):
        raise LayoutError(f"camera_height is {camera_height!r} m; it must be 0.1 to 100 m over the road")
    if not are_numbers(place, 3):
        raise LayoutError(f"place is {place!r}; it must be three finite numbers, x, y and yaw")


def _check_array(name: str, array: np.ndarray, shape: tuple[int, int]) -> None:
    if array.shape != shape:
        raise LayoutError(f"{name} has shape {list(array.shape)}; a picture of that size needs {list(shape)}")
    kinds = "fiu" if name == "depth" else "iu"
    if array.dtype.kind not in kinds:
        raise LayoutError(
            f"{name} holds {array.dtype}; it must hold {'numbers' if name == 'depth' else 'whole numbers'}"
        )
    wrong = ~np.isfinite(array) | (array < 0)
    limit = "finite, and 0 if unknown"
    if name == "semantics":
        wrong |= array >= NUM_CLASSES
        limit = f"a class id, 0 to {NUM_CLASSES - 1}; other tables are read by lidardraft.formats.cityscapes"
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        raise LayoutError(f"{name} at row {row}, column {column} is {array[row, column]}; it must be {limit}")
    if name != "masks" and not array.any():
        raise LayoutError(f"{name} is 0 everywhere; nothing is known of the picture")


def _check_masks(masks: Any, shape: tuple[int, int]) -> None:
    if not isinstance(masks, np.ndarray):
        return
    if masks.ndim == 3 and (masks.dtype != bool or masks.shape[1:] != shape):
        size = f"a picture of that size needs bool [M, {shape[0]}, {shape[1]}]"
        raise LayoutError(f"masks are {masks.dtype} {list(masks.shape)}; {size}, or numbers {list(shape)}")
    if masks.ndim != 3:
        _check_array("masks", masks, shape)
    number = len(masks) if masks.ndim == 3 else len(np.unique(masks[masks > 0]))
    if number > _MOST_MASKS:
        raise LayoutError(f"there are {number} masks; up to {_MOST_MASKS} can be given")


def _seen(small: np.ndarray, depth: Any, semantics: Any, masks: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth, classes and numbers of objects: arrays of the whole picture, or predictions of networks for the small
    one."""
    if not isinstance(semantics, np.ndarray):
        semantics = _network("SemanticNetwork", semantics)(small)
    if not isinstance(depth, np.ndarray):
        depth = _network("DepthNetwork", depth)(small)
    semantics, depth = _resized(semantics, small), np.minimum(_resized(depth, small).astype(np.float64), _BEYOND)
    if isinstance(masks, np.ndarray):
        few = np.array([_resized(mask, small) for mask in (masks if masks.ndim == 3 else masks[None])])
        semantics, instances = number_objects(semantics, few if masks.ndim == 3 else few[0])
    elif masks is not None:
        semantics, instances = _network("MaskNetwork", masks)(small, semantics)
    else:
        instances = np.zeros_like(semantics)
    return depth, semantics, _resized(instances, small)


def _network(kind: str, given: Any) -> Any:
    """A given function, or the network of that kind with an id or in a folder."""
    if callable(given):
        return given
    from lidardraft.perception import picture_networks

    return getattr(picture_networks, kind).from_pretrained(given)


def _resized(array: np.ndarray, like: np.ndarray) -> np.ndarray:
    """The nearest pixels of an array [H, W], at the resolution of `like` [h, w, ...]."""
    rows, columns = (
        ((np.arange(few) + 0.5) * many / few).astype(np.intp)
        for few, many in zip(like.shape[:2], array.shape, strict=True)
    )
    return array[rows[:, None], columns]


def _coverage(camera: Pinhole, plane: RoadPlane) -> tuple[float, float]:
    """The azimuths [rad] of the right and the left edge, at the height of the axis."""
    edges = camera.rays(np.array(camera.cy), np.array([camera.width - 0.5, -0.5])) @ plane.level.T
    right, left = np.arctan2(edges[:, 1], edges[:, 0]).tolist()
    return right, left


def _placed(layout: Layout, place: tuple[float, float, float]) -> Layout:
    yaw = float(place[2])
    assert layout.coverage is not None
    right, left = layout.coverage
    return replace(layout, primitives=tuple(placed(layout, place)), coverage=(right + yaw, left + yaw))


def _name(given: object) -> str:
    if isinstance(given, np.ndarray):
        return "array"
    return os.fspath(given) if isinstance(given, str | os.PathLike) else str(getattr(given, "name", "network"))
