import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import bpy


@dataclass(frozen=True)
class Pose:
    x: float
    y: float
    yaw: float = 0.0


class Asset(ABC):
    prefix = "asset"
    _count = 0

    def __init__(self, pose):
        self.pose = pose
        type(self)._count += 1
        self.name = f"{self.prefix}_{type(self)._count:02d}"

    @abstractmethod
    def create(self): ...

    def _cube(self, dx, dy, dz, z=0.0):
        bpy.ops.mesh.primitive_cube_add(
            size=1, location=(self.pose.x, self.pose.y, z + dz / 2), rotation=(0, 0, self.pose.yaw)
        )
        o = bpy.context.active_object
        o.scale = (dx, dy, dz)
        o.name = self.name
        return o


class Car(Asset):
    prefix = "car"

    def create(self):
        return self._cube(4.4, 1.8, 1.5)


class Building(Asset):
    prefix = "building"

    def __init__(self, pose, height=10):
        super().__init__(pose)
        self.height = height

    def create(self):
        return self._cube(12, 9, self.height)


class Tree(Asset):
    prefix = "tree"

    def create(self):
        p = self.pose
        bpy.ops.mesh.primitive_cylinder_add(radius=0.2, depth=2, location=(p.x, p.y, 1))
        bpy.context.active_object.name = self.name + "_trunk"
        bpy.ops.mesh.primitive_uv_sphere_add(radius=1.4, location=(p.x, p.y, 3))
        bpy.context.active_object.name = self.name + "_crown"


def assets():
    for x in (5, 15, 25):
        yield Car(Pose(x, -1.8))
        yield Car(Pose(x + 4, 1.8, math.pi))
    for x in range(-20, 41, 20):
        yield Building(Pose(x, 15), height=8 + abs(x) / 4)
        yield Tree(Pose(x + 10, 6))


bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
for a in assets():
    a.create()
