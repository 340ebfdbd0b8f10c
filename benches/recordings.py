"""Recorded sweeps by sensor, in groups of one drive or place each, from a folder of public recordings.

The folder is laid out as kitti/, nuscenes/ and permissive/; what is not there is left out. KITTI and nuScenes forbid
commercial use: they judge, and no constant of this project is fitted to them.
"""

from __future__ import annotations

import io
import lzma
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from lidardraft.formats.kitti import read_bin
from lidardraft.formats.ouster import metadata_beside, read_ouster_capture, read_ouster_metadata
from lidardraft.formats.pandaset import LABELS
from lidardraft.formats.pcd import parse_pcd
from lidardraft.formats.recording import Recording, recording_of
from lidardraft.formats.semantickitti import CLASS_FROM_RAW
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, NUM_CLASSES

_LOW = -0.2  # of the distance: what lies lower is of lasers a degree and more apart
_SCALES = (0.1, 0.1, 0.05, 3.0, 1.0, 0.5, 0.004, 0.004, 0.04, 0.04)  # of the sensor's place [m], tilt, and their rates

Groups = dict[str, list[Sweep]]

# SemanticKITTI's training ids, as classes of ours
_TRAINING_IDS = (
    *("none", "car", "bicycle", "motorcycle", "truck", "truck", "person", "rider", "rider", "road"),
    *("road", "sidewalk", "terrain", "building", "fence", "vegetation", "trunk", "terrain", "pole", "traffic-sign"),
)
_IKA = ("road", "sidewalk", "building", "pole", "vegetation", "person", "bicycle", "car", "truck", "bus", "none")
# nuScenes' images: +12 to -30 degrees in 32 equal steps, here pixel centres.
NUSCENES_GRID = Sensor(
    name="hdl32e-linear",
    elevations=tuple(np.deg2rad(np.linspace(12 - 21 / 32, -30 + 21 / 32, 32)).tolist()),
    columns=1024,
)
# Share of all points of SemanticKITTI's training sequences by raw class, as `content` of its semantic-kitti.yaml says
# (Behley et al., ICCV 2019); classes below a ten thousandth left out.
# fmt: off
_SEMANTIC_KITTI_SHARES = {
    10: 0.0408185, 252: 0.0017893, 11: 0.0001661, 15: 0.0003984, 18: 0.0020634, 258: 0.0001016,
    20: 0.0016218, 257: 0.0001135, 30: 0.0001770, 254: 0.0001606, 253: 0.0001271, 40: 0.1987494,
    44: 0.0147172, 48: 0.1439230, 49: 0.0039049, 50: 0.1326862, 51: 0.0723592, 52: 0.0023951,
    70: 0.2668150, 71: 0.0060350, 72: 0.0781422, 80: 0.0028555, 81: 0.0006156, 99: 0.0099231,
}
# fmt: on


@dataclass(frozen=True)
class Recordings:
    """What there is of one sensor: `plain` groups with exact rows, and `labelled` ones with labels and intensity.

    `shares` holds published counts by class [NUM_CLASSES]; `spherical` says that the labelled ones are images of the
    usual projection (+3 to -25 degrees in equal steps) instead of rows of lasers; `fov` that they see only so wide an
    angle ahead [rad]; `halves` that the groups are the left and the right half of one sweep; `range_step` the unit [m]
    of their ranges where it is a coarse one of the recording, not the sensor's; `why` what is missing.
    """

    sensor: str
    plain: Groups = field(default_factory=dict)
    labelled: Groups = field(default_factory=dict)
    shares: dict[str, np.ndarray] = field(default_factory=dict)
    spherical: bool = False
    fov: float | None = None
    halves: bool = False
    range_step: float = 0.0
    why: str = ""


def hdl64e(folder: Path, columns: int) -> Recordings:
    """KITTI: one raw drive, sequence 00 of the odometry set, object frames of many drives; labels of sequence 00."""
    kitti = folder / "kitti"
    drive = [_kitti(*_kitti_pcd(path), columns) for path in _drive_files(folder)]
    odometry = [_kitti_bin(path, columns) for path in sorted((kitti / "odometry_00" / "velodyne").glob("*.bin"))]
    frames = [_kitti_bin(path, columns) for path in sorted((kitti / "object").glob("*/velodyne/*.bin"))]
    labelled = kitti_images(folder)
    half = 512
    return Recordings(
        sensor="hdl64e",
        plain=_there({"raw 0005": drive, "odometry 00": odometry, "object": frames}),
        labelled=_there(
            {"00, left": [s.part(0, half) for s in labelled], "00, right": [s.part(half, 1024) for s in labelled]}
        ),
        shares={"all of SemanticKITTI": _published_shares()} if labelled else {},
        spherical=True,
        why="" if drive and odometry and frames else "no recordings under kitti/",
    )


def hdl64e_drive(folder: Path) -> list[Recording]:
    """KITTI's raw drive 0005, as a sensor is fitted to it: every fourth of its scans here."""
    return [
        recording_of(path.name, points, intensity=intensity)
        for path in _drive_files(folder)
        for points, intensity in (_kitti_pcd(path),)
    ]


def kitti_images(folder: Path) -> list[Sweep]:
    """SemanticKITTI's scans as images of the usual projection, that of the preset `hdl64e-linear`."""
    files = sorted((folder / "kitti" / "range_images_00").glob("*.npy*"))
    return [_sweep(_load(path), _TRAINING_IDS, 1.0) for path in files if "ids30" not in path.name]


def nuscenes_images(folder: Path) -> list[Sweep]:
    """Scans of an HDL-32E as images of `NUSCENES_GRID`; what is nearer than 2.5 m is the recording car."""
    files = sorted((folder / "nuscenes" / "range_images").glob("*.npy*"))
    images = [_load(path) for path in files]
    for image in images:
        image[np.linalg.norm(image[..., :3], axis=2) < 2.5] = [0, 0, 0, 0, 0, _IKA.index("none")]
    return [_sweep(image, _IKA, 255.0) for image in images]


def pandar64(folder: Path, columns: int) -> Recordings:
    """PJLab's sweeps with exact rings, PandaSet's with labels."""
    pjlab, pandaset = folder / "permissive" / "pjlab_pandar64", folder / "permissive" / "pandaset"
    places = {
        "PJLab 2020": ("lidar2camera_auto_calib", "radar2lidar_lidar"),
        "PJLab 2022": ("lidar2lidar_0001_top", "lidar2lidar_0002_top"),
        "PJLab 2023": ("lidar2camera_auto_calib_v2_ours_1", "lidar2camera_auto_calib_v2_ours_2"),
    }
    plain = {
        place: [_pjlab(path, columns) for path in (pjlab / f"{name}.pcd" for name in names) if path.exists()]
        for place, names in places.items()
    }
    labelled = {}
    if pandaset.is_dir():
        table = np.loadtxt(pandaset / "pandar64_channel_distribution.csv", delimiter=",", skiprows=1)
        angles = np.sort(np.deg2rad(table[:, 2]))[::-1]
        labelled = {
            f"PandaSet {place}": [_pandaset(path, angles, columns) for path in sorted((pandaset / place).glob("*.npz"))]
            for place in ("001", "002")
        }
    why = "" if any(plain.values()) else "no recordings under permissive/pjlab_pandar64"
    return Recordings(sensor="pandar64", plain=_there(plain), labelled=_there(labelled), why=why)


def vlp32c(folder: Path, columns: int) -> Recordings:
    """ika's drive of 37 s: the 48 degrees ahead, split in halves of the drive, for there is no other."""
    del columns  # the images are what they are
    images = [_load(path) for path in sorted((folder / "permissive" / "ika_vlp32c").glob("*.npy.xz"))]
    sweeps = [_sweep(image, _IKA, 255.0) for image in images]
    halves = _there({"first half": sweeps[: len(sweeps) // 2], "second half": sweeps[len(sweeps) // 2 :]})
    why = "" if halves else "no recordings under permissive/ika_vlp32c"
    return Recordings(sensor="vlp32c", plain=halves, labelled=halves, fov=np.deg2rad(48.0), why=why)


def os0_128(folder: Path, columns: int) -> Recordings:
    """Ouster's sample of this sensor: one sweep in a street; what is nearer than 1.5 m is the recording car."""
    return _ouster(folder, "os0-128", "OS-0-128-U1_v2.3.0_1024x10.pcap", columns, range_step=8e-3)


def os1_32(folder: Path, columns: int) -> Recordings:
    """Ouster's sample of this sensor: one sweep in a street."""
    return _ouster(folder, "os1-32", "OS-1-32-G_v2.1.1_1024x10.pcap", columns)


def _ouster(folder: Path, sensor: str, name: str, columns: int, range_step: float = 0.0) -> Recordings:
    path = folder / "permissive" / "ouster" / name
    if not path.exists():
        return Recordings(sensor=sensor, why="no recordings under permissive/ouster")
    points, fields = read_ouster_capture(path)
    far = np.linalg.norm(points, axis=1) >= 1.5
    at = fields["ring"][far], fields["column"][far]
    shape = read_ouster_metadata(metadata_beside(path)).shape
    image, intensity = np.zeros((*shape, 3), np.float32), np.zeros(shape, np.float32)
    image[at], intensity[at] = points[far], fields["intensity"][far] / 255
    sweep = Sweep(image, None, intensity)
    middle, end = columns // 2, shape[1]
    halves = {"left": [sweep.part(0, middle)], "right": [sweep.part(middle, end)]}
    return Recordings(sensor=sensor, plain=halves, halves=True, range_step=range_step)


def _there(groups: Groups) -> Groups:
    return {name: sweeps for name, sweeps in groups.items() if sweeps}


def file_bytes(path: Path) -> bytes:
    """Of a file as it was before it was packed."""
    return lzma.open(path).read() if path.suffix == ".xz" else path.read_bytes()


def _load(path: Path) -> np.ndarray:
    image: np.ndarray = np.load(io.BytesIO(file_bytes(path)))
    return image


def _sweep(image: np.ndarray, classes: Sequence[str], white: float) -> Sweep:
    """An image [H, W, 6] of x, y, z, intensity up to `white`, range and the number of a class."""
    ids = np.array([BY_NAME[name].id for name in classes], dtype=np.uint8)
    intensity = (image[..., 3] / white).astype(np.float32)
    return Sweep(image[..., :3].astype(np.float32), ids[image[..., 5].astype(int)], intensity)


def _drive_files(folder: Path) -> list[Path]:
    return sorted((folder / "kitti" / "raw_drive_0005").glob("*.pcd*"))[:-1:4]


def _kitti_pcd(path: Path) -> tuple[np.ndarray, np.ndarray]:
    fields = parse_pcd(file_bytes(path)).columns
    points = np.stack([fields[axis] for axis in "xyz"], axis=1)[:-1]  # the last one is a zero that the conversion added
    return points, fields["intensity"][:-1]


def _kitti_bin(path: Path, columns: int) -> Sweep:
    return _kitti(*read_bin(path), columns)


def _kitti(points: np.ndarray, intensity: np.ndarray, columns: int) -> Sweep:
    """KITTI stores laser by laser, from the top, each once around to the left from straight ahead."""
    azimuth = np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi)
    rows = np.concatenate([[0], np.cumsum(np.diff(azimuth) < -np.pi)])
    return Sweep.from_points(points, rows, height=64, columns=columns, intensity=intensity)


def _pjlab(path: Path, columns: int) -> Sweep:
    fields = parse_pcd(path.read_bytes()).columns
    points = np.stack([fields[axis] for axis in "xyz"], axis=1)
    return Sweep.from_points(points, 63 - fields["ring"].astype(int), height=64, columns=columns)


def _pandaset(path: Path, angles: np.ndarray, columns: int) -> Sweep:
    with np.load(path) as file:
        mine = file["device"] == 0
        points, intensity, raw = file["xyz"][mine], file["intensity"][mine] / np.float32(255), file["label"][mine]
        time = file["time"][mine].astype(np.float64)
    seen = _from_sensor(points.astype(np.float64), time, angles)
    elevation = np.arctan2(seen[:, 2], np.hypot(seen[:, 0], seen[:, 1]))
    rows = np.searchsorted(-(angles[1:] + angles[:-1]) / 2, -elevation)
    return Sweep.from_points(seen, rows, height=64, columns=columns, label=LABELS[raw], intensity=intensity)


def _from_sensor(points: np.ndarray, time: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """PandaSet's points [N, 3], whose motion is taken out, seen from where the sensor was at their `time` [N].

    Its place and tilt, and how fast these change, are those with which the points lie on the cones of the lasers:
    0.04 to 0.11 mrad off (a place that stays leaves 0.6 to 0.9 of a vehicle that drives). First those of the lower
    lasers, which are too far apart to be confused.
    """
    middles, time = (angles[1:] + angles[:-1]) / 2, time - time.mean()

    def moved(pose: np.ndarray, some: slice | np.ndarray) -> np.ndarray:
        seen = points[some] - pose[:3] - np.outer(time[some], pose[3:6])
        seen[:, 2] += ((pose[6:8] + np.outer(time[some], pose[8:])) * seen[:, :2]).sum(axis=1)
        return seen

    def off(pose: np.ndarray, some: np.ndarray) -> np.ndarray:
        seen = moved(pose, some)
        elevation = np.arctan2(seen[:, 2], np.hypot(seen[:, 0], seen[:, 1]))
        return np.asarray(elevation - angles[np.searchsorted(-middles, -elevation)])

    far = np.flatnonzero(np.linalg.norm(points, axis=1) > 5.0)[::20]
    low = far[points[far, 2] < _LOW * np.hypot(points[far, 0], points[far, 1])]
    fits = []
    for speed in (0.0, 5.0):  # m/s
        pose = np.array([0.4, 0.0, 0.0, speed, 0.0, 0.0, np.deg2rad(-0.85), 0.0, 0.0, 0.0])
        for some in (low, far, far):
            found = least_squares(
                off, pose, args=(some,), loss="soft_l1", f_scale=2e-4, x_scale=_SCALES, diff_step=1e-3, max_nfev=100
            )
            pose = found.x
        fits.append((found.cost, pose))
    return moved(min(fits, key=lambda fit: fit[0])[1], slice(None)).astype(np.float32)


def _published_shares() -> np.ndarray:
    counts = np.zeros(NUM_CLASSES)
    for raw, share in _SEMANTIC_KITTI_SHARES.items():
        counts[BY_NAME[CLASS_FROM_RAW[raw]].id] += share
    return counts
