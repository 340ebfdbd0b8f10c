"""The things of a world: their shapes as given and as built, at home and at any other place.

Details, brightness and free paths follow from the seed, the ids and the original layout of a thing, which is never
changed. So a thing looks the same in any place, also while other things come and go.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from lidardraft.scene.bodies import Bodies
from lidardraft.scene.box import Box
from lidardraft.scene.check import EGO
from lidardraft.scene.layout import Layout, Primitive, box_around, object_of
from lidardraft.scene.pose import inverse, point_at, upright
from lidardraft.semantics import BY_NAME, GROUND
from lidardraft.simulation.detail.detail import detail
from lidardraft.simulation.detail.fitting import changed
from lidardraft.simulation.motion.driver import Body
from lidardraft.simulation.motion.motions import Ground
from lidardraft.simulation.motion.tracks import EGO_BODY, bodies_of
from lidardraft.simulation.on_relief import both_on_relief, on_relief
from lidardraft.simulation.sweeps import Spot


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """All shapes of one name: its `parts` as given, and its `bodies`, detailed and compiled. `home` is the original
    spot of the middle of its box; others collide with its `body`."""

    parts: tuple[Primitive, ...]
    bodies: Bodies
    body: Body
    is_ground: bool

    @property
    def home(self) -> Spot:
        """The original spot of its middle."""
        return self.body.place

    def parts_at(self, spot: Spot) -> tuple[Primitive, ...]:
        """Its parts with its middle at a spot."""
        if spot == self.home:
            return self.parts
        up, turn = spot[2] - self.home[2], spot[3] - self.home[3]
        moved = []
        for part in self.parts:
            x, y = self._moved(part.center[0], part.center[1], spot)
            moved.append(changed(part, center=(x, y, part.center[2] + up), yaw=part.yaw + turn))
        return tuple(moved)

    def body_at(self, spot: Spot) -> Body:
        """Its body at a spot."""
        if spot == self.home:
            return self.body
        up, turn = spot[2] - self.home[2], spot[3] - self.home[3]
        cos, sin = math.cos(turn), math.sin(turn)
        solids = []
        for solid in self.body.solids:
            x, y = self._moved(solid.x, solid.y, spot)
            looks = (solid.cos * cos - solid.sin * sin, solid.sin * cos + solid.cos * sin)
            bottom, top = solid.bottom + up, solid.top + up
            solids.append(solid._replace(x=x, y=y, cos=looks[0], sin=looks[1], bottom=bottom, top=top))
        return dataclasses.replace(self.body, place=spot, solids=tuple(solids))

    def bodies_at(self, spot: Spot) -> Bodies:
        """Its compiled bodies at a spot."""
        if spot == self.home:
            return self.bodies
        return self.bodies.moved(upright(spot[:3], spot[3]) @ inverse(upright(self.home[:3], self.home[3])))

    def boxes_at(self, spot: Spot, velocity: tuple[float, float, float]) -> list[Box]:
        """One box for each instance."""
        parts: dict[int, list[Primitive]] = {}
        for part in self.parts_at(spot):
            if part.instance and BY_NAME[part.label].is_thing:
                parts.setdefault(part.instance, []).append(part)
        return [box_around(some).moving(velocity) for some in parts.values()]

    def _moved(self, x: float, y: float, spot: Spot) -> tuple[float, float]:
        return point_at((spot[0], spot[1], spot[3] - self.home[3]), x - self.home[0], y - self.home[1])


EGO_THING = Thing(
    (EGO,),
    Bodies.of(Layout()),
    EGO_BODY,
    False,
)


Origin = tuple[float, float, float]


def built(
    layout: Layout, seed: int, wetness: float, base: Layout | None = None, origin: Origin | None = None
) -> dict[str, Thing]:
    """The things of a layout on its relief, by name; a layout that is added to a `base` uses the roads of that. All are
    compiled around `origin` [m], by default their middle."""
    layout, scene = both_on_relief(layout, partial(detail, seed=seed, around=base))
    whole = Bodies.of(scene, wetness)
    given, own = dict[str, list[Primitive]](), dict[str, list[int]]()
    for part in layout:
        given.setdefault(object_of(part), []).append(part)
    for number, part in enumerate(scene):
        own.setdefault(object_of(part), []).append(number)
    around = origin or whole.origin
    standing = {name: [part for part in parts if part.label not in GROUND] for name, parts in given.items()}
    solid = bodies_of(
        {name: parts for name, parts in standing.items() if parts}, Ground(on_relief(base) if base else layout)
    )
    things = {}
    for name, parts in given.items():
        body = solid[name] if name in solid else _bare(name, parts)
        bodies = whole.some(own.get(name, []), around)
        things[name] = Thing(tuple(parts), bodies, body, len(standing[name]) < len(parts))
    return things


def _bare(name: str, parts: Sequence[Primitive]) -> Body:
    """The body of ground, without solids to collide with."""
    box = box_around(parts)
    return Body(name, frozenset(), (*box.center, box.yaw), box.size, ())
