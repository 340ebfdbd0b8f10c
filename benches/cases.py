"""Layouts of recordings and of streets, and the scans that become of them on the grid of what was recorded."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

import recordings
from lidardraft import Layout, Pipeline, RangeImage, Sensor, Simulator, layout_from_cloud, raycast
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.labelling import label_by_agreement
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets import StreetConfig, streets
from report_streets import unhidden

SEED = 2_000_000  # no training uses it

Render = Callable[[RangeImage], Sweep]


@dataclass(frozen=True)
class Group:
    """Recordings of one sensor; `render` puts a scan on their grid.

    `shown` are the pixels that the recording car leaves open. On a grid of `firings` a pixel without a return is a
    dropped one.
    """

    sweeps: list[Sweep]
    sensor: Sensor
    render: Render
    shown: np.ndarray
    firings: bool


@dataclass(frozen=True)
class Case:
    """A recorded scan, the layout of it, and the sensor's pose and speed [m/s] as it was taken."""

    recorded: Sweep
    layout: Layout
    sensor: Sensor
    pose: np.ndarray
    speed: float = 0.0


@dataclass(frozen=True)
class CaseSet:
    """Cases of one sensor, on the grid of a `Group`."""

    cases: list[Case]
    render: Render
    shown: np.ndarray
    firings: bool


def recorded_sets(folder: Path) -> Iterator[tuple[str, Callable[[], CaseSet]]]:
    """The sets of recordings, by name."""
    kitti, nuscenes = PRESETS["hdl64e-linear"], recordings.NUSCENES_GRID
    yield "KITTI, HDL-64E", lambda: clustered(recordings.kitti_images(folder), PRESETS["hdl64e"], grid=kitti)
    yield "nuScenes, HDL-32E", lambda: clustered(recordings.nuscenes_images(folder), PRESETS["hdl32e"], grid=nuscenes)
    yield "PandaSet, Pandar64", lambda: _clustered_groups(recordings.pandar64(folder, 1800), PRESETS["pandar64"])
    yield "ika, VLP-32C", lambda: _clustered_groups(recordings.vlp32c(folder, 1800), PRESETS["vlp32c"])


def street_set(number: int, sensor: Sensor = PRESETS["hdl64e"]) -> CaseSet:
    """Scans of streets, and their coarse layouts."""
    pairs = islice(streets(seed=SEED, config=StreetConfig(sensor=sensor, poses_per_street=1)), number)
    cases = [Case(Sweep.by_azimuth(pair.scan), pair.layout, sensor, pair.pose, pair.speed) for pair in pairs]
    return CaseSet(cases, Sweep.by_azimuth, np.ones(sensor.shape, dtype=bool), firings=True)


def _clustered_groups(found: recordings.Recordings, sensor: Sensor) -> CaseSet:
    sweeps = [sweep for group in found.labelled.values() for sweep in group]
    return clustered(sweeps, sensor, fov=found.fov)


def clustered(sweeps: list[Sweep], sensor: Sensor, grid: Sensor | None = None, fov: float | None = None) -> CaseSet:
    """The sweeps with their layouts."""
    group = grouped(sweeps, sensor, grid, fov)
    cases = [Case(sweep, layout_of(sweep, sensor), sensor, sensor.pose()) for sweep in sweeps]
    return CaseSet(cases, group.render, group.shown, group.firings)


def grouped(sweeps: list[Sweep], sensor: Sensor, grid: Sensor | None = None, fov: float | None = None) -> Group:
    """Sweeps of a sensor: images on a projected `grid`, or firings, of which some see only an angle `fov` ahead."""
    shown = unhidden({"": sweeps}, grid or sensor, fov)
    if grid is not None:
        return Group(sweeps, sensor, partial(_projected, grid=grid), shown, firings=False)
    if fov is None or not sweeps:
        return Group(sweeps, sensor, Sweep.by_azimuth, shown, firings=True)
    width = sweeps[0].points.shape[1]
    start = (sensor.columns - width) // 2
    ahead = partial(_ahead, start=start, stop=start + width)
    return Group(sweeps, sensor, ahead, shown[:, start : start + width], firings=True)


def _ahead(image: RangeImage, start: int, stop: int) -> Sweep:
    return Sweep.by_azimuth(image).part(start, stop)


def layout_of(sweep: Sweep, sensor: Sensor, detail: str = "fine") -> Layout:
    """The layout of a labelled sweep."""
    assert sweep.label is not None
    seen = sweep.valid & (sweep.label > 0)
    points, labels = sweep.points[seen], sweep.label[seen]
    return layout_from_cloud(points, labels, sensor_height=sensor.mount_height, detail=detail)


def _projected(image: RangeImage, grid: Sensor) -> Sweep:
    values = {name: getattr(image, name) for name in ("label", "intensity")}
    seen = {name: value[image.valid] for name, value in values.items() if value is not None}
    return Sweep.from_image(RangeImage.project(image.points(), grid, **seen))


def scans_of(case: Case, seed: int, generators: Mapping[str, Pipeline]) -> dict[str, RangeImage]:
    """The scans that a layout becomes, by what makes them; each seed has a unit of the sensor. `generators` make whole
    scans."""
    sensor, pose = case.sensor, case.pose
    model = replace(sensor.assumed_model, unit=seed)

    def simulated(detail: bool) -> RangeImage:
        simulator = Simulator(case.layout, sensor, seed=seed, model=model, detail=detail)
        return simulator.scan(pose, speed=case.speed, seed=seed).image

    poses = sensor.poses_in_motion(pose, case.speed * pose[:3, 0])
    scans = {"cast": raycast(case.layout, sensor, poses=poses), "+ sensor model": simulated(False)}
    scans["simulated"] = simulated(True)
    known = scans["simulated"], scans["cast"]
    for name, generator in generators.items():
        made = generator.generate(scans["cast"], seed=seed)
        scans[name] = label_by_agreement(made, known, case.layout, poses)
    return scans


def sweeps_of(cases: CaseSet, generators: Mapping[str, Pipeline] | None = None) -> Iterator[dict[str, Sweep]]:
    """The "recorded" scan of each case and its `scans_of`, without what the recording car hides."""
    for number, case in enumerate(cases.cases):
        made = {name: cases.render(image) for name, image in scans_of(case, number, generators or {}).items()}
        yield {name: _shown(sweep, cases.shown) for name, sweep in {"recorded": case.recorded, **made}.items()}


def _shown(sweep: Sweep, shown: np.ndarray) -> Sweep:
    return dataclasses.replace(sweep, points=np.where(shown[..., None], sweep.points, np.float32(0)))
