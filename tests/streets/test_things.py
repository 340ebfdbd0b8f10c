"""Every kind of thing, built alone: within its extents, on the ground, of the right classes, the same each time."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import CLASSES, Layout, Primitive, Raycaster
from lidardraft.objects.buildings import BALCONY, EAVES, STOREY
from lidardraft.objects.cars import BODIES, SHARES, sample_car
from lidardraft.objects.kinds import KINDS, kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.objects.vehicle_bodies import VehicleBody
from lidardraft.scene.mesh import primitive_mesh

# Extents [m] and clearance of each kind, smallest and largest.
SIZES: dict[str, tuple[tuple[float, float, float, float], ...]] = {
    **{name: ((*body.size, 0.0),) for name, body in BODIES.items()},
    "truck": ((5.5, 2.1, 2.6, 0), (7.5, 2.3, 3.0, 0), (12.0, 2.55, 4.0, 0)),
    "trailer_truck": ((15.5, 2.5, 3.7, 0), (16.5, 2.55, 4.0, 0)),
    "bus": ((10.0, 2.5, 3.0, 0), (13.0, 2.55, 3.3, 0)),
    "tram": ((18.0, 2.3, 3.4, 0), (42.0, 2.65, 3.7, 0)),
    "bicycle": ((1.65, 0.5, 1.05, 0), (1.85, 0.65, 1.1, 0)),
    "cyclist": ((1.7, 0.55, 1.6, 0), (1.8, 0.62, 1.85, 0)),
    "motorcycle": ((1.9, 0.7, 1.15, 0), (2.25, 0.9, 1.3, 0)),
    "motorcyclist": ((2.0, 0.75, 1.45, 0), (2.2, 0.85, 1.65, 0)),
    "person": ((0.25, 0.29, 1.05, 0), (0.4, 0.35, 1.3, 0), (0.3, 0.5, 1.8, 0), (0.75, 0.48, 1.75, 0)),
    "house": ((8, 7.5, 5.2, 3.1), (16, 11, 14, 8.9), (8, 11, 8.5, 6.0)),
    "block": ((10, 9, 2 * STOREY + 0.4, 0), (30, 15, 7 * STOREY, 0)),
    "shed": ((2.9, 5.5, 2.4, 0), (25, 9, 5, 0)),
    "tree": ((2.0, 2.0, 4.5, 1.0), (6, 6.4, 9, 2.2), (9, 9, 14, 4), (2, 2, 10, 1.5)),
    "bush": ((0.8, 0.7, 0.5, 0), (4.5, 4, 4, 0)),
    "hedge": ((1.5, 0.6, 0.8, 0), (14, 1.6, 2.4, 0)),
    "grass": ((2, 1, 0.06, 0), (40, 3, 0.5, 0)),
    "lamp": ((0.12, 0.2, 4.0, 0), (0.22, 0.2, 9.0, 0)),
    "pole": ((0.08, 0.2, 0.9, 0), (0.3, 0.3, 8.0, 0)),
    "sign": ((0.12, 0.42, 2.4, 2.0), (0.12, 0.6, 3.4, 2.2), (0.2, 3.0, 4.0, 2.0)),
    "traffic_light": ((0.25, 0.32, 3.3, 2.4), (0.5, 6.0, 5.8, 4.7)),
    "fence": ((1.5, 0.1, 0.8, 0), (14, 0.12, 1.8, 0)),
    "mesh_fence": ((2.0, 0.08, 1.0, 0), (20, 0.1, 2.4, 0)),
    "garden_wall": ((1.5, 0.25, 0.5, 0), (14, 0.3, 1.6, 0)),
    "wall": ((4, 0.2, 1.8, 0), (30, 0.5, 6, 0)),
    "barrier": ((4, 0.3, 0.75, 0), (50, 0.7, 0.75, 0), (30, 0.6, 1.1, 0)),
    "gantry": ((0.6, 9, 7.0, 5.0), (1.0, 24, 8.5, 5.5)),
    "billboard": ((0.3, 3.8, 3.4, 0.8), (0.4, 3.8, 5.4, 2.6)),
    "shelter": ((3.0, 1.3, 2.4, 0), (6.0, 1.8, 2.7, 0)),
    "bin": ((0.58, 0.62, 1.07, 0), (0.4, 0.4, 0.9, 0), (1.1, 1.37, 1.4, 0)),
    "bench": ((1.5, 0.55, 0.8, 0), (2.0, 0.65, 0.9, 0)),
    "cone": ((0.28, 0.28, 0.5, 0), (0.4, 0.4, 0.75, 0)),
    "letterbox": ((0.35, 0.4, 1.2, 0), (0.5, 0.6, 1.6, 0)),
    "hydrant": ((0.35, 0.35, 0.8, 0), (0.45, 0.45, 1.1, 0)),
    "cabinet": ((0.3, 0.8, 1.0, 0), (0.45, 1.8, 1.6, 0)),
}
# How far something sticks out of its extents [m], (length, width, height); 0.06 m is allowed to all.
OUT: dict[str, tuple[float, float, float]] = {
    **dict.fromkeys(BODIES, (0.03, 0.12, 0.0)),  # plates, mirrors
    "truck": (0.08, 0.16, 0.1),
    "trailer_truck": (0.08, 0.16, 0.1),
    "bus": (0.11, 0.16, 0.0),
    "bicycle": (0.1, 0.12, 0.05),
    "cyclist": (0.1, 0.12, 0.0),
    "motorcycle": (0.1, 0.1, 0.1),
    "motorcyclist": (0.1, 0.1, 0.0),
    "person": (0.25, 0.12, 0.0),  # a rucksack, the swing of arms and legs
    "house": (EAVES, EAVES, 0.55),  # a chimney
    "block": (0.0, BALCONY, 0.75),
    "shed": (0.1, 0.1, 0.0),
    "lamp": (0.2, 1.95, 0.0),
    "sign": (0.05, 0.0, 0.0),
    "traffic_light": (0.32, 0.2, 0.0),
    "gantry": (0.1, 0.0, 0.0),
    "billboard": (0.03, 0.0, 0.0),
    "barrier": (0.0, 0.0, 0.1),
}
LABELS: dict[str, frozenset[str]] = {
    **dict.fromkeys(BODIES, frozenset({"car"})),
    **dict.fromkeys(("truck", "trailer_truck"), frozenset({"truck"})),
    **dict.fromkeys(("house", "block", "shed"), frozenset({"building"})),
    **dict.fromkeys(("bush", "hedge"), frozenset({"vegetation"})),
    **dict.fromkeys(("lamp", "pole"), frozenset({"pole"})),
    **dict.fromkeys(("fence", "mesh_fence", "barrier"), frozenset({"fence"})),
    **dict.fromkeys(
        ("billboard", "shelter", "bin", "bench", "cone", "letterbox", "hydrant", "cabinet"), frozenset({"other"})
    ),
    "bus": frozenset({"bus"}),
    "tram": frozenset({"train"}),
    "bicycle": frozenset({"bicycle"}),
    "motorcycle": frozenset({"motorcycle"}),
    "cyclist": frozenset({"rider", "bicycle"}),
    "motorcyclist": frozenset({"rider", "motorcycle"}),
    "person": frozenset({"person"}),
    "tree": frozenset({"trunk", "vegetation"}),
    "grass": frozenset({"terrain"}),
    "sign": frozenset({"pole", "traffic-sign"}),
    "traffic_light": frozenset({"pole", "traffic-light"}),
    "gantry": frozenset({"pole", "traffic-sign"}),
    "wall": frozenset({"wall"}),
    "garden_wall": frozenset({"wall", "fence"}),
}
THINGS = {row.name for row in CLASSES if row.is_thing}
WHEELED = (*BODIES, "truck", "trailer_truck", "bus")


def placed(
    kind: str, variant: int = 0, yaw: float = 0.0, at: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> PlacedObject:
    sizes = SIZES[kind]
    *size, clearance = (float(value) for value in sizes[variant % len(sizes)])
    instance = 5 if LABELS[kind] & THINGS else 0
    x, y, z = at
    return PlacedObject(
        kind=kind,
        id=f"{kind}_1",
        x=x,
        y=y,
        z=z,
        level=z,
        yaw=yaw,
        size=tuple(size),
        clearance=clearance,
        instance=instance,
    )


def build(made: PlacedObject, seed: int) -> list[Primitive]:
    return kind_of(made.kind).build(made, np.random.default_rng(seed))


def vertices(primitive: Primitive) -> np.ndarray:
    return primitive_mesh(primitive).vertices


def test_every_kind_is_tested():
    assert set(SIZES) == set(KINDS) == set(LABELS)
    assert set(SHARES) == set(BODIES)
    assert sum(SHARES.values()) == pytest.approx(1.0)


def test_every_class_is_that_of_a_kind_or_of_the_ground():
    assert {row.name for row in CLASSES} == frozenset().union(*LABELS.values()) | {"none", "road", "sidewalk"}


@pytest.mark.parametrize("kind", SIZES)
def test_things_of_many_seeds_keep_within_their_extents_and_classes(kind: str):
    seen: set[str] = set()
    for seed in range(200):
        made = placed(kind, seed)
        primitives = build(made, seed)
        # unit shapes lie within [-1/2, 1/2]^3: their boxes hold them
        for p in primitives:
            turned = abs(math.sin(p.yaw)) > 0.5
            half = np.array(p.size)[[1, 0, 2] if turned else [0, 1, 2]] / 2
            reach = np.abs(p.center[:2]) + half[:2] - np.array(made.size[:2]) / 2
            out = OUT.get(kind, (0.0, 0.0, 0.0))
            if not (kind == "tree" and p.label == "trunk"):
                assert (reach < np.array(out[:2]) + 0.06).all(), (p.id, reach)
            assert p.center[2] + half[2] < made.size[2] + out[2] + 0.06, p.id
            assert replace(p) == p  # which checks every field
        seen |= {p.label for p in primitives}
        assert all((p.instance > 0) == (p.label in THINGS) for p in primitives)
        assert len({p.id for p in primitives}) == len(primitives)
        assert {p.id.partition(".")[0] for p in primitives} == {made.id}
    assert seen == LABELS[kind]


@pytest.mark.parametrize("kind", SIZES)
def test_things_are_turned_and_moved_as_a_whole_and_the_same_each_time(kind: str):
    yaw, at = 0.7, (12.0, -3.0, 0.4)
    for seed in range(3):
        straight, moved = build(placed(kind, seed), seed), build(placed(kind, seed, yaw, at), seed)
        assert build(placed(kind, seed), seed) == straight
        cos, sin = math.cos(yaw), math.sin(yaw)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        for one, two in zip(straight, moved, strict=True):
            assert vertices(two) == pytest.approx(vertices(one) @ turn + at, abs=1e-9)


@pytest.mark.parametrize("kind", SIZES)
def test_nothing_floats(kind: str):
    """Parts whose boxes touch, to 6 cm, hang together, and the lowest of them reach the ground."""
    for seed in range(15):
        made = placed(kind, seed)
        primitives = build(made, seed)
        corners = [vertices(p) for p in primitives]
        low = np.array([v.min(axis=0) for v in corners]) - 0.03
        high = np.array([v.max(axis=0) for v in corners]) + 0.03
        near = ((low[:, None] <= high) & (high[:, None] >= low)).all(axis=2)
        held = low[:, 2] <= 0.02
        assert held.any()
        for _ in corners:
            held = (near & held).any(axis=1)
        floating = [p.id for p, ok in zip(primitives, held, strict=True) if not ok]
        assert not floating, (seed, floating)


@pytest.mark.parametrize("kind", WHEELED)
def test_wheels_stand_on_the_ground_within_the_width(kind: str):
    for seed in range(6):
        made = placed(kind, seed)
        tyres = [p for p in build(made, seed) if p.material == "rubber"]
        assert tyres
        axles = set()
        for tyre in tyres:
            assert tyre.center[2] - tyre.size[2] / 2 == pytest.approx(0.0, abs=1e-6)
            assert tyre.size[1] <= made.size[1] + 1e-9
            assert 0.5 < tyre.size[2] < 1.1
            lowest = vertices(tyre)[vertices(tyre)[:, 2] < 0.01]
            assert lowest[:, 1].max() == pytest.approx(-lowest[:, 1].min()) == pytest.approx(made.size[1] / 2, rel=0.03)
            axles |= set((lowest[:, 0] / 0.6).round().tolist())
        assert len(axles) >= 2


@pytest.mark.parametrize("kind", ["cyclist", "motorcyclist"])
def test_a_rider_and_what_is_ridden_are_two_instances(kind: str):
    for seed in range(10):
        primitives = build(placed(kind, seed), seed)
        ridden = LABELS[kind] - {"rider"}
        assert {(p.label, p.instance) for p in primitives} == {("rider", 5), *((label, 6) for label in ridden)}
        rider = np.concatenate([vertices(p) for p in primitives if p.label == "rider"])
        assert rider[:, 2].max() == pytest.approx(placed(kind, seed).size[2], abs=0.12)


@pytest.mark.parametrize("variant", range(4))
def test_a_person_fills_the_stature_and_walks(variant: int):
    made = placed("person", variant)
    strides = []
    for seed in range(40):
        primitives = build(made, seed)
        every = np.concatenate([vertices(p) for p in primitives])
        assert every[:, 2].max() == pytest.approx(made.size[2], abs=0.01)
        assert every[:, 2].min() == pytest.approx(0.0, abs=0.02)
        strides.append(np.ptp(vertices(primitives[0])[:, 0]))
    # the feet of one who stands are side by side; of one who walks they meet and part
    apart = max(strides) - min(strides)
    assert (apart < 0.02) if made.size[0] <= 0.3 else (apart > 0.1 * made.size[2])


def test_the_number_of_parts_is_bounded():
    most = {"person": 11, "tree": 9, "house": 8, "block": 10, **dict.fromkeys(BODIES, 14)}
    for kind, limit in most.items():
        assert max(len(build(placed(kind, seed), seed)) for seed in range(30)) <= limit


def test_things_of_one_form_share_their_meshes():
    one, two = (build(placed("suv", yaw=yaw), seed) for yaw, seed in ((0.0, 1), (1.0, 2)))
    meshes = [(a.mesh, b.mesh) for a, b in zip(one, two, strict=True) if a.mesh is not None]
    assert len(meshes) >= 6
    assert all(a is b for a, b in meshes)


def test_cars_are_of_many_bodies_and_sizes():
    rng = np.random.default_rng(0)
    coarse = [sample_car(rng) for _ in range(1000)]
    assert {name for name, _ in coarse} == set(BODIES)
    for name, size in coarse:
        body: VehicleBody = BODIES[name]
        assert np.array(size) / body.size == pytest.approx(np.ones(3), abs=0.101)


def cast(primitives: list[Primitive], origin: tuple[float, float, float], towards: np.ndarray) -> np.ndarray:
    """Labels and primitives of rays from a point to points [R, 3]; -1 is nothing."""
    origins = np.broadcast_to(np.array(origin, dtype=np.float64), towards.shape)
    return Raycaster(Layout(primitives=tuple(primitives))).cast(origins, towards - origins).primitive


def test_rays_pass_between_spokes_and_slats():
    made = placed("bicycle")
    bicycle = build(made, 3)
    wheel = bicycle[1]
    rng = np.random.default_rng(0)
    at = np.column_stack([rng.uniform(0.48, 0.62, 400), np.zeros(400), rng.uniform(0.2, 0.28, 400)])
    open_share = (cast(bicycle, (0.55, 8.0, 0.3), at) < 0).mean()
    assert wheel.label == "bicycle"
    assert 0.7 < open_share < 1.0
    fence = build(placed("fence", 1), 0)
    x = np.column_stack([rng.uniform(-6, 6, 600), np.zeros(600), np.full(600, 0.9)])
    open_share = np.mean([(cast(fence, (float(a), 8.0, 0.9), x[k : k + 1]) < 0)[0] for k, (a, _, _) in enumerate(x)])
    assert 0.05 < open_share < 0.9


def test_rays_go_into_a_car_and_some_through_it():
    made = placed("estate")
    car = build(made, 0)
    rng = np.random.default_rng(1)
    z = rng.uniform(1.05, 1.2, 500)
    at = np.column_stack([rng.uniform(-1.6, 0.3, 500), np.zeros(500), z])
    found = cast(car, (-0.3, 30.0, 1.15), at)
    materials = [car[index].material if index >= 0 else "nothing" for index in found]
    for material in ("car-glass", "dark-cloth", "nothing"):
        assert materials.count(material) > 10, material
    assert 0.5 < materials.count("car-glass") / len(materials) < 0.92


def test_plants_are_media_and_let_some_rays_through():
    for kind in ("tree", "bush", "hedge"):
        for seed in range(20):
            leaves = [p for p in build(placed(kind, seed % 2), seed) if p.label == "vegetation"]
            assert leaves
            assert all(p.extinction is not None and 0.0 < p.extinction < 25.0 for p in leaves)
            assert all(p.shape in ("ellipsoid", "box") for p in leaves)
    assert all(p.extinction is not None for p in build(placed("grass", 1), 0))
    mesh = [p for p in build(placed("mesh_fence", 1), 0) if p.extinction is not None]
    assert len(mesh) == 1
    # one in eight rays meets a wire
    assert 1.0 - math.exp(-mesh[0].extinction * mesh[0].size[1]) == pytest.approx(0.12, abs=1e-6)


def test_signs_reflect_to_the_front_and_are_grey_behind():
    for seed in range(12):
        made = placed("sign", seed % 2)
        primitives = build(made, seed)
        middle = np.array([[0.0, 0.0, made.size[2] - 0.2]])
        for x, material in ((6.0, "retroreflector"), (-6.0, "sign-back")):
            behind = cast([p for p in primitives if p.label == "traffic-sign"], (x, 0.05, made.size[2] - 0.2), middle)
            found = [p for p in primitives if p.label == "traffic-sign"][behind[0]]
            assert found.material == material


def test_houses_have_windows_in_recesses():
    for seed in range(8):
        house = build(placed("house", seed), seed)
        panes = [p for p in house if p.material == "window"]
        assert panes
        wall, pane = house[0], panes[0]
        assert pane.size[1] < wall.size[1] - 0.1
