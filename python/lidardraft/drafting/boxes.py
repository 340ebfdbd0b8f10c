"""Boxes of objects, from annotators or detectors, become a layout on flat ground."""

from __future__ import annotations

from collections.abc import Sequence

from lidardraft.drafting.plausible import check_sizes, out_of_reach
from lidardraft.errors import LayoutError, check_type
from lidardraft.json_fields import is_number
from lidardraft.scene.box import Box
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import BY_NAME

_MARGIN = 40.0  # m of ground around the boxes and the ego vehicle
_MOST_BOXES = 65_535  # as many as there are instances


def layout_from_boxes(boxes: Sequence[Box], *, sensor_height: float = 0.0, as_is: bool = False) -> Layout:
    """The layout of the boxes, one shape each, on a road under all of them: boxes do not describe the ground.

    The boxes are in the frame of a sensor `sensor_height` [m] over the road; 0 is the layout's frame. Things without an
    instance, or with that of another thing, get a free one. Raises `LayoutError` naming a box without extent or class,
    and one whose size is in another unit than the metre, unless `as_is`; also if there are no boxes.
    """
    check_type("boxes", boxes, Sequence)
    if not is_number(sensor_height):
        raise LayoutError(f"sensor_height is {sensor_height}; it must be a finite number of metres")
    if not 1 <= len(boxes) <= _MOST_BOXES:
        raise LayoutError(f"there are {len(boxes)} boxes; a layout is made of 1 to {_MOST_BOXES}")
    for number, box in enumerate(boxes):
        check_type(f"box {number}", box, Box)
    instances = _instances(boxes)
    standing = tuple(
        Primitive(
            shape="box",
            center=(box.center[0], box.center[1], box.center[2] + sensor_height),
            size=box.size,
            yaw=box.yaw,
            label=box.label,
            id=box.id,
            instance=instance,
        )
        for box, instance in zip(boxes, instances, strict=True)
    )
    layout = Layout(primitives=(_ground(boxes), *standing), provenance={"source": "boxes"})
    if not as_is:
        check_sizes(layout, scales="")
    return layout.noted(*out_of_reach(layout, "boxes are read in the frame of the sensor"))


def _instances(boxes: Sequence[Box]) -> list[int]:
    """The instance of each box: its own, unless an earlier box has it, then a free one; 0 for stuff."""
    used = {box.instance for box in boxes}
    free = (number for number in range(1, _MOST_BOXES + 1) if number not in used)
    instances, taken = [], {0}
    for box in boxes:
        if not BY_NAME[box.label].is_thing:
            instances.append(0)
            continue
        instances.append(next(free) if box.instance in taken else box.instance)
        taken.add(instances[-1])
    return instances


def _ground(boxes: Sequence[Box]) -> Primitive:
    id = "ground"
    while any(box.id == id for box in boxes):
        id += "_"
    reach = max(abs(value) for box in boxes for value in box.center[:2]) + _MARGIN
    return Primitive(
        shape="plane", center=(0.0, 0.0, 0.0), size=(2 * reach, 2 * reach, 0.0), label="road", id=id, open=True
    )
