import logging
import sys
from contextlib import suppress

import bpy

log = logging.getLogger("street")
log.setLevel(logging.DEBUG)


def ensure_collection(name, parent=None):
    parent = parent or bpy.context.scene.collection
    try:
        coll = bpy.data.collections[name]
    except KeyError:
        coll = bpy.data.collections.new(name)
        parent.children.link(coll)
        log.debug("created collection %s", name)
    return coll


def move_to(obj, coll):
    for c in obj.users_collection:
        c.objects.unlink(obj)
    coll.objects.link(obj)


def cube(name, loc, dims, coll):
    if any(d <= 0 for d in dims):
        raise ValueError(f"bad dims for {name}: {dims}")
    bpy.ops.mesh.primitive_cube_add(size=1, location=loc)
    o = bpy.context.view_layer.objects.active
    o.name = name
    o.dimensions = dims
    bpy.context.view_layer.update()
    move_to(o, coll)
    return o


def main():
    with suppress(RuntimeError):
        bpy.ops.object.mode_set(mode="OBJECT")
    for o in list(bpy.context.scene.objects):
        bpy.data.objects.remove(o, do_unlink=True)
    vehicles = ensure_collection("Vehicles")
    static = ensure_collection("Static")
    trees = ensure_collection("Vegetation", parent=static)
    assert vehicles is not None
    try:
        cube("Car_A", (9, -1.8, 0.75), (4.4, 1.8, 1.5), vehicles)
        cube("Car_B", (21, 1.8, 0.75), (4.4, 1.8, 1.5), vehicles)
        cube("Wall", (0, -6, 1), (60, 0.3, 2), static)
        cube("Hedge", (0, 6, 0.6), (60, 1, 1.2), trees)
        cube("Broken", (0, 0, 0), (0, 1, 1), static)
    except ValueError as exc:
        log.warning("skipped: %s", exc)
    finally:
        log.info("done")


if __name__ == "__main__":
    try:
        main()
    except Exception as e:
        print("failed:", e)
        sys.exit(1)
