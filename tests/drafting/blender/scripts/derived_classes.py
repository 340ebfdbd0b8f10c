import time
from enum import Enum

import bpy


class Kind(Enum):
    CAR = 1
    TRUCK = 2


SIZES = {Kind.CAR: (4.5, 1.8, 1.5), Kind.TRUCK: (8.0, 2.5, 3.0)}

start = time.time()


class Vehicle:
    kind = None

    def __init__(self, name, location):
        self.name, self.location = name, location

    def size(self):
        raise NotImplementedError

    def create(self):
        sx, sy, sz = self.size()
        bpy.ops.mesh.primitive_cube_add(size=1, location=(self.location[0], self.location[1], sz / 2))
        ob = bpy.context.object
        ob.name = self.name
        ob.scale = (sx, sy, sz)
        return ob


class Truck(Vehicle):
    kind = Kind.TRUCK

    def size(self):
        return SIZES[self.kind]


class Sedan(Vehicle):
    kind = Kind.CAR

    def __init__(self, name, location, color="red"):
        super().__init__(name, location)
        self.color = color

    def size(self):
        return SIZES[self.kind]


for i, cls in enumerate((Sedan, Truck, Sedan)):
    v = cls(f"{cls.__name__}_{i}", (10 + 12 * i, 0))
    ob = v.create()
    if isinstance(v, Truck):
        ob.name = f"Truck_{i}"
    else:
        ob.name = f"Car_{i}"
print(f"done in {time.time() - start:.2f}s")
