"""Endless pairs of a lifelike scan and the condition image of the same place."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Generator, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from lidardraft.errors import LayoutError, check_number, check_seed
from lidardraft.scene.box import Box
from lidardraft.scene.intent import Intent
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import IMAGES, RangeImage
from lidardraft.scene.scanner import Scanner
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.coarse_layout import ClusterStyle, Style, VisibleObjects, coarse_layout, sample_style
from lidardraft.streets.coarse.coarse_street import place_of
from lidardraft.streets.ego import Ego, mount, sample_ego
from lidardraft.streets.street import Street, StreetConfig, make_street
from lidardraft.streets.worker_processes import worker_processes

# the images of a pair, which worker processes send unchanged
_SCAN = ("depth", "label", "instance", "intensity")
_CONDITION_IMAGE = ("depth", "label", "instance")
_SIMULATED = _SCAN
_SCAN_STREAM = 1  # random numbers of a scan, apart from those of its street
_Rest = tuple[ShapeTable, np.ndarray, Style, str, float, int, ShapeTable]


@dataclass(frozen=True, slots=True, eq=False)
class StreetPair:
    """A lifelike scan of a street, and the condition image of the same place.

    `scan` has depth, label, instance and intensity. `condition_image` is the cast of the coarse layout `shapes`, as by
    `shapes.scan(sensor, pair.poses())`; `style` is the style of that layout.

    The frame is that of the ego vehicle in the middle of the sweep: `pose` is ego_from_sensor [4, 4], and the sensor
    moves ahead with `speed` [m/s]. `district` is that of the street; `index` counts the pairs of one seed. `things` are
    all objects with instances, in their true shapes, for any style of `shapes`. `simulated`, if asked for, is the
    scan by the same unit of the sensor of the coarse layout in detail.
    """

    scan: RangeImage
    condition_image: RangeImage
    shapes: ShapeTable
    pose: np.ndarray
    style: Style
    district: str
    speed: float
    index: int
    things: ShapeTable
    simulated: RangeImage | None = None

    def poses(self) -> np.ndarray:
        """The pose of each column [W, 4, 4]; both images are without motion correction, as the sensor sends them."""
        return self.scan.sensor.poses_in_motion(self.pose, (self.speed, 0.0, 0.0))

    def boxes(self) -> list[Box]:
        """Boxes of the objects of the street in the sensor frame; their instances are those of `scan`."""
        return [box.seen_from(self.pose) for box in self.things.layout({}).boxes()]

    @property
    def layout(self) -> Layout:
        """The shapes as a layout; `raycast(layout, sensor, poses=pair.poses())` gives `condition_image` too."""
        intent = Intent(headed=not isinstance(self.style, ClusterStyle))
        return self.shapes.layout({"source": self.style.source}, self.style.coverage, intent)


def streets(
    *,
    seed: int = 0,
    config: StreetConfig | None = None,
    start: int = 0,
    shard: tuple[int, int] = (0, 1),
    workers: int = 1,
) -> Generator[StreetPair, None, None]:
    """Endless pairs from number `start`; pair k depends on the seed, the config and k alone.

    `shard` (i, n) keeps the streets of the i-th of n consumers only; their pairs are disjoint and complete. `workers`
    processes make the pairs; 1 is this process. The pairs and their order are the same for any number. A script that
    asks for more than 1 needs `if __name__ == "__main__":` around it, or each process would run it again. Worker
    processes end with this one, however it ends.

    Raises `LayoutError` for a number that is negative or no integer, or a shard that does not exist, and
    `LidarDraftError` if a worker process was killed.
    """
    seed, start, workers = check_seed(seed), check_number("start", start), check_number("workers", workers, least=1)
    mine, shards = check_number("shard", shard[0]), shard[1]
    if not mine < shards:
        raise LayoutError(f"shard is {mine} of {shards}; they count from 0 to {shards - 1}")
    config = config or StreetConfig()
    first, skip = divmod(start, config.poses_per_street)
    numbers = (number for number in itertools.count(first) if number % shards == mine)
    runs = (_StreetRun(seed, config, number, skip if number == first else 0) for number in numbers)
    if workers > 1:
        return _in_processes(runs, config, workers)
    return (pair for run in runs for pair in run.pairs(None))


@dataclass(frozen=True, slots=True)
class _StreetRun:
    """The pairs of one street, from pose `first` on."""

    seed: int
    config: StreetConfig
    number: int
    first: int

    def indices(self) -> range:
        """The numbers of the pairs."""
        poses = self.config.poses_per_street
        return range(self.number * poses + self.first, (self.number + 1) * poses)

    def pairs(self, threads: int | None) -> Iterator[StreetPair]:
        street, scanner = scanned_street(self.seed, self.config, self.number, threads)
        return (_pair(street, scanner, self.config, index) for index in self.indices())


@lru_cache(maxsize=1)
def scanned_street(seed: int, config: StreetConfig, number: int, threads: int | None) -> tuple[Street, Scanner]:
    """A street and its scanner; the last ones are cached for the next pair of their run."""
    street = make_street(seed=seed, config=config, number=number)
    # another unit of the sensor for each street
    model = replace(config.sensor.assumed_model, unit=number)
    return street, Scanner.from_layout(
        street.scene, config.sensor, model=model, weather=config.weather, threads=threads
    )


def _in_processes(runs: Iterator[_StreetRun], config: StreetConfig, workers: int) -> Generator[StreetPair, None, None]:
    sensor = config.sensor
    pixel_bytes = sum(IMAGES[name].itemsize for name in _SCAN + _CONDITION_IMAGE + _SIMULATED * config.simulated)
    with worker_processes(workers, math.prod(sensor.shape) * pixel_bytes) as processes:
        turns = itertools.cycle(processes)

        # the process that has built a street makes all its pairs, one by one
        def submit() -> deque[Future[tuple[list[np.ndarray], _Rest]]]:
            run, process = next(runs), next(turns)
            return deque(process.submit(_pair_in_worker, run, index) for index in run.indices())

        # one more street for each worker, so that none waits while a street is consumed
        ahead = deque(submit() for _ in range(2 * workers))
        while True:
            street = ahead.popleft()
            while street:
                arrays, rest = street.popleft().result()
                scan, condition_image, *simulated = [
                    RangeImage.unchecked(sensor, **{name: arrays.pop(0) for name in names})
                    for names in (_SCAN, _CONDITION_IMAGE, *[_SIMULATED] * config.simulated)
                ]
                yield StreetPair(scan, condition_image, *rest, *simulated)
            ahead.append(submit())


def _pair_in_worker(run: _StreetRun, index: int) -> tuple[list[np.ndarray], _Rest]:
    """The images of a pair, and its other fields."""
    pair = _pair(*scanned_street(run.seed, run.config, run.number, 1), run.config, index)
    images = [getattr(pair.scan, name) for name in _SCAN]
    images += [getattr(pair.condition_image, name) for name in _CONDITION_IMAGE]
    if pair.simulated is not None:
        images += [getattr(pair.simulated, name) for name in _SIMULATED]
    return images, (pair.shapes, pair.pose, pair.style, pair.district, pair.speed, pair.index, pair.things)


def sample_viewpoint(street: Street, sensor: Sensor, index: int) -> tuple[Ego, np.ndarray, np.random.Generator]:
    """The viewpoint of scan `index` of a street: the ego vehicle, the sensor in its frame [4, 4] (`mount`), and the
    generator for further random numbers."""
    rng = np.random.default_rng([street.seed, index, _SCAN_STREAM])
    ego = sample_ego(street.occupancy, street.lanes, rng)
    return ego, mount(sensor, ego, rng), rng


def scan_street(street: Street, scanner: Scanner, index: int) -> tuple[Ego, VisibleObjects, np.random.Generator]:
    """Scan `index` of a street: the ego vehicle, the visible objects, and the generator for further random numbers."""
    ego, pose, rng = sample_viewpoint(street, scanner.sensor, index)
    poses = ego.pose @ scanner.sensor.poses_in_motion(pose, (ego.speed, 0.0, 0.0))
    scan = scanner.observe(scanner.cast(poses, seed=index), poses, rng)
    coarse = street.coarse
    return ego, VisibleObjects(place_of(ego.pose), pose, scan, coarse.owners, len(coarse.objects)), rng


def _pair(street: Street, scanner: Scanner, config: StreetConfig, index: int) -> StreetPair:
    ego, visible, rng = scan_street(street, scanner, index)
    style = sample_style(rng)
    shapes = coarse_layout(street.coarse, style, rng, ego.pose, visible)
    poses = scanner.sensor.poses_in_motion(visible.pose, (ego.speed, 0.0, 0.0))
    condition_image = shapes.scan(scanner.sensor, poses, threads=scanner.threads)
    things = street.coarse.standing(street.coarse.exact, street.coarse.instances > 0, ego.pose, relief=True)
    about = (shapes, visible.pose, style, street.district, ego.speed, index, things)
    pair = StreetPair(as_sent(visible.scan), condition_image, *about)
    if not config.simulated:
        return pair
    from lidardraft.simulation.simulate import Simulator  # pictures come with it, which pairs do not need

    simulator = Simulator(
        pair.layout,
        scanner.sensor,
        seed=index,
        model=scanner.model,
        weather=config.weather,
        carrier=False,
        threads=scanner.threads,
    )
    return replace(pair, simulated=as_sent(simulator.scan(pair.pose, speed=pair.speed, seed=index).image))


def as_sent(scan: RangeImage) -> RangeImage:
    """A scan without its primitives, which mean nothing without the scene and take time to send."""
    return RangeImage.unchecked(scan.sensor, **{name: getattr(scan, name) for name in _SCAN})
