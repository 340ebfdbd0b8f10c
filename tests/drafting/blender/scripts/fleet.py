import itertools
import math
from collections import defaultdict, namedtuple
from functools import partial

import bpy

Vehicle = namedtuple("Vehicle", ["name", "length", "width", "height"])
FLEET = {
    "sedan": Vehicle("Car", 4.6, 1.8, 1.45),
    "suv": Vehicle("Car", 4.8, 1.95, 1.75),
    "truck": Vehicle("Truck", 9.0, 2.5, 3.5),
}
counts = defaultdict(int)
add_cube = partial(bpy.ops.mesh.primitive_cube_add, size=1)


def spawn(kind, x, y, heading_deg=0):
    v = FLEET[kind]
    counts[v.name] += 1
    add_cube(location=(x, y, v.height * 0.5))
    o = bpy.context.active_object
    o.name = f"{v.name}_{counts[v.name]}"
    o.scale = (v.length, v.width, v.height)
    o.rotation_euler = (0, 0, math.radians(heading_deg))


for (kind, x), y in itertools.product(zip(["sedan", "suv", "truck"], itertools.count(10, 12)), (-1.8, 1.8)):
    spawn(kind, x, y, 180 if y > 0 else 0)
