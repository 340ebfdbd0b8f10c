"""Cars: hatchbacks to vans, with bonnet, pillars, roof, wheels in arches, mirrors, plates and the cabin behind glass.

Lengths, widths and heights are those of common models of each segment of the German Federal Motor Transport Authority
(KBA): VW up and Polo, Golf, Passat, Tiguan, Touran, Land Rover Defender, BMW 4, Ford Ranger, VW Transporter, Mercedes
Sprinter. Wheels are 0.58 to 0.78 m (tyre sizes 165/65 R14 to 265/60 R18, ETRTO).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, box, join, quads
from lidardraft.objects.object_builder import ObjectBuilder, sample_name
from lidardraft.objects.placed_object import Vector
from lidardraft.objects.vehicle_bodies import PLATE, VehicleBody, add_glazing, body_mesh, wheel_meshes

_THREE = ((0.05, 0.30), (0.35, 0.62), (0.66, 0.94))

BODIES: dict[str, VehicleBody] = {
    "city_car": VehicleBody(
        size=(3.60, 1.64, 1.49), cabin=(-0.49, 0.33), roof=(-0.44, 0.14), belt_line=0.61, nose=0.50, tail=0.60,
        axles=(-0.34, 0.34), wheel_diameter=0.58, side_windows=((0.06, 0.34), (0.40, 0.86)),
    ),
    "hatchback": VehicleBody(
        size=(4.15, 1.77, 1.47), cabin=(-0.48, 0.27), roof=(-0.40, 0.07), belt_line=0.62, nose=0.50, tail=0.58,
        axles=(-0.31, 0.31), wheel_diameter=0.62,
    ),
    "saloon": VehicleBody(
        size=(4.70, 1.83, 1.45), cabin=(-0.37, 0.22), roof=(-0.22, 0.04), belt_line=0.64, nose=0.51, tail=0.68,
        axles=(-0.29, 0.31), wheel_diameter=0.64, roof_width=0.76,
    ),
    "estate": VehicleBody(
        size=(4.70, 1.83, 1.50), cabin=(-0.49, 0.21), roof=(-0.43, 0.04), belt_line=0.62, nose=0.50, tail=0.58,
        axles=(-0.29, 0.31), wheel_diameter=0.64, side_windows=_THREE,
    ),
    "suv": VehicleBody(
        size=(4.50, 1.85, 1.67), cabin=(-0.485, 0.26), roof=(-0.42, 0.09), belt_line=0.62, nose=0.55, tail=0.60,
        axles=(-0.30, 0.31), wheel_diameter=0.70, clearance=0.22,
    ),
    "off_roader": VehicleBody(
        size=(4.60, 1.92, 1.90), cabin=(-0.49, 0.21), roof=(-0.48, 0.14), belt_line=0.60, nose=0.56, tail=0.60,
        axles=(-0.29, 0.33), wheel_diameter=0.78, clearance=0.26, roof_width=0.88, side_windows=_THREE, taper=0.06,
    ),
    "minivan": VehicleBody(
        size=(4.55, 1.83, 1.68), cabin=(-0.49, 0.35), roof=(-0.45, 0.13), belt_line=0.57, nose=0.46, tail=0.56,
        axles=(-0.30, 0.31), wheel_diameter=0.65, side_windows=_THREE,
    ),
    "coupe": VehicleBody(
        size=(4.55, 1.82, 1.36), cabin=(-0.41, 0.20), roof=(-0.19, -0.01), belt_line=0.65, nose=0.51, tail=0.69,
        axles=(-0.30, 0.32), wheel_diameter=0.66, clearance=0.15, roof_width=0.74, side_windows=((0.30, 0.90),),
    ),
    "pickup": VehicleBody(
        size=(5.30, 1.90, 1.82), cabin=(-0.12, 0.26), roof=(-0.09, 0.10), belt_line=0.60, nose=0.56, tail=0.58,
        axles=(-0.29, 0.32), wheel_diameter=0.76, clearance=0.28, taper=0.08,
    ),
    "van": VehicleBody(
        size=(5.10, 1.92, 1.97), cabin=(-0.50, 0.38), roof=(-0.49, 0.19), belt_line=0.52, nose=0.46, tail=0.52,
        axles=(-0.29, 0.31), wheel_diameter=0.66, roof_width=0.88, side_windows=((0.74, 0.95),),
        rear_windows=((0.08, 0.47), (0.53, 0.92)), taper=0.08,
    ),
    "large_van": VehicleBody(
        size=(5.95, 2.02, 2.62), cabin=(-0.50, 0.41), roof=(-0.495, 0.24), belt_line=0.42, nose=0.37, tail=0.42,
        axles=(-0.30, 0.32), wheel_diameter=0.70, roof_width=0.90, side_windows=((0.80, 0.96),), rear_windows=(),
        window_rise=(0.06, 0.62), taper=0.08,
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


# The spread of length, width and height of cars of one body: deviation and limit, in shares; estimates.
_SPREAD, _MOST_SPREAD = (0.035, 0.015, 0.02), (0.1, 0.04, 0.05)
# Lacquers. Of new cars in Germany 30 % are grey or silver, 26 % black, 21 % white, the others coloured (KBA, by colour,
# 2022): white and light silver are light, black and dark grey dark, and half of the coloured ones. PandaSet's cars read
# (quartiles) 0, 1 to 2 and 3 to 9 of 255 within 20 m; with half of the coloured ones dark, streets have 0, 3 and 8,
# with two fifths 0, 4 and 12.
PAINTS, _PAINT_LIMITS = ("light-paint", "dark-paint", "mid-paint"), (0.2, 0.7)


@dataclass(frozen=True, slots=True)
class _Fittings:
    """The fittings of a body: in metres, or in shares of the vehicle if the comment says so. Estimates.

    Rear reflectors are required by UN Regulation 48; mirrors are housings at the foot of the windscreen.
    """

    seats_behind_screen: float = 0.42 * 2.4  # from the foot of the windscreen to the first row
    rear_seats: float = 0.14  # share of the length, from the foot of the rear window
    two_rows: float = 0.5  # share of the length: longer cabins have two rows
    seat_apart: float = 0.2  # share of the width, from the middle
    seat_width: float = 0.27  # share of the width
    seat_half_depth: float = 0.13  # half the depth of a seat, seen from the side
    seat_base: tuple[float, float] = (0.05, 0.9)  # over the axle; share of the belt line at most
    seat_top: tuple[float, float] = (0.86, 0.82)  # shares of the height, of backs and of their sides
    dashboard: tuple[float, float] = (0.12, 0.8)  # shares: behind the foot of the windscreen; of the width
    proud: float = 0.01  # of grilles over the ends, and of plates over grilles
    grille: tuple[float, float] = (0.55, 0.2)  # shares of width and height
    nose_edge: float = 0.85  # of `VehicleBody.nose`, the front edge of the bonnet
    grille_foot: float = 0.06  # share of the height, over the sill
    bumper: tuple[float, float] = (0.8, 0.12)  # share of the width; height
    bumper_rise: float = 0.1  # share of the height, over the sill
    front_plate_rise: float = 0.16  # share of the height, over the sill
    reflector: tuple[float, float] = (0.12, 0.1)  # width and height
    reflector_at: tuple[float, float] = (0.38, 0.86)  # shares: of the width, from the middle; of the tail's height
    mirror: Vector = (0.12, 0.18, 0.13)
    mirror_at: Vector = (0.05, 0.47, 0.06)  # shares: behind the windscreen's foot; of the width; over the belt line


_FITTINGS = _Fittings()


def sample_car(rng: np.random.Generator) -> tuple[str, Vector]:
    """The name of a random body and the extents of one such car [m]."""
    name = sample_name(SHARES, rng)
    most = np.array(_MOST_SPREAD)
    length, width, height = np.array(BODIES[name].size) * (1.0 + np.clip(rng.normal(0.0, _SPREAD), -most, most))
    return name, (float(length), float(width), float(height))


def sample_paint(rng: np.random.Generator) -> str:
    """The material of a vehicle's lacquer."""
    return PAINTS[int(np.searchsorted(_PAINT_LIMITS, rng.random()))]


def car(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A car of the body of its kind; mirrors extend beyond its extents by 0.1 m."""
    body = BODIES[builder.placed.kind]
    builder.add_mesh(body_mesh(body), builder.placed.size, "car", sample_paint(rng))
    add_glazing(builder, body, builder.placed.size, "car")
    tyres, rims = wheel_meshes(body)
    for mesh, material in (
        (tyres, "rubber"),
        (rims, "metal"),
        (_seats(body), "dark-cloth"),
        (_trim(body), "plastic"),
        (_reflectors(body), "retroreflector"),
    ):
        builder.add_mesh(mesh, builder.placed.size, "car", material)


@lru_cache(maxsize=32)
def _seats(body: VehicleBody) -> MeshTemplate:
    """Backs and sides of seats, and a dashboard."""
    fit = _FITTINGS
    length, _, height = body.size
    rear, front = body.cabin
    over, most = fit.seat_base
    base = min((body.wheel_diameter / 2 + over) / height, most * body.belt_line)
    rows = [front - fit.seats_behind_screen / length]
    if front - rear > fit.two_rows and len(body.side_windows) > 1:
        rows.append(rear + fit.rear_seats)
    back, side_top = fit.seat_top
    sheets = [_across(x, side * fit.seat_apart, fit.seat_width, base, back) for x in rows for side in (-1, 1)]
    deep = fit.seat_half_depth / length
    sheets += [
        np.array([[(x - deep, y, base), (x + deep, y, base), (x + deep, y, side_top), (x - deep, y, side_top)]])
        for x in rows
        for y in (-fit.seat_apart, fit.seat_apart)
    ]
    behind, wide = fit.dashboard
    sheets.append(_across(front - behind, 0.0, wide, base, body.belt_line))
    return MeshTemplate.from_triangles(*quads(np.concatenate(sheets)))


@lru_cache(maxsize=32)
def _trim(body: VehicleBody) -> MeshTemplate:
    """Grille, bumper and mirrors."""
    fit = _FITTINGS
    length, width, height = body.size
    sill, out = body.clearance / height, 0.5 + fit.proud / length
    middle = 0.5 * (fit.nose_edge * body.nose + sill + fit.grille_foot)
    panels = [
        _panel(body, out, 0.0, middle, fit.grille[0] * width, fit.grille[1] * height),
        _panel(body, -out, 0.0, sill + fit.bumper_rise, fit.bumper[0] * width, fit.bumper[1]),
    ]
    behind, beside, over = fit.mirror_at
    long, wide, tall = fit.mirror
    at = body.cabin[1] - behind
    mirrors = [
        box(
            (at, side * (beside + wide / 2 / width), body.belt_line + over),
            (long / length, wide / width, tall / height),
        )
        for side in (-1, 1)
    ]
    return MeshTemplate.from_triangles(*join(quads(np.concatenate(panels)), *mirrors))


@lru_cache(maxsize=32)
def _reflectors(body: VehicleBody) -> MeshTemplate:
    """Number plates, and reflectors at the rear."""
    fit = _FITTINGS
    length, _, height = body.size
    sill, out = body.clearance / height, 0.5 + fit.proud / length
    beside, up = fit.reflector_at
    panels = [
        _panel(body, out + fit.proud / length, 0.0, sill + fit.front_plate_rise, *PLATE),
        _panel(body, -out - fit.proud / length, 0.0, 0.5 * (body.tail + sill), *PLATE),
        *(_panel(body, -out, side * beside, up * body.tail, *fit.reflector) for side in (-1, 1)),
    ]
    return MeshTemplate.from_triangles(*quads(np.concatenate(panels)))


def _panel(body: VehicleBody, x: float, y: float, z: float, wide: float, tall: float) -> np.ndarray:
    """An upright rectangle [1, 4, 3] with that width and height [m], its middle given in shares of the body."""
    _, width, height = body.size
    half = tall / height / 2
    return _across(x, y, wide / width, z - half, z + half)


def _across(x: float, y: float, width: float, low: float, high: float) -> np.ndarray:
    """An upright rectangle [1, 4, 3] that faces forward and back."""
    a, b = y - width / 2, y + width / 2
    return np.array([[(x, a, low), (x, b, low), (x, b, high), (x, a, high)]])
