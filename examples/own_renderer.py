"""Casts of your own renderer, of objects that a world moves, become scans with boxes at 10 Hz.

The renderer here meets rays with the boxes of the world and a flat road; put yours in place of `render`.

python examples/own_renderer.py [--seconds 1]
"""

import argparse
import math

import numpy as np

import lidardraft
from lidardraft import Box, Scan, Sensor

CLASS_ID = {row.name: row.id for row in lidardraft.CLASSES}


def render(sensor: Sensor, boxes: list[Box]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth [m], class ids and instances [H, W] of boxes in the frame of the sensor, on a flat road."""
    rays = sensor.pattern.directions()
    origins = sensor.pattern.origins()
    down = np.minimum(rays[..., 2], -1e-9)
    depth = np.where(rays[..., 2] < 0.0, (-sensor.mount_height - origins[..., 2]) / down, np.inf)
    label, instance = np.full(depth.shape, CLASS_ID["road"]), np.zeros(depth.shape, int)
    for box in boxes:
        cos, sin = math.cos(box.yaw), math.sin(box.yaw)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        ray, start = rays @ turn, (origins - box.center) @ turn
        ray = np.where(np.abs(ray) < 1e-12, 1e-12, ray)
        ends = [(side * np.array(box.size) / 2 - start) / ray for side in (-1, 1)]
        enters, leaves = np.minimum(*ends).max(axis=-1), np.maximum(*ends).min(axis=-1)
        hit = (enters > 0.0) & (enters < leaves) & (enters < depth)
        depth[hit], label[hit], instance[hit] = enters[hit], CLASS_ID[box.label], box.instance
    seen = depth < sensor.max_range
    return np.where(seen, depth, 0.0), np.where(seen, label, 0), np.where(seen, instance, 0)


def main() -> None:
    """Step a world, render it, and print what each object gets."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=1.0)
    seconds = parser.parse_args().seconds
    sensor = Sensor.preset("vlp16")
    world = lidardraft.World("a car 15 m ahead and a bus coming the other way 30 m ahead", sensor, seed=1)
    for number in range(round(10 * seconds)):
        world.step(0.1)
        x, y, yaw = world.ego.pose
        pose = sensor.pose(x, y, yaw)
        depth, label, instance = render(sensor, [box.seen_from(pose) for box in world.boxes()])
        image = lidardraft.observe_cast(depth, label, sensor, instance=instance, seed=number)
        scan = Scan(image=image, layout=world.layout(), pose=pose, seed=number, time=world.time)
        returns = {box.id: count for box, count in zip(scan.boxes(), scan.returns_per_box(), strict=True) if count}
        inside = [box.contains(scan.points()[scan.instances() == box.instance], 0.1) for box in scan.boxes()]
        share = np.concatenate(inside).mean()
        print(f"{world.time:.1f} s: {len(scan.labels())} returns, of boxes {returns}, {share:.0%} within")


if __name__ == "__main__":
    main()
