"""Cars: hatchbacks to vans, with bonnet, pillars, roof, wheels in arches, mirrors, plates and what is behind glass.

Lengths, widths and heights are those of common models of each segment of the German Federal Motor Transport Authority
(KBA): VW up and Polo, Golf, Passat, Tiguan, Touran, Land Rover Defender, BMW 4, Ford Ranger, VW Transporter, Mercedes
Sprinter. Wheels are 0.58 to 0.78 m (tyre sizes 165/65 R14 to 265/60 R18, ETRTO).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.car_bodies import VehicleBody, add_glazing, body_mesh, wheel_meshes
from lidardraft.objects.mesh import box, join, quads
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import Primitive

_THREE = ((0.05, 0.30), (0.35, 0.62), (0.66, 0.94))

BODIES: dict[str, VehicleBody] = {
    "city_car": VehicleBody(
        size=(3.60, 1.64, 1.49), cabin=(-0.49, 0.33), roof=(-0.44, 0.14), belt=0.61, nose=0.50, tail=0.60,
        axles=(-0.34, 0.34), wheel=0.58, panes=((0.06, 0.34), (0.40, 0.86)),
    ),
    "hatchback": VehicleBody(
        size=(4.15, 1.77, 1.47), cabin=(-0.48, 0.27), roof=(-0.40, 0.07), belt=0.62, nose=0.50, tail=0.58,
        axles=(-0.31, 0.31), wheel=0.62,
    ),
    "saloon": VehicleBody(
        size=(4.70, 1.83, 1.45), cabin=(-0.37, 0.22), roof=(-0.22, 0.04), belt=0.64, nose=0.51, tail=0.68,
        axles=(-0.29, 0.31), wheel=0.64, slab=0.76,
    ),
    "estate": VehicleBody(
        size=(4.70, 1.83, 1.50), cabin=(-0.49, 0.21), roof=(-0.43, 0.04), belt=0.62, nose=0.50, tail=0.58,
        axles=(-0.29, 0.31), wheel=0.64, panes=_THREE,
    ),
    "suv": VehicleBody(
        size=(4.50, 1.85, 1.67), cabin=(-0.485, 0.26), roof=(-0.42, 0.09), belt=0.62, nose=0.55, tail=0.60,
        axles=(-0.30, 0.31), wheel=0.70, clearance=0.22,
    ),
    "off_roader": VehicleBody(
        size=(4.60, 1.92, 1.90), cabin=(-0.49, 0.21), roof=(-0.48, 0.14), belt=0.60, nose=0.56, tail=0.60,
        axles=(-0.29, 0.33), wheel=0.78, clearance=0.26, slab=0.88, panes=_THREE, round=0.06,
    ),
    "minivan": VehicleBody(
        size=(4.55, 1.83, 1.68), cabin=(-0.49, 0.35), roof=(-0.45, 0.13), belt=0.57, nose=0.46, tail=0.56,
        axles=(-0.30, 0.31), wheel=0.65, panes=_THREE,
    ),
    "coupe": VehicleBody(
        size=(4.55, 1.82, 1.36), cabin=(-0.41, 0.20), roof=(-0.19, -0.01), belt=0.65, nose=0.51, tail=0.69,
        axles=(-0.30, 0.32), wheel=0.66, clearance=0.15, slab=0.74, panes=((0.30, 0.90),),
    ),
    "pickup": VehicleBody(
        size=(5.30, 1.90, 1.82), cabin=(-0.12, 0.26), roof=(-0.09, 0.10), belt=0.60, nose=0.56, tail=0.58,
        axles=(-0.29, 0.32), wheel=0.76, clearance=0.28, round=0.08,
    ),
    "van": VehicleBody(
        size=(5.10, 1.92, 1.97), cabin=(-0.50, 0.38), roof=(-0.49, 0.19), belt=0.52, nose=0.46, tail=0.52,
        axles=(-0.29, 0.31), wheel=0.66, slab=0.88, panes=((0.74, 0.95),),
        back=((0.08, 0.47), (0.53, 0.92)), round=0.08,
    ),
    "large_van": VehicleBody(
        size=(5.95, 2.02, 2.62), cabin=(-0.50, 0.41), roof=(-0.495, 0.24), belt=0.42, nose=0.37, tail=0.42,
        axles=(-0.30, 0.32), wheel=0.70, slab=0.90, panes=((0.80, 0.96),), back=(), rise=(0.06, 0.62), round=0.08,
    ),
}  # fmt: skip
# Segments of the stock of cars in Germany, rounded (KBA, FZ 12), and vans up to 3.5 t among them.
SHARES = {
    "city_car": 0.07,
    "hatchback": 0.34,
    "saloon": 0.09,
    "estate": 0.12,
    "suv": 0.16,
    "off_roader": 0.02,
    "minivan": 0.08,
    "coupe": 0.02,
    "pickup": 0.01,
    "van": 0.05,
    "large_van": 0.04,
}


def sample_car(rng: np.random.Generator) -> tuple[str, tuple[float, float, float]]:
    """The name of a body and the extents of one car of it [m]."""
    name = str(rng.choice(list(SHARES), p=list(SHARES.values())))
    spread = np.clip(rng.normal(0.0, (0.035, 0.015, 0.02)), (-0.1, -0.04, -0.05), (0.1, 0.04, 0.05))
    length, width, height = np.array(BODIES[name].size) * (1.0 + spread)
    return name, (float(length), float(width), float(height))


def sample_paint(rng: np.random.Generator) -> str:
    """The lacquer of a vehicle, bright, dark or between, a third each.

    Of new cars in Germany 30 % are grey or silver, 26 % black, 21 % white, the others coloured (KBA, by colour, 2022).
    """
    return ("light-paint", "dark-paint", "mid-paint")[int(np.searchsorted((0.34, 0.67), rng.random()))]


def car(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A car, its body named by `thing.kind`; mirrors stick out of its extents by 0.1 m."""
    body = BODIES[placed.kind]
    builder = ObjectBuilder(placed)
    builder.add_mesh(body_mesh(body), placed.size, "car", sample_paint(rng))
    add_glazing(builder, body, placed.size, "car")
    tyres, rims = wheel_meshes(body)
    seats, trim, plates = _fittings(body)
    for mesh, material in (
        (tyres, "rubber"),
        (rims, "metal"),
        (seats, "dark-cloth"),
        (trim, "plastic"),
        (plates, "retroreflector"),
    ):
        builder.add_mesh(mesh, placed.size, "car", material)
    return builder.primitives


@lru_cache(maxsize=32)
def _fittings(body: VehicleBody) -> tuple[MeshTemplate, MeshTemplate, MeshTemplate]:
    """Seats; grille, bumper and mirrors; number plates and rear reflectors."""
    length, width, height = body.size
    rear, front = body.cabin
    base = min((body.wheel / 2 + 0.05) / height, 0.9 * body.belt)
    rows = [front - 0.42 * 2.4 / length] + ([rear + 0.14] if front - rear > 0.5 and len(body.panes) > 1 else [])
    backs = [_across(x, side * 0.2, 0.27, base, 0.86) for x in rows for side in (-1, 1)]
    deep = 0.13 / length  # half of what is seen of a seat from the side
    backs += [
        np.array([[(x - deep, y, base), (x + deep, y, base), (x + deep, y, 0.82), (x - deep, y, 0.82)]])
        for x in rows
        for y in (-0.2, 0.2)
    ]
    dash = _across(front - 0.12, 0.0, 0.8, base, body.belt)
    out = 0.5 + 0.01 / length

    def panel(x: float, y: float, z: float, wide: float, tall: float) -> np.ndarray:
        half = tall / height / 2
        return _across(x, y, wide / width, z - half, z + half)

    sill = body.clearance / height
    grille = [panel(out, 0.0, 0.5 * (0.85 * body.nose + sill + 0.06), 0.55 * width, 0.2 * height),
              panel(-out, 0.0, sill + 0.1, 0.8 * width, 0.12)]  # fmt: skip
    # EU number plate, 520 x 113 mm; reflectors at the rear are required by UN Regulation 48
    ends = [panel(out + 0.01 / length, 0.0, sill + 0.16, 0.52, 0.113),
            panel(-out - 0.01 / length, 0.0, 0.5 * (body.tail + sill), 0.52, 0.113)]  # fmt: skip
    ends += [panel(-out, side * 0.38, 0.86 * body.tail, 0.12, 0.1) for side in (-1, 1)]
    # housings at the foot of the windscreen, 0.16 m wide
    at = front - 0.05
    ears = [box((at, side * (0.47 + 0.09 / width), body.belt + 0.06), (0.12 / length, 0.18 / width, 0.13 / height))
            for side in (-1, 1)]  # fmt: skip
    return (
        MeshTemplate.from_triangles(*quads(np.concatenate([*backs, dash]))),
        MeshTemplate.from_triangles(*join(quads(np.concatenate(grille)), *ears)),
        MeshTemplate.from_triangles(*quads(np.concatenate(ends))),
    )


def _across(x: float, y: float, width: float, low: float, high: float) -> np.ndarray:
    """An upright rectangle [1, 4, 3] that faces forward and back."""
    a, b = y - width / 2, y + width / 2
    return np.array([[(x, a, low), (x, b, low), (x, b, high), (x, a, high)]])
