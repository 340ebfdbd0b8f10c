"""Traffic that one believes: drives along streets, and junctions of sentences, whose movers are held against rules.

    python benches/traffic_checks.py [--drives 30] [--frames 100] [--sentences 20]

Of each drive of `frames` at 10 Hz: collisions of those that move with each other and with what stands; corners of
vehicles over a sidewalk, beyond where they began; steps that differ from the mean velocity at both of their ends by
more than 0.02 m; the share of time in which each class stands (below 0.2 m/s); how far the ego vehicle drives; and the
seconds of processor time of `tracks_of`.
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
from lidardraft.scene.scenario import Scenario
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
        shapes = as_boxes(street.coarse, BoxStyle(relief=True), pose)
        layout = street.with_roads(shapes.layout({}, intent=street.scene.intent), pose, relief=True)
        yield f"street {number} ({street.district})", layout


def sentences(count: int) -> Iterator[tuple[str, Layout]]:
    """Junctions of sentences in their streets."""
    for seed, sentence in itertools.islice(itertools.product(itertools.count(), SENTENCES), count):
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


def faults(tracks: Tracks, bodies: dict[str, Body], times: np.ndarray, ground: Ground) -> list[str]:
    """All that nobody would believe, a line each."""
    found = collisions(tracks, bodies, times)
    for name, track in {"ego": tracks.ego, **tracks.actors}.items():
        places, drives = track.at(times), name == "ego" or bodies[name].labels & set(VEHICLE_LABELS)
        if (off := jump(places)) > JUMP:
            found.append(f"{name} jumps {off:.3f} m")
        if drives and on_sidewalk(bodies[name], places, ground):
            found.append(f"{name} on a sidewalk")
    return found


def main() -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", type=int, default=30)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--sentences", type=int, default=20)
    arguments = parser.parse_args()
    times = np.arange(arguments.frames) / HZ
    stood, driven, spent, count = defaultdict[str, list[float]](list), list[float](), list[float](), 0
    for said, layout in itertools.chain(streets(arguments.drives), sentences(arguments.sentences)):
        begin = time.process_time()
        tracks = tracks_of(layout, Scenario(), times[-1])
        spent.append(time.process_time() - begin)
        bodies = bodies_of(objects(layout), Ground(layout)) | {"ego": EGO_BODY}
        for name, track in {"ego": tracks.ego, **tracks.actors}.items():
            speeds = np.hypot(*np.diff(track.at(times)[:, :2], axis=0).T) * HZ
            kinds = (label for label in ("rider", "person", "bus", "truck", "car") if label in bodies[name].labels)
            stood["ego" if name == "ego" else next(kinds, "other")].append(float((speeds < STANDS).mean()))
        driven.append(float(np.hypot(*np.diff(tracks.ego.at(times)[:, :2], axis=0).T).sum()))
        found = faults(tracks, bodies, times, Ground(layout))
        count += len(found)
        moved = f"{len(tracks.actors) + 1} move, ego {driven[-1]:.0f} m"
        print(f"{said}: {moved}, {spent[-1]:.2f} s", *found, sep="; ", flush=True)
    print(f"faults {count}; ego {median(driven):.0f} m in the median, {sum(one < 5 for one in driven)} under 5 m")
    print("standing:", ", ".join(f"{kind} {np.mean(rows):.0%} of {len(rows)}" for kind, rows in sorted(stood.items())))
    print(f"tracks_of: {sum(spent):.1f} s, {median(spent):.2f} s in the median")


if __name__ == "__main__":
    main()
