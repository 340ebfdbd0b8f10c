"""Recorded scans of one sensor: points with known lasers.

The laser of a point is known from the order of KITTI's files (laser by laser, each once around), from a field `ring`,
or from the rows of an organised cloud. It is not guessed from elevations: the points of one laser have many, in the
frame of a vehicle or with its motion taken out.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft import array_files
from lidardraft.errors import FormatError
from lidardraft.files import named, read_bytes, regular_size
from lidardraft.formats.carla import FIELDS as CARLA_FIELDS
from lidardraft.formats.carla import TAGS, Tags, carla_cloud
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.las import read_las
from lidardraft.formats.masks import read_masks
from lidardraft.formats.nuscenes import lidarseg_of, read_lidarseg, read_pcd_bin
from lidardraft.formats.ouster import count_frames, osf_frame, read_ouster_capture
from lidardraft.formats.pandaset import read_sweep
from lidardraft.formats.pcd import read_pcd
from lidardraft.formats.ply import read_ply
from lidardraft.formats.point_fields import SCALES, named_fields, unit_intensity
from lidardraft.formats.rosbag import BAG_ENDINGS, count_clouds, is_bag, read_cloud
from lidardraft.formats.semantickitti import read_label
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import NUM_CLASSES

_NEAREST = 0.1  # m: nearer points are not returns (organised clouds hold zeros for missing ones)
_MOST_LASERS = 512
_MOST_POINTS = 2**22  # of a scan; the largest sensors have half a million
LOG_ENDINGS = (*BAG_ENDINGS, ".pcap", ".osf")  # files of many scans; a folder with a bag is one too
SCAN_ENDINGS = (".bin", ".pcd.bin", ".pcd", ".ply", ".npz", ".npy", ".las", ".pkl.gz", *LOG_ENDINGS)
_FIELDS = ("label", "instance", "column", "made_up")  # of an .npz file, with those of `NAMES`
_OFF, _FURTHEST = 50.0, 1000.0  # m: the nearest returns are seldom further than the first, and never than the second
_NEAR = 0.05  # the share that counts as nearest returns: a few points of a map may lie near its origin
_MAP = "the nearest returns are {:.0f} m from the origin, the place of the sensor; of a cloud in the frame of a map"
_MAP += ", subtract the sensor's place, and of one in other units make metres"
_COARSE = 0.01  # m: coarser steps of coordinates are reported
_NO_LASERS = "the lasers of the points are unknown: no field ring, no rows, not laser by laser as in KITTI's files"
_ORDERLY = 0.98  # the least share of small steps ahead in a file of KITTI's order
_SMALL_STEP = np.deg2rad(5.0)
_ASIDE = 0.05  # the share of the seam's crossings that go back, by lasers with other azimuths
_NO_JUMP = 1e-3  # of a slope: lasers are further apart


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """One scan: `points` f32 [N, 3] in the sensor frame [m], and the laser `ring` i64 [N] of each, in any order.

    `intensity` f32 [N] in 0 to 1, `label` u8 [N] of the class ids, and `column` i64 [N], the number of the firing, are
    None if unknown.
    """

    name: str
    points: np.ndarray
    ring: np.ndarray
    intensity: np.ndarray | None = None
    label: np.ndarray | None = None
    column: np.ndarray | None = None


def read_recording(
    path: str | os.PathLike[str],
    *,
    intensity_scale: float | None = None,
    carla_tags: Tags = TAGS,
    frame: int | None = None,
    topic: str | None = None,
) -> Recording:
    """A scan from a file of one of `SCAN_ENDINGS`, with the labels that data sets have beside it.

    A PCD or PLY file has x, y, z and a field `ring`, or is organised (its HEIGHT rows are lasers), or has its points
    laser by laser, as KITTI's files do; fields may have any name of `point_fields.NAMES`. An .npz file is a range
    image, or has `xyz` [N, 3] and optional `ring`, `intensity`, `label` (class ids), `instance`, `column` [N]. That of
    a scan written by lidardraft is read in place of its `.bin`, which lacks the lasers.

    `intensity_scale` is the number for an intensity of 1, by default that of the format. `carla_tags` are the tags of a
    cloud of CARLA. From a log, the scan number `frame` is read, by default 0; from a bag with several topics of points,
    that of `topic`. Raises `FormatError` if the file is something else or has no points, or if their lasers or the
    scale of their intensities are unknown.
    """
    path = Path(path)
    image = path.with_suffix(".npz")
    if path.suffix == ".bin" and image.exists() and path.with_suffix(".sensor.json").exists():
        path = image
    if path.suffix == ".npz" and {"depth", "sensor"}.issubset(array_files.names_in(path)):
        return _of_image(os.fspath(path), RangeImage.load(path))
    points, fields = read_points(path, intensity_scale=intensity_scale, carla_tags=carla_tags, frame=frame, topic=topic)
    fields = {field: values for field, values in fields.items() if field not in ("instance", "made_up")}
    try:
        with named(path):
            return recording_of(f"{path}, frame {frame}" if frame is not None else str(path), points, **fields)
    except FormatError as error:
        raise FormatError(f"{error}{with_fields(path)}" if _NO_LASERS in str(error) else str(error)) from None


def read_points(
    path: str | os.PathLike[str],
    *,
    intensity_scale: float | None = None,
    carla_tags: Tags = TAGS,
    needs_intensity: bool | None = True,
    frame: int | None = None,
    topic: str | None = None,
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The points [N, 3] of such a file in the sensor's frame, and the fields of each, `instance` too; their lasers may
    be unknown. A `UserWarning` reports each conversion, clipped value and oddity. Intensities of unknown scale raise
    `FormatError`; if `needs_intensity` is False they are left out with a `UserWarning`, if None silently. `frame` and
    `topic` are those of `read_recording`.
    """
    stated = next((scale for ending, scale in SCALES.items() if os.fspath(path).endswith(ending)), None)
    scale = stated if intensity_scale is None else intensity_scale
    if topic is not None and not is_bag(path):
        raise FormatError(f"{os.fspath(path)} is not a ROS 2 bag; --topic (topic) is for bags")
    if frame is not None and frame < 0:
        raise FormatError(f"frame is {frame}; it must be 0 or more")
    if is_log(path):
        points, fields = _from_log(path, frame or 0, topic, carla_tags)
    elif frame is not None:
        raise FormatError(f"{os.fspath(path)} is one scan; --frame (frame) is for logs, {', '.join(LOG_ENDINGS)}")
    else:
        points, fields = _read(path, 1.0 if scale is None else scale, carla_tags)
    if points.ndim != 2 or any(values.shape != points.shape[:1] for values in fields.values()):
        return points, fields  # `returns` refuses it
    ranges = _ranges(points)
    if "intensity" in fields and Path(path).suffix != ".bin":
        given = fields.pop("intensity")
        try:
            with named(path):
                fields["intensity"] = unit_intensity(given, scale, of=path, returned=ranges > 0)
        except FormatError as error:
            if needs_intensity:
                raise
            if needs_intensity is False:
                warnings.warn(f"{error}; read without intensities", stacklevel=2)
    if _OFF < (nearest := _nearest(ranges)) <= _FURTHEST:
        warnings.warn(f"{os.fspath(path)}: {_MAP.format(nearest)}", stacklevel=2)
    return points, fields


def _read(path: str | os.PathLike[str], scale: float, tags: Tags) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    suffix = Path(path).suffix
    if Path(path).name.endswith(".pcd.bin"):
        points, intensity, ring = read_pcd_bin(path, scale)
        fields = {"intensity": intensity, "ring": ring} | _labels_beside(Path(path), len(points))
        file = None if "label" in fields else lidarseg_of(path)
        return points, fields if file is None else fields | {"label": read_lidarseg(file, len(points))}
    if suffix == ".bin":
        points, intensity = read_bin(path, scale)
        return points, {"intensity": intensity} | _labels_beside(Path(path), len(points))
    if suffix == ".pcd":
        return _from_pcd(path, tags)
    if suffix == ".ply":
        vertices = read_ply(path)
        return _from_columns(path, {name: vertices[name] for name in vertices.dtype.names or ()}, tags)
    if suffix == ".npz":
        return _from_npz(path)
    if suffix == ".npy":
        return _from_npy(path, tags)
    if suffix == ".las":
        return read_las(path)
    if Path(path).name.endswith(".pkl.gz"):
        return read_sweep(path)
    raise FormatError(f"{os.fspath(path)}: a recorded scan is one of {', '.join(SCAN_ENDINGS)}")


def is_log(path: str | os.PathLike[str]) -> bool:
    """Whether a path holds many scans: a bag of ROS 2, or a log of an Ouster."""
    return is_bag(path) or Path(path).suffix in LOG_ENDINGS


def frames_in(path: str | os.PathLike[str], topic: str | None = None) -> int:
    """The number of scans of a log; raises `FormatError` if it is broken."""
    return count_clouds(path, topic) if is_bag(path) else count_frames(path)


def _from_log(
    path: str | os.PathLike[str], frame: int, topic: str | None, tags: Tags
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    if not is_bag(path):
        return read_ouster_capture(path, frame) if Path(path).suffix == ".pcap" else osf_frame(path, frame)
    cloud = read_cloud(path, frame, topic)
    return _with_rows(*_from_columns(path, cloud.columns, tags), cloud.rows)


def _with_rows(
    points: np.ndarray, fields: dict[str, np.ndarray], rows: int
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """An organised cloud with its rows as lasers, if no field gives these."""
    if "ring" not in fields and rows > 1 and len(points) % rows == 0:
        width = len(points) // rows
        fields = fields | {"ring": np.arange(len(points)) // width, "column": np.arange(len(points)) % width}
    return points, fields


def read_returns(
    path: str | os.PathLike[str], labels: str | os.PathLike[str] | None = None, **how: Any
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The returns of such a file with their fields, as in `returns`; `labels` is another file of labels for them, and
    `how` are further arguments of `read_points`."""
    points, fields = read_points(path, **how)
    if labels is not None:
        fields |= read_labels(labels, len(points), of=path)
    with named(path):
        return returns(points, fields)


def _of_image(name: str, image: RangeImage) -> Recording:
    known = {"ring": image.beams(), "column": np.nonzero(image.valid)[1]}
    if image.intensity is not None:
        known["intensity"] = image.intensity[image.valid]
    if image.label.any():
        known["label"] = image.label[image.valid]
    with named(name):
        return recording_of(name, image.points(), **known)


def returns(points: np.ndarray, fields: Mapping[str, np.ndarray]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The points f32 [N, 3] that are returns, finite and not at the origin, with their fields; intensities in 0 to 1.

    Raises `FormatError` if there are none, if the arrays do not fit or hold invalid values, if intensities are over 1,
    and if no point is near enough for a sensor at the origin."""
    points = np.asarray(points)
    counts = {np.shape(each)[:1] for each in (points, *fields.values())}
    if points.ndim != 2 or points.shape[1] != 3 or len(counts) > 1:
        raise FormatError(f"points {points.shape} must be [N, 3], with a value of each field for each")
    if len(points) > _MOST_POINTS:
        raise FormatError(f"{len(points)} points; scans of up to {_MOST_POINTS} are read")
    ranges = _ranges(points)
    there = ranges > 0
    if not there.any():
        raise FormatError("the scan is empty: it has no return")
    if (nearest := _nearest(ranges)) > _FURTHEST:
        raise FormatError(_MAP.format(nearest))
    found = {field: np.asarray(values)[there] for field, values in fields.items()}
    if "intensity" in found:
        with np.errstate(over="ignore", invalid="ignore"):
            found["intensity"] = found["intensity"].astype(np.float32)
        if not ((found["intensity"] >= 0) & (found["intensity"] <= 1)).all():
            raise FormatError("an intensity is not finite or not within 0 to 1")
    if "label" in found and not ((found["label"] >= 0) & (found["label"] < NUM_CLASSES)).all():
        held = f"{found['label'].min()} to {found['label'].max()}"
        raise FormatError(f"label holds {held}; classes are 0 to {NUM_CLASSES - 1}")
    return points[there].astype(np.float32), found


def _ranges(points: np.ndarray) -> np.ndarray:
    """The distances of points [N, 3], 0 for those that are not returns."""
    with np.errstate(over="ignore", invalid="ignore"):  # distances too large for float64 become infinite
        distance = np.linalg.norm(points.astype(np.float64), axis=1)
    return np.where(np.isfinite(distance) & (distance > _NEAREST), distance, 0.0)


def _nearest(ranges: np.ndarray) -> float:
    """The distance of the nearest returns of a scan, infinite if it has none."""
    there = ranges[ranges > 0]
    return float(np.quantile(there, _NEAR, method="lower")) if len(there) else np.inf


def read_semantic_map(path: str | os.PathLike[str], sensor: Sensor) -> np.ndarray:
    """The classes [H, W] of a sensor's rays: from a .png or .npy of class ids, or from a labelled scan.

    Raises `FormatError` if the file is something else or has no labels."""
    if Path(path).suffix in (".png", ".npy"):
        return read_masks(path)
    points, fields = read_returns(path, needs_intensity=None)
    with named(path):
        if "label" not in fields:
            raise FormatError("it has no labels; a semantic map is made of them")
        return RangeImage.project(points, sensor, label=fields["label"]).label


def recording_of(name: str, points: np.ndarray, **fields: np.ndarray) -> Recording:
    """The recording of `points` [N, 3] and `ring`, `intensity`, `label`, `column` [N]; points that are not returns or
    not finite are left out. Raises `FormatError` as `read_recording` does."""
    points, fields = returns(points, fields)
    ring = fields.pop("ring", None)
    ring = rings_of_order(points) if ring is None else ring.astype(np.int64)
    if ring.min() < 0 or ring.max() >= _MOST_LASERS:
        raise FormatError(f"rings are {ring.min()} to {ring.max()}; they must be 0 to {_MOST_LASERS - 1}")
    for field in ("label", "column"):
        if field in fields:
            fields[field] = fields[field].astype(np.uint8 if field == "label" else np.int64)
    return Recording(name=name, points=points, ring=ring, **fields)


def rings_of_order(points: np.ndarray) -> np.ndarray:
    """The lasers of points that come laser by laser, each once around: from straight ahead, as in KITTI's files, or
    from behind, as in files of lidardraft. Raises `FormatError` for another order."""
    x, y, z = points.astype(np.float64).T
    azimuth, slope = np.arctan2(y, x), z / np.maximum(np.hypot(x, y), _NEAREST)
    steps, wraps, most = np.zeros(0), np.zeros(0, bool), -1.0
    for seam in (0.0, np.pi):
        found = np.diff((azimuth - seam) % (2 * np.pi))
        crossed = np.abs(found) > np.pi
        # from one laser to the next the slope jumps; at a laser's crossing of the other seam it hardly does
        jump = float(np.median(np.abs(np.diff(slope))[crossed])) if crossed.any() else _NO_JUMP
        if jump > most:
            steps, wraps, most = found, crossed, jump
    ahead = np.sign(np.median(steps[~wraps])) if (~wraps).any() else 0.0
    orderly = wraps | ((steps * ahead >= -1e-3) & (np.abs(steps) < _SMALL_STEP))
    # a laser with another start azimuth crosses the seam, and crosses it back
    aside = (wraps & (steps * ahead > 0)).sum() > _ASIDE * wraps.sum()
    if len(steps) < 8 or orderly.mean() < _ORDERLY or wraps.sum() >= _MOST_LASERS or aside:
        raise FormatError(_NO_LASERS)
    return np.concatenate([[0], np.cumsum(wraps)])


def read_labels(path: str | os.PathLike[str], count: int, *, of: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Classes u8 [count], and instances if the file has them: SemanticKITTI's .label, nuScenes' lidarseg (.bin of a
    byte a point), MMDetection3D's masks of class ids (.bin of eight bytes a point).

    `of` is the name of the scan in messages. Raises `FormatError` if the file does not hold `count` labels."""
    if Path(path).suffix != ".bin":
        return dict(zip(("label", "instance"), read_label(path, count, of=of), strict=True))
    size = regular_size(path)
    if size != 8 * count:
        return {"label": read_lidarseg(path, count)}
    label = np.frombuffer(read_bytes(path), "<i8")
    unknown = label[(label < 0) | (label >= NUM_CLASSES)]
    if len(unknown):
        raise FormatError(f"{os.fspath(path)} has class {unknown[0]}; it must be 0 to {NUM_CLASSES - 1}")
    return {"label": label.astype(np.uint8)}


def _labels_beside(path: Path, count: int) -> dict[str, np.ndarray]:
    """The labels in the places of data sets: SemanticKITTI's NAME.label beside the scan, or in labels/ beside its
    folder; MMDetection3D's in semantic_mask/."""
    root, name = path.absolute().parent.parent, f"{path.stem}.label"
    for file in (path.parent / name, root / "labels" / name, root / "semantic_mask" / path.name):
        if file.exists():
            return read_labels(file, count, of=path)
    return {}


def with_fields(path: str | os.PathLike[str]) -> str:
    """The end of a message: the fields of a file whose format names them."""
    names = list[str]()
    if (suffix := Path(path).suffix) == ".npz":
        names = array_files.names_in(path)
    elif suffix in (".pcd", ".ply"):
        names = list(read_pcd(path).columns if suffix == ".pcd" else read_ply(path).dtype.names or ())
    return f"; its fields are {', '.join(names)}" if names else ""


def _from_npy(path: str | os.PathLike[str], tags: Tags) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """OpenPCDet's x y z intensity [N, 4 or more], for WebDataset's NAME.points.npy the arrays beside it, or records
    with names."""
    points = array_files.read_npy(path)
    if points.dtype.names and points.ndim == 1:
        return _from_columns(path, {name: points[name] for name in points.dtype.names}, tags)
    if points.ndim != 2 or points.shape[1] < 3 or points.dtype.kind not in "fiu":
        held = f"{points.dtype} {points.shape}"
        raise FormatError(f"{os.fspath(path)} holds {held}; points are numbers x y z and more [N, 3 or more]")
    fields = {"intensity": points[:, 3]} if points.shape[1] > 3 else {}
    stem, dot, _ = os.fspath(path).rpartition(".points.npy")
    beside = {field: f"{stem}.{field}.npy" for field in ("ring", "label", "instance") if dot}
    fields |= {field: array_files.read_npy(file) for field, file in beside.items() if os.path.exists(file)}
    return points[:, :3], fields


def _from_pcd(path: str | os.PathLike[str], tags: Tags) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    file = read_pcd(path)
    points, fields = _from_columns(path, file.columns, tags)
    if file.viewpoint is not None:
        from scipy.spatial.transform import Rotation  # slow to import, so not for --help

        turned = (points - file.viewpoint[:3]) @ Rotation.from_quat(np.roll(file.viewpoint[3:], -1)).as_matrix()
        seen = np.where(points.any(axis=1, keepdims=True), turned, 0.0)  # zeros are missing returns
        said = "is applied: points are taken from its frame into the sensor's"
        if (step := float(np.spacing(np.abs(points).max()))) > _COARSE:
            said += f", where coordinates of {points.dtype} are in steps of {step:.2g} m"
        if _nearest(_ranges(seen)) > max(_OFF, _nearest(_ranges(points))):
            seen, said = points, "is not applied: the points lie around their origin, and far from it"
        warnings.warn(f"{os.fspath(path)}: VIEWPOINT {file.viewpoint.round(3).tolist()} {said}", stacklevel=2)
        points = seen
    return _with_rows(points, fields, file.height if file.width * file.height == len(points) else 1)


def _from_columns(
    path: str | os.PathLike[str], columns: dict[str, np.ndarray], tags: Tags
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    plain = {name.removeprefix("scalar_"): values for name, values in columns.items()}
    if set(CARLA_FIELDS) <= plain.keys():
        said = "CARLA's semantic LiDAR, whose y points right: y is turned to the left, and ObjTag gives the classes"
        warnings.warn(f"{os.fspath(path)}: a cloud of {said}", stacklevel=2)
        with named(path):
            cloud = carla_cloud(plain, tags, of=path)
        return cloud.points, {"label": cloud.label, "instance": cloud.instance}
    if list(columns) == ["x", "y", "z", "I"]:
        said = "x y z I are the fields of CARLA's LiDAR, whose y points right; y is read unchanged: negate it if so"
        warnings.warn(f"{os.fspath(path)}: {said}", stacklevel=2)
    names = named_fields([name for name, values in columns.items() if values.ndim == 1])
    if missing := [axis for axis in "xyz" if axis not in names]:
        raise FormatError(f"{os.fspath(path)}: there is no field {missing[0]} of one value a point")
    # labels of other tools have other classes; `lidardraft export` writes all four fields
    ours = ("label", "instance") if {"ring", "label", "instance"} <= columns.keys() else ()
    found = {field: columns[name] for field, name in names.items() if field not in "xyz"}
    found |= {field: columns[field] for field in ours}
    return np.stack([columns[names[axis]] for axis in "xyz"], axis=1), found


def _from_npz(path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    names = array_files.names_in(path)
    found = {field: name for field, name in named_fields(names).items() if field not in "xyz"}
    found |= {field: field for field in _FIELDS if field in names}
    with array_files.opened(path) as archive:
        points = array_files.read_numbers(archive, "xyz")
        return points, {field: array_files.read_numbers(archive, name) for field, name in found.items()}
