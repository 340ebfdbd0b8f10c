"""Loops, comprehensions, lambdas, closures and random numbers of every kind."""

import math
import random

import bpy
from mathutils import Matrix, Vector

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
random.seed(7)
kinds = [("Car", (4.3, 1.8, 1.5)), ("Bus", (11.0, 2.5, 3.1)), ("Motorcycle", (2.1, 0.8, 1.3))]
weights = {"Car": 6, "Bus": 1, "Motorcycle": 2}
placed = []


def place(kind, size, position, yaw=0.0, **extra):
    bpy.ops.mesh.primitive_cube_add(size=1, location=position)
    obj = bpy.context.object
    obj.name = extra.get("name", kind)
    obj.dimensions = size
    obj.matrix_world = Matrix.Translation(Vector(position)) @ Matrix.Rotation(yaw, 4, "Z") @ Matrix.Diagonal((*size, 1))
    placed.append((kind, obj))
    return obj


def counter(start):
    count = start

    def step():
        nonlocal count
        count += 1
        return count

    return step


following = counter(100)
order = list(range(8))
random.shuffle(order)
radius = 12.0
while radius < 60 and len(placed) < 20:
    for k in order[:3]:
        kind, size = random.choices(kinds, weights=[weights[name] for name, _ in kinds])[0]
        angle = 2 * math.pi * k / 8 + random.gauss(0, 0.05)
        position = (radius * math.cos(angle), radius * math.sin(angle), size[2] / 2)
        place(kind, size, position, yaw=angle + random.triangular(-0.1, 0.1), name=f"{kind}_{following():03d}")
    radius += random.randrange(4, 9)
    if radius > 40:
        break
else:
    place("Car", (4, 2, 1.5), (0, 30, 0.75))

height_at = lambda x, y=0.0: 2 + math.sin(x / 5) * math.exp(-abs(y) / 10)  # noqa: E731
spots = {(x, y) for x in range(-20, 21, 10) for y in (-18, 18) if (x + y) % 4}
for x, y in sorted(spots, key=lambda spot: (spot[1], -spot[0])):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=height_at(x, y), location=(x, y, 3))
    bpy.context.object.name = "{}_{:.0f}".format("Tree", abs(x))
jitter = [round(random.uniform(-1, 1), 3) for _ in range(4)] + random.sample(range(5), 2)
first, *middle, last = jitter
bpy.ops.mesh.primitive_cylinder_add(radius=0.1, depth=4 + abs(first), location=(5 + last, sum(middle) % 3 + 6, 2))
bpy.context.object.name = "Pole"
