"""KITTI's 3D object benchmark: velodyne/, label_2/, calib/ and image_2/ (Geiger et al., CVPR 2012).

Boxes are in the frame of a camera: x right, y down, z ahead. Their place is the middle of the bottom, the order is
height, width, length, and rotation_y is clockwise from x, seen from above. Readers leave out everything outside the
picture, which is all that is behind and beside a camera on the vehicle. So the camera is far behind it, high and wide
enough to see every point; the pictures are black.
"""

from __future__ import annotations

import io
import math
import os
import warnings
from collections import Counter
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text, write_text
from lidardraft.formats.frame import Annotation, Drives, Frame, numbered, write_image_sets
from lidardraft.formats.kitti import calibration_of, numbers_of, write_bin
from lidardraft.scene.box import Box
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import CLASSES

TYPE_OF_CLASS = {
    "person": "Pedestrian",
    "rider": "Cyclist",
    "car": "Car",
    "truck": "Truck",
    "bus": "Truck",
    "train": "Tram",
    "motorcycle": "Misc",
    "bicycle": "Misc",
}
CLASS_OF_TYPE = {
    **{kitti: name for name, kitti in TYPE_OF_CLASS.items()},
    "Truck": "truck",
    "Van": "car",
    "Person_sitting": "person",
    "Misc": "other",
}
# All object types of box files, in lower case.
CLASS_OF_NAME = {
    **{name.lower(): label for name, label in CLASS_OF_TYPE.items()},
    "vehicle": "car",
    **{row.name: row.name for row in CLASSES if row.id},
}
_NAMES = {"R_rect": "R0_rect", "Tr_velo_cam": "Tr_velo_to_cam"}  # of the tracking benchmark: those of this one
_CAMERA = np.array([(0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)])  # camera_from_lidar
_AWAY = 4.0  # distance of the camera behind the sensor, in ranges of the sensor
_MARGIN = 1.02  # of the range: noise, and the sensor's motion in a sweep
_CAR_HEIGHT, _LEAST_PIXELS = 1.5, 25.0  # a car at the end of the range is as high as the benchmark's limit
_PARTLY, _LARGELY = 0.1, 0.5  # occluded shares from which an object counts as partly and largely occluded
_LONGEST = 10_000  # lines of a label file
_FARTHEST = 1e6  # m between a camera and the LiDAR


def write_kitti_object(folder: Path, drives: Drives, first: int) -> None:
    """Write training/ with velodyne/, label_2/, calib/ and image_2/, and ImageSets/; objects without points are left
    out."""
    for part in ("velodyne", "label_2", "calib", "image_2"):
        (folder / "training" / part).mkdir(parents=True)
    splits = dict[str, str]()
    for name, frame in numbered(drives, first):
        _write_frame(folder / "training", name, frame)
        splits[name] = frame.split
    write_image_sets(folder, splits)


def _write_frame(folder: Path, name: str, frame: Frame) -> None:
    camera_from_lidar, projection, size = virtual_camera(frame.sensor)
    write_bin(folder / "velodyne" / f"{name}.bin", frame.points, frame.intensity)
    (folder / "image_2" / f"{name}.png").write_bytes(_black_picture(size))
    rows = {f"P{camera}": projection for camera in range(4)}
    rows |= {"R0_rect": np.eye(3), "Tr_velo_to_cam": camera_from_lidar[:3], "Tr_imu_to_velo": np.eye(4)[:3]}
    lines = [f"{key}: {' '.join(f'{value:.12e}' for value in values.ravel())}\n" for key, values in rows.items()]
    write_text(folder / "calib" / f"{name}.txt", "".join(lines))
    labels = [_line(annotation, camera_from_lidar, projection, size) for annotation in frame.seen()]
    write_text(folder / "label_2" / f"{name}.txt", "".join(labels))


def virtual_camera(sensor: Sensor) -> tuple[np.ndarray, np.ndarray, tuple[int, int]]:
    """camera_from_lidar [4, 4], projection P2 [3, 4], and width and height [px] of a picture that shows every point."""
    reach = _MARGIN * sensor.max_range
    away = _AWAY * reach
    focal = _LEAST_PIXELS * (away + reach) / _CAR_HEIGHT
    half_width = math.ceil(focal / math.sqrt(_AWAY**2 - 1))  # a circle's tangent
    steepest = min(1.0, math.sin(max(map(abs, sensor.elevations))) + 0.02)
    half_height = math.ceil(focal * steepest / (_AWAY - 1))
    camera_from_lidar = np.eye(4)
    camera_from_lidar[:3, :3] = _CAMERA
    camera_from_lidar[2, 3] = away
    projection = np.array([(focal, 0.0, half_width, 0.0), (0.0, focal, half_height, 0.0), (0.0, 0.0, 1.0, 0.0)])
    return camera_from_lidar, projection, (2 * half_width, 2 * half_height)


@lru_cache(maxsize=4)
def _black_picture(size: tuple[int, int]) -> bytes:
    from PIL import Image  # slow to import, so not for --help

    buffer = io.BytesIO()
    Image.new("L", size).save(buffer, "PNG")
    return buffer.getvalue()


def _line(annotation: Annotation, camera_from_lidar: np.ndarray, projection: np.ndarray, size: tuple[int, int]) -> str:
    box = annotation.box
    length, width, height = box.size
    x, y, z = _CAMERA @ (np.array(box.center) - (0.0, 0.0, height / 2)) + camera_from_lidar[:3, 3]
    turn = math.remainder(-box.yaw - math.pi / 2, math.tau)
    alpha = math.remainder(turn - math.atan2(x, z), math.tau)
    corners = box.corners() @ _CAMERA.T + camera_from_lidar[:3, 3]
    seen = corners @ projection[:, :3].T
    pixels = np.clip(seen[:, :2] / seen[:, 2:], 0, np.array(size) - 1)
    occluded = int(annotation.occlusion >= _PARTLY) + int(annotation.occlusion >= _LARGELY)
    numbers = (alpha, *pixels.min(axis=0), *pixels.max(axis=0), height, width, length, x, y, z, turn)
    return f"{TYPE_OF_CLASS[box.label]} 0.00 {occluded} {' '.join(f'{number:.4f}' for number in numbers)}\n"


def read_label_2(
    path: str | os.PathLike[str], calib: str | os.PathLike[str] | None = None, *, frame: int | None = None
) -> list[Box]:
    """The boxes of a label_2 file, or of a `frame` (0) of a label_02 file of the tracking benchmark. They are in the
    frame of the LiDAR, by the calibration `calib`, by default the file of the same name in calib/.

    DontCare is left out; so are, with a warning, other types and objects without a size in 3D. Raises `FormatError`
    naming the file and the invalid line.
    """
    text, left = read_text(path).removeprefix("\ufeff"), Counter[str]()
    with named(f"{os.fspath(path)} needs its calibration"):
        lidar_from_camera = _lidar_from_camera(calib or Path(path).absolute().parent.parent / "calib" / Path(path).name)

    def box(number: int, words: list[str]) -> Box | None:
        if len(words) not in (8, 15, 16):
            raise FormatError(f"{' '.join(words)!r:.80} is not an object of KITTI: a type and 14 numbers")
        label = CLASS_OF_NAME.get(words[0].lower())
        height, width, length, *place, turn = (numbers_of(words[1:15], 7, 14) + [0.0] * 7)[7:14]
        if words[0] == "DontCare" or label is None or min(height, width, length) <= 0:
            left["without a size in 3D" if label else words[0]] += 1
            return None
        center = lidar_from_camera[:3, :3] @ np.subtract(place, (0.0, height / 2, 0.0)) + lidar_from_camera[:3, 3]
        ahead = lidar_from_camera[:3, :3] @ (math.cos(turn), 0.0, -math.sin(turn))
        yaw = math.atan2(ahead[1], ahead[0])
        return Box(f"{label}_{number}", label, number, tuple(center.tolist()), (length, width, height), yaw)

    with named(path):
        boxes = boxes_of_lines(_of_frame(text, path, frame) if text.lstrip()[:1].isdigit() else text, box)
    del left["DontCare"]
    if left:
        said = ", ".join(f"{count} {what}" for what, count in left.items())
        warnings.warn(f"{os.fspath(path)}: objects are left out: {said}", stacklevel=2)
    return boxes


def _of_frame(text: str, path: str | os.PathLike[str], frame: int | None) -> str:
    """The lines of one frame of tracking labels in the form of label_2, without frame and track; other lines are
    empty."""
    lines = [[*line.split(maxsplit=2), "", "", ""] for line in text.splitlines()]
    frames = [line[0] for line in lines if line[2]] or ["none"]
    if str(frame or 0) not in frames:
        raise FormatError(f"there is no frame {frame or 0} in these labels of frames {frames[0]} to {frames[-1]}")
    if frame is None and len({*frames}) > 1:
        said = f"KITTI's tracking labels of frames {frames[0]} to {frames[-1]}; 0 is read (--frame N reads another)"
        warnings.warn(f"{os.fspath(path)}: {said}", stacklevel=3)
    return "\n".join(line[2] if line[0] == str(frame or 0) else "" for line in lines)


def boxes_of_lines(text: str, box: Callable[[int, list[str]], Box | None]) -> list[Box]:
    """The boxes that `box` makes of a number, from 1 on, and the words of each non-empty line. Raises `FormatError`
    naming the invalid line."""
    boxes = list[Box]()
    lines = {number: words for number, line in enumerate(text.splitlines(), start=1) if (words := line.split())}
    if len(lines) > _LONGEST:
        raise FormatError(f"{len(lines)} lines; up to {_LONGEST} are read")
    for number, words in lines.items():
        with named(f"line {number}"):
            if (made := box(len(boxes) + 1, words)) is not None:
                boxes.append(made)
    return boxes


def _lidar_from_camera(path: str | os.PathLike[str]) -> np.ndarray:
    rows = {_NAMES.get(name, name): words for name, words in calibration_of(read_text(path)).items()}
    with named(path):
        if missing := [key for key in ("R0_rect", "Tr_velo_to_cam") if key not in rows]:
            raise FormatError(f"there is no line {missing[0]}")
        rectified, camera = np.eye(4), np.eye(4)
        rectified[:3, :3] = np.reshape(numbers_of(rows["R0_rect"], 9), (3, 3))
        camera[:3] = np.reshape(numbers_of(rows["Tr_velo_to_cam"], 12), (3, 4))
        with np.errstate(all="ignore"):
            pose = rectified @ camera
            is_rotation = np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-2)
        if not is_rotation or not np.abs(pose[:3, 3]).max() < _FARTHEST:
            raise FormatError(f"R0_rect or Tr_velo_to_cam is not a rotation, or moves by more than {_FARTHEST:g} m")
        back: np.ndarray = np.linalg.inv(pose)
        return back
