"""Clouds of CARLA's semantic LiDAR (`sensor.lidar.ray_cast_semantic`): x y z CosAngle ObjIdx ObjTag, as .ply or .npy.

CARLA's frame is left-handed, with y to the right. Tags are those of CARLA 0.9.14 and later (`CityObjectLabel` in
LibCarla/source/carla/rpc/ObjectLabel.h). Earlier versions number them as in `TAGS_BEFORE_0_9_14`.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lidardraft.array_files import parse_npy
from lidardraft.errors import FormatError, SensorError
from lidardraft.files import named, read_bytes
from lidardraft.formats.ply import parse_ply
from lidardraft.scene.materials import MATERIALS
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, GROUND

Tags = Mapping[int, tuple[str, str | None]]
# Class of each tag and, if it differs from the class's, its material.
TAGS: Tags = {
    0: ("none", None),
    1: ("road", None),
    2: ("sidewalk", None),
    3: ("building", None),
    4: ("wall", None),
    5: ("fence", None),
    6: ("pole", None),
    7: ("traffic-light", None),
    8: ("traffic-sign", None),
    9: ("vegetation", None),
    10: ("terrain", None),
    11: ("none", None),  # sky
    12: ("person", None),
    13: ("rider", None),
    14: ("car", None),
    15: ("truck", None),
    16: ("bus", None),
    17: ("train", None),
    18: ("motorcycle", None),
    19: ("bicycle", None),
    20: ("other", None),  # static
    21: ("other", None),  # dynamic
    22: ("other", None),
    23: ("none", None),  # water
    24: ("road", "road-paint"),
    25: ("terrain", "concrete"),  # ground: level, and of no other tag
    26: ("other", "concrete"),  # bridge
    27: ("terrain", "gravel"),  # rail track
    28: ("fence", "metal"),  # guard rail
}
# Earlier tags from 0 on, by those of today; 10 were all vehicles, 4 people with or without one.
_BEFORE = (0, 3, 5, 22, 12, 6, 24, 1, 2, 9, 14, 4, 8, 11, 25, 26, 27, 28, 7, 20, 21, 23, 10)
TAGS_BEFORE_0_9_14: Tags = {before: TAGS[tag] for before, tag in enumerate(_BEFORE)}
VERSIONS = {"0.9.13": TAGS_BEFORE_0_9_14, "0.9.14": TAGS}  # of CARLA, at which tags changed
FIELDS = ("x", "y", "z", "CosAngle", "ObjIdx", "ObjTag")
_LOW = -0.5  # m from the sensor; lower hits are mostly ground
_RAISED = ("pole", "traffic-light", "traffic-sign")  # classes with tags that were those of ground
_INDEX = {material.name: i for i, material in enumerate(MATERIALS)}


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class CarlaCloud:
    """N hits in the sensor frame, as the arguments of `observe_points`: `points` f32 [N, 3] [m], `incidence` f32 [N],
    `label` u8 [N] of `CLASSES`, `instance` u32 [N], the actor's id for things and 0 for stuff, `materials` i64 [N] of
    `MATERIALS`, -1 for that of the class."""

    points: np.ndarray
    incidence: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    materials: np.ndarray


def read_carla(path: str | os.PathLike[str], tags: Tags = TAGS) -> CarlaCloud:
    """A cloud as written by `save_to_disk` (.ply), or an .npy file of the records of `raw_data`.

    Raises `FormatError` naming the file if it is neither, is truncated, or has a tag that is not in `tags`.
    """
    data = read_bytes(path)
    with named(path):
        if data.startswith(b"ply"):
            hits = parse_ply(data)
        else:
            with named("neither a .ply nor an .npy file"):
                hits = parse_npy(data)
        return carla_cloud({name: hits[name] for name in hits.dtype.names or ()}, tags, of=path)


def carla_cloud(hits: Mapping[str, np.ndarray], tags: Tags, *, of: str | os.PathLike[str]) -> CarlaCloud:
    """The cloud of the columns [N] of `FIELDS`. A `UserWarning` reports poles, lights and signs at the height of the
    ground: the tags are of an older version. `of` is the name of the file in messages; raises as `read_carla`."""
    for name in FIELDS:
        if name not in hits or hits[name].ndim != 1 or hits[name].dtype.kind not in "fiu":
            raise FormatError(f"it has no {name} of one number a hit; CARLA's semantic LiDAR has {' '.join(FIELDS)}")
    table = np.full((max(tags) + 2, 2), -1)
    for tag, (name, material) in tags.items():
        table[tag] = BY_NAME[name].id, -1 if material is None else _INDEX[material]
    with np.errstate(invalid="ignore"):  # other tools write floats
        held = hits["ObjTag"].astype(np.int64)
    label, materials = table[np.where((held >= 0) & (held < len(table)), held, -1)].T
    unknown = np.flatnonzero(label < 0)
    if len(unknown):
        raise FormatError(f"hit {unknown[0]} has tag {hits['ObjTag'][unknown[0]]}; CARLA has tags 0 to {max(tags)}")
    numbers = np.stack([hits[name] for name in FIELDS[:4]], axis=1)
    if not np.isfinite(numbers).all():
        raise FormatError(f"hit {np.argwhere(~np.isfinite(numbers))[0, 0]} is not finite")
    low = label[numbers[:, 2] < _LOW]
    raised, level = (np.isin(low, [BY_NAME[name].id for name in names]).sum() for names in (_RAISED, GROUND))
    if tags is TAGS and raised > level:
        said = f"below the sensor {raised} hits have tags of poles, traffic lights or signs, and {level} of the ground"
        said += "; these are tags of roads before CARLA 0.9.14: give --carla-tags 0.9.13"
        warnings.warn(f"{os.fspath(of)}: {said}", stacklevel=2)
    is_thing = np.array([row.is_thing for row in BY_NAME.values()])[label]
    return CarlaCloud(
        points=numbers[:, :3] * np.array([1, -1, 1], np.float32),
        incidence=np.minimum(np.abs(numbers[:, 3]), 1.0),
        label=label.astype(np.uint8),
        instance=np.where(is_thing, hits["ObjIdx"], 0).astype(np.uint32),
        materials=materials,
    )


def carla_sensor(
    *,
    channels: int = 32,
    upper_fov: float = 10.0,
    lower_fov: float = -30.0,
    max_range: float = 10.0,
    points_per_second: int = 56000,
    rotation_frequency: float = 10.0,
    mount_height: float = 2.4,
) -> Sensor:
    """The sensor of these attributes of the blueprint, in CARLA's units [degrees, m, Hz] and with its defaults.

    Its simulation must take one step a rotation, so that a cloud is a full turn. Raises `SensorError` on an invalid
    attribute.
    """
    if channels < 1 or not rotation_frequency > 0.0:
        raise SensorError(f"channels is {channels} and rotation_frequency {rotation_frequency}; they must be over 0")
    columns = round(points_per_second / rotation_frequency / channels)
    return Sensor(
        name="carla",
        elevations=tuple(np.deg2rad(np.linspace(upper_fov, lower_fov, channels)).tolist()),
        columns=columns,
        azimuth_start=math.pi + math.pi / max(columns, 1),  # the first ray of a turn points straight back
        min_range=0.0,
        max_range=max_range,
        mount_height=mount_height,
        range_sigma=0.01,
        sweep_time=1.0 / rotation_frequency,
    )
