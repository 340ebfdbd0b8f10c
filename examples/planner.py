"""A planner in the loop: it sees points, brakes for what is in its lane, and drives on when the way is free.

python examples/planner.py [--seconds 8]
"""

import argparse

import numpy as np

import lidardraft

STEP = 0.1  # s
BRAKING, ACCELERATION = 3.0, 1.5  # m/s2


def free_way(scan: lidardraft.Scan) -> float:
    """How far ahead of the bumper nothing stands between the wheels [m], by the points of a scan alone."""
    x, y, z = scan.points().T
    height = z + scan.image.sensor.mount_height
    ahead = x[(np.abs(y) < 1.3) & (height > 0.3) & (height < 2.2) & (x > 2.3)]
    return float(ahead.min(initial=60.0)) - 2.3


def main() -> None:
    """Drive behind a car that brakes, and print what happens."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0)
    seconds = parser.parse_args().seconds
    sensor = lidardraft.Sensor.preset("vlp16")
    world = lidardraft.World("a car 25 m ahead and a van coming the other way", sensor, seed=3)
    world["car_1"].motion = lidardraft.AlongLane(8.0, later=((2.0, 0.0),))
    speed = 8.0
    for _ in range(round(seconds / STEP)):
        way = free_way(world.scan())
        safe = (2 * BRAKING * max(0.0, way - 3.0)) ** 0.5
        speed = max(0.0, min(speed + ACCELERATION * STEP, safe, 10.0))
        x, y, yaw = world.ego.pose
        world.ego.pose = (x + speed * STEP, y, yaw)
        world.step(STEP)
    gap = world["car_1"].pose[0] - world.ego.pose[0]
    print(f"after {world.time:.1f} s: {speed:.1f} m/s, {gap:.1f} m between the middles, collisions: {world.collisions}")


if __name__ == "__main__":
    main()
