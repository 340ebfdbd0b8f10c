"""What a world costs: steps, scans, a dragged body, boxes and points, as ratios and rates, and the memory it keeps.

python benches/bench_world.py [--sensor hdl64e os1-128] [--steps 10000] [--threads 2]
"""

import argparse
import resource
import time
from collections.abc import Callable
from statistics import median

import numpy as np

import lidardraft
from lidardraft import Sensor, World

SENTENCE = "a busy crossroads with a bus, cyclists and pedestrians"
MOVING = 12  # bodies


def milliseconds(call: Callable[[], object], count: int = 25) -> float:
    """The median of calls."""
    spent = []
    for _ in range(count):
        start = time.perf_counter()
        call()
        spent.append(time.perf_counter() - start)
    return 1e3 * median(spent)


def with_movers(layout: lidardraft.Layout, sensor: Sensor, threads: int | None) -> World:
    """A world in which so many drive or walk, beside the ego vehicle."""
    world = World(layout, sensor, seed=7, threads=threads)
    moving = [name for name, actor in world.state().actors.items() if actor.motion is not None and name != "ego"]
    for name in moving[MOVING:]:
        world[name].motion = None
    world.step(0.2)
    return world


def of_sensor(layout: lidardraft.Layout, name: str, threads: int | None) -> None:
    """Print the rates and ratios of one sensor."""
    sensor = Sensor.preset(name)
    world = with_movers(layout, sensor, threads)
    bodies = sum(bool(actor.past) for name, actor in world.state().actors.items() if name != "ego")
    sweeper, spent = world._sweepers[name], list[tuple[float, ...]]()
    for _ in range(40):
        begin = time.perf_counter()
        world.step(0.1)
        stepped = time.perf_counter()
        scan = world.scan()
        scanned = time.perf_counter()
        assert world._still is not None
        assert world._table is not None
        clean = sweeper.cast(world._still[1], (), scan.poses(), 7)
        cast = time.perf_counter()
        sweeper.observe(clean, world._table[1], np.eye(4), 7)
        observed = time.perf_counter()
        world.cast()
        whole = time.perf_counter() - observed
        spent.append((stepped - begin, scanned - begin, cast - scanned, observed - cast, whole))
    step, both, still, model, whole = (1e3 * median(row) for row in zip(*spent, strict=True))
    print(f"{name}: {len(world.ids)} objects, {bodies} move; the cast by column of what stands takes {still:.1f} ms,")
    print(f"  with the bodies {whole:.1f} ms, the sensor model {model:.1f} ms, a step {step:.1f} ms")
    print(
        f"  step and scan {both:.1f} ms, {1e3 / both:.0f}/s: {both / (whole + model):.2f} x cast with bodies and model,"
    )
    print(f"  {both / (still + model):.2f} x cast of what stands and model")
    for one in world.ids:
        world[one].motion = None
    world.ego.motion = None
    world.step(0.2)
    van, places = world.add("van", at=(8.0, 3.0)), iter(range(10**6))

    def drags() -> None:
        world.move(van, (8.0 + 0.01 * next(places), 3.0))
        world.scan()

    dragged = milliseconds(drags)
    scan = world.scan()
    rest = {"boxes()": world.boxes, "Scan.boxes()": scan.boxes, "Scan.points()": scan.points, "state()": world.state}
    print(f"  one body dragged and scanned {dragged:.1f} ms ({1e3 / dragged:.0f}/s)")
    print("  " + ", ".join(f"{what} {milliseconds(call):.2f} ms" for what, call in rest.items()))


def memory(layout: lidardraft.Layout, steps: int) -> None:
    """Print what the process has grown by after many steps, and after adds and removes."""
    world = World(layout, Sensor.preset("vlp16"), seed=7)

    def peak() -> float:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    for _ in range(20):
        world.step(0.1)
        world.scan()
    begin = peak()
    for number in range(steps):
        world.step(0.1)
        if number % 100 == 0:
            world.scan()
    stepped = peak()
    for number in range(1000):
        world.remove(world.add("van", at=(8.0, 3.0 + 0.01 * (number % 100))))
        if number % 20 == 0:
            world.scan()
    edited = peak()
    print(f"memory {begin:.0f} MB; {steps} steps: +{stepped - begin:.0f} MB", end="; ")
    print(f"1000 adds and removes: +{edited - stepped:.0f} MB")
    print(f"layouts kept: {len(world.state().layouts)}, collisions: {len(world.collisions)}")


def crowd(layout: lidardraft.Layout) -> None:
    """Print what a step takes where many people walk."""
    world = World(layout, Sensor.preset("vlp16"), seed=7)
    rng = np.random.default_rng(0)
    for _ in range(500):
        x, y = rng.uniform((-60, -5), (60, 5)).tolist()
        world.add("person", at=(x, y), speed=1.0)
    print(f"a step with 500 people more: {milliseconds(lambda: world.step(0.1), 5):.0f} ms, scan", end=" ")
    print(f"{milliseconds(lambda: (world.step(0.05), world.scan()), 5):.0f} ms with a step of 0.05 s")


def main() -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sensor", nargs="*", default=["hdl64e", "os1-128"])
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--threads", type=int)
    arguments = parser.parse_args()
    layout = lidardraft.surround(lidardraft.layout_from_text(SENTENCE, seed=7), seed=7)
    for name in arguments.sensor:
        of_sensor(layout, name, arguments.threads)
    crowd(layout)
    if arguments.steps:
        memory(layout, arguments.steps)


if __name__ == "__main__":
    main()
