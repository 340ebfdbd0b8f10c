import math
import random

import bpy

random.seed(42)

# Clear existing objects
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete(use_global=False)

for block in bpy.data.meshes:
    if block.users == 0:
        bpy.data.meshes.remove(block)


def make_material(name, color, roughness=0.5, metallic=0.0):
    mat = bpy.data.materials.new(name=name)
    mat.use_nodes = True
    bsdf = mat.node_tree.nodes.get("Principled BSDF")
    if bsdf:
        bsdf.inputs["Base Color"].default_value = (*color, 1.0)
        bsdf.inputs["Roughness"].default_value = roughness
        bsdf.inputs["Metallic"].default_value = metallic
    return mat


ASPHALT = make_material("Asphalt", (0.05, 0.05, 0.05))
CONCRETE = make_material("Concrete", (0.5, 0.5, 0.5))
CAR_COLORS = [(0.8, 0.1, 0.1), (0.1, 0.1, 0.8), (0.9, 0.9, 0.9)]


class Car:
    """A simple car made of two boxes and four wheels."""

    count = 0

    def __init__(self, x, y, yaw=0.0, color=(1, 0, 0)):
        self.x = x
        self.y = y
        self.yaw = yaw
        self.color = color
        Car.count += 1
        self.index = Car.count

    @property
    def name(self):
        return f"Car_{self.index:02d}"

    def build(self):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(self.x, self.y, 0.75))
        body = bpy.context.active_object
        body.name = self.name
        body.scale = (4.2, 1.8, 1.5)
        body.rotation_euler = (0, 0, self.yaw)
        body.data.materials.append(make_material(self.name + "_paint", self.color))
        return body


bpy.ops.mesh.primitive_plane_add(size=1, location=(20, 0, 0))
road = bpy.context.object
road.name = "Road"
road.scale = (100, 8, 1)
road.data.materials.append(ASPHALT)

for i in range(4):
    c = Car(10 + i * 8, random.choice([-2, 2]), math.radians(180) if i % 2 else 0.0, random.choice(CAR_COLORS))
    c.build()

bpy.ops.object.light_add(type="SUN", location=(0, 0, 20))
bpy.context.object.data.energy = 3.0
bpy.ops.object.camera_add(location=(0, -20, 10), rotation=(math.radians(60), 0, 0))
bpy.context.scene.camera = bpy.context.object
