"""A street as a language model writes one: functions, materials, a seeded generator, lights, a camera, an export."""

import math
import random

import bpy

random.seed(42)

# Clear the scene
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete(use_global=False)
for block in bpy.data.meshes:
    if block.users == 0:
        bpy.data.meshes.remove(block)

ROAD_LENGTH, ROAD_WIDTH = 120.0, 8.0


def create_material(name, color):
    material = bpy.data.materials.new(name=name)
    material.use_nodes = True
    bsdf = material.node_tree.nodes.get("Principled BSDF")
    if bsdf:
        bsdf.inputs["Base Color"].default_value = (*color, 1.0)
        bsdf.inputs["Roughness"].default_value = 0.8
    return material


MATERIALS = {
    "road": create_material("Asphalt", (0.05, 0.05, 0.05)),
    "building": create_material("mat_building", (0.6, 0.5, 0.4)),
    "leaves": create_material("Leaves", (0.1, 0.4, 0.1)),
    "bark": create_material("Bark", (0.3, 0.2, 0.1)),
}


def assign(obj, material):
    if obj.data.materials:
        obj.data.materials[0] = material
    else:
        obj.data.materials.append(material)


def create_road():
    bpy.ops.mesh.primitive_plane_add(size=1, location=(0, 0, 0))
    road = bpy.context.active_object
    road.name = "Surface"
    road.scale = (ROAD_LENGTH, ROAD_WIDTH, 1)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    assign(road, MATERIALS["road"])
    for side in (-1, 1):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, side * (ROAD_WIDTH / 2 + 1), 0.075))
        walk = bpy.context.object
        walk.name = f"Sidewalk_{'left' if side > 0 else 'right'}"
        walk.dimensions = (ROAD_LENGTH, 2, 0.15)


def create_car(location, rotation=0.0, name="Car"):
    bpy.ops.mesh.primitive_cube_add(size=1, location=(location[0], location[1], 0.75))
    car = bpy.context.object
    car.name = name
    car.dimensions = (4.5, 1.8, 1.5)
    car.rotation_euler[2] = math.radians(rotation)
    return car


def create_tree(x, y, height=None):
    height = height or random.uniform(4, 7)
    bpy.ops.mesh.primitive_cylinder_add(radius=0.15, depth=height / 2, location=(x, y, height / 4))
    trunk = bpy.context.object
    trunk.name = "Tree_Trunk"
    assign(trunk, MATERIALS["bark"])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=1, location=(x, y, height * 0.7))
    crown = bpy.context.object
    crown.scale = (height / 4, height / 4, height / 3)
    assign(crown, MATERIALS["leaves"])
    bpy.ops.object.shade_smooth()
    return trunk, crown


create_road()
create_car((12, -2), name="Lead_Car")
create_car((-10, -2), rotation=3)
create_car((25, 2), rotation=180)
for i in range(6):
    for side in [-1, 1]:
        create_tree(-40 + i * 16 + random.uniform(-1, 1), side * 7.5)

houses = [(x, side * random.uniform(14, 16)) for x in range(-45, 50, 18) for side in (1, -1)]
for index, (x, y) in enumerate(houses):
    width, depth, height = random.randint(8, 12), random.choice([8, 9, 10]), random.gauss(7, 1)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(x, y, height / 2))
    bpy.context.object.name = "House_%02d" % index  # noqa: UP031
    bpy.context.object.scale = (width, depth, height)
    bpy.context.object.data.materials.append(MATERIALS["building"])

sun = bpy.data.lights.new(name="Sun", type="SUN")
sun.energy = 3.0
sun_object = bpy.data.objects.new("Sun", sun)
bpy.context.collection.objects.link(sun_object)
sun_object.rotation_euler = (math.radians(50), 0, 0.3)
bpy.ops.object.camera_add(location=(0, -30, 20), rotation=(1.1, 0, 0))
bpy.context.scene.camera = bpy.context.object
bpy.context.scene.render.resolution_x = 1920
print(f"{len(bpy.data.objects)} objects")
