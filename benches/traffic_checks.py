"""Traffic that one believes: drives along streets, and junctions of sentences, whose movers are held against rules.

    python benches/traffic_checks.py [--drives 30] [--frames 100] [--sentences 2]

Of drives of `frames` at 10 Hz, and of 20 s of each sentence with some seeds: collisions of those that move with each
other and with what stands; vehicles with corners over a sidewalk, beyond where they began; movers with steps that
differ from the mean velocity at both of their ends by more than 0.02 m; how far the ego vehicle drives, in the median;
and the share of time in which it and the other vehicles that move at all stand (below 0.2 m/s).
"""

import argparse
import itertools
import math
import time
from collections import defaultdict
from collections.abc import Iterator
from statistics import median

import numpy as np

from lidardraft import Layout, layout_from_text, surround
from lidardraft.scene.check import OVERLAP_TOLERANCE, VEHICLE_LABELS, objects
from lidardraft.scene.scenario import Scenario, Track
from lidardraft.scene.solids import penetration
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.motion.driver import Body
from lidardraft.simulation.motion.motions import Ground
from lidardraft.simulation.motion.tracks import EGO_BODY, Tracks, _solid, bodies_of, tracks_of
from lidardraft.streets.coarse.coarse_layout import BoxStyle, as_boxes
from lidardraft.streets.drives import _STREAM, HALF_LENGTH, _start
from lidardraft.streets.street import StreetConfig, make_street

HZ, STANDS, JUMP, INSIDE = 10.0, 0.2, 0.02, 0.1  # 1/s, m/s, m, m from the corner of a box
SENTENCES = (
    "a busy downtown crossroads with pedestrians crossing",
    "a crossroads with a bus, cyclists and pedestrians",
    "a T-junction 30 m ahead with three cars",
    "a crossroads 40 m ahead, two cars ahead, a truck coming the other way",
    "a roundabout 40 m ahead with four cars",
    "a crossroads with traffic lights, five cars and a van",
    "a busy crossroads at rush hour",
    "a residential street with a crossroads 25 m ahead, a car ahead and a cyclist",
    "an avenue with two lanes each way and a crossroads 50 m ahead, ten cars",
    "a T-junction 20 m ahead, a car turns left, pedestrians on the sidewalks",
)


def streets(count: int) -> Iterator[tuple[str, Layout]]:
    """Streets of drives, seen from where their ego vehicles begin."""
    config = StreetConfig(half_length=HALF_LENGTH)
    for number in range(count):
        street = make_street(seed=1, config=config, number=number)
        pose, _ = _start(street, np.random.default_rng([1, number, _STREAM]))
        shapes = as_boxes(street.coarse, BoxStyle(relief=True), pose, reach=math.inf)
        layout = street.with_roads(shapes.layout({}, intent=street.scene.intent), pose, relief=True)
        yield f"street {number} ({street.district})", layout


def sentences(count: int) -> Iterator[tuple[str, Layout]]:
    """Junctions of sentences in their streets."""
    for sentence, seed in itertools.product(SENTENCES, range(count)):
        yield sentence, surround(layout_from_text(sentence, seed=seed), seed=seed)


def collisions(tracks: Tracks, bodies: dict[str, Body], times: np.ndarray) -> list[str]:
    """Who runs into whom, but for those that touch at the start."""
    moving = {"ego": tracks.ego.at(times), **{name: track.at(times) for name, track in tracks.actors.items()}}
    standing = {name: np.array([body.place]) for name, body in bodies.items() if name not in moving}
    pairs = itertools.chain(itertools.combinations(moving, 2), itertools.product(moving, standing))
    found = []
    for one, other in pairs:
        here, there = moving[one], moving.get(other, standing.get(other))
        assert there is not None
        reach = (math.hypot(*bodies[one].size[:2]) + math.hypot(*bodies[other].size[:2])) / 2
        for k in np.flatnonzero(np.hypot(*(here - there)[:, :2].T) < reach).tolist():
            met = bodies[other].solids if other in standing else (_solid(bodies[other], there[k]),)
            if any(penetration(_solid(bodies[one], here[k]), solid) > OVERLAP_TOLERANCE for solid in met):
                if k:
                    found.append(f"{one} and {other} after {times[k]:.1f} s")
                break
    return found


def on_sidewalk(body: Body, places: np.ndarray, ground: Ground) -> int:
    """Of a vehicle's corners at all times, how many are over a sidewalk where its corner was not at first."""
    half = np.array(body.size[:2]) / 2 - INSIDE
    found = 0
    for ahead, left in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        cos, sin = np.cos(places[:, 3]), np.sin(places[:, 3])
        x, y = ahead * half[0], left * half[1]
        corner = places[:, :2] + np.column_stack([x * cos - y * sin, x * sin + y * cos])
        walk = ground.at(corner)[1] == BY_NAME["sidewalk"].id
        found += int(walk.sum()) * (not walk[0])
    return found


def jump(places: np.ndarray) -> float:
    """The largest difference [m] of a step from the mean velocity at its ends."""
    steps = np.diff(places[:, :3], axis=0)
    middle = (steps[:-2] + 2 * steps[1:-1] + steps[2:]) / 4  # of central differences at both ends
    return float(np.linalg.norm(steps[1:-1] - middle, axis=1).max(initial=0.0))


def metres(track: Track, end: float) -> float:
    """How far something goes until `end` [s]."""
    return float(np.hypot(*np.diff(track.at(np.arange(0.0, end, 1 / HZ))[:, :2], axis=0).T).sum())


class Sums:
    """The figures of layouts of one kind, a row of the table."""

    def __init__(self) -> None:
        self.found = np.zeros(4, dtype=int)  # layouts, collisions, vehicles on sidewalks, those that jump
        self.metres, self.stood, self.spent = list[tuple[float, float]](), defaultdict[str, list[float]](list), 0.0

    def add(self, layout: Layout, frames: int) -> list[str]:
        """Add a layout; returns all that nobody would believe, a line each."""
        times, ground, begin = np.arange(frames) / HZ, Ground(layout), time.process_time()
        tracks = tracks_of(layout, Scenario(), times[-1])
        self.spent += time.process_time() - begin
        bodies = bodies_of(objects(layout), ground) | {"ego": EGO_BODY}
        moving = {"ego": tracks.ego, **tracks.actors}
        for name, track in moving.items():
            speeds = np.hypot(*np.diff(track.at(times)[:, :2], axis=0).T) * HZ
            kinds = (label for label in ("rider", "person", "bus", "truck", "car") if label in bodies[name].labels)
            self.stood["ego" if name == "ego" else next(kinds, "other")].append(float((speeds < STANDS).mean()))
        drives = [name for name in moving if name == "ego" or bodies[name].labels & set(VEHICLE_LABELS)]
        hits = collisions(tracks, bodies, times)
        off = [name for name in drives if on_sidewalk(bodies[name], moving[name].at(times), ground)]
        starts = [name for name, track in moving.items() if jump(track.at(times)) > JUMP]
        self.found += (1, len(hits), len(off), len(starts))
        self.metres.append((metres(tracks.ego, 6.0), metres(tracks.ego, times[-1])))
        return hits + [f"{name} on a sidewalk" for name in off] + [f"{name} jumps" for name in starts]

    def row(self, said: str) -> str:
        """The row of the table."""
        six, all_of_it = (median(column) for column in zip(*self.metres, strict=True))
        vehicles = [share for kind in ("car", "truck", "bus") for share in self.stood[kind]]
        stands = (np.mean(self.stood["ego"]), np.mean(vehicles) if vehicles else math.nan)
        cells = (said, *self.found.tolist(), f"{six:.1f}", f"{all_of_it:.1f}")
        return "| " + " | ".join(map(str, (*cells, *(f"{share:.0%}" for share in stands)))) + " |"


def main() -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", type=int, default=30)
    parser.add_argument("--frames", type=int, default=100, help="of drives")
    parser.add_argument("--sentences", type=int, default=2, help="seeds of each sentence, 20 s each")
    arguments = parser.parse_args()
    rows = defaultdict[str, Sums](Sums)
    for name, layout in streets(arguments.drives):
        print(name, *rows["streets"].add(layout, arguments.frames), sep="; ", flush=True)
    for sentence, layout in sentences(arguments.sentences):
        print(sentence, *rows[sentence].add(layout, 200), sep="; ", flush=True)
    print("\n| | layouts | collisions | on sidewalks | jumps | ego m, 6 s | all | ego stands | vehicles stand |")
    print("|---|" + "---:|" * 8)
    for said, sums in rows.items():
        print(sums.row(said))
    print(f"\ntracks_of: {sum(one.spent for one in rows.values()):.0f} s")


if __name__ == "__main__":
    main()
