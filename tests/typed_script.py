"""A script that uses every public name, with types as a user's `mypy --strict` sees them."""

from collections.abc import Iterator, Mapping

import numpy as np

import lidardraft
from lidardraft import (
    CLASSES,
    Actor,
    AlongLane,
    Annotation,
    Asked,
    Box,
    Collision,
    Crossing,
    Denoiser,
    Drawn,
    Drive,
    Edit,
    Frame,
    Handle,
    Hits,
    Insert,
    IntensityCurve,
    Intent,
    Junction,
    Lane,
    Layout,
    Line,
    Motion,
    Mount,
    Move,
    ObjectSampling,
    PavedArea,
    Pavement,
    Pipeline,
    Primitive,
    RangeImage,
    RangeImageBatch,
    Raycaster,
    RecordedScan,
    Relief,
    Remove,
    Replace,
    Rig,
    Road,
    RoadNetwork,
    Scan,
    Scenario,
    ScriptLimits,
    SemanticClass,
    Sensor,
    SensorLimits,
    SensorModel,
    SequenceSimulator,
    Signal,
    Simulator,
    Straight,
    StreetConfig,
    StreetFrame,
    StreetMix,
    Track,
    Tracks,
    TriangleMesh,
    Walk,
    Waypoints,
    Weather,
    World,
    WorldState,
    edit,
    streets,
)


def asked(layout: Layout) -> Asked:
    """Of an object."""
    intent: Intent = layout.intent
    return intent.of("car_1")


def planned(layout: Layout) -> tuple[Lane, ...]:
    """The way from the ego vehicle's lane to another, and the roads of a map around it."""
    roads: RoadNetwork | None = layout.roads
    if roads is None:
        area = PavedArea((1.0, 20.0), (9.0, 30.0))
        street = StreetFrame(road=Road(lanes=2, paved_areas=(area,)))
        relief = Relief(np.array([0.0, 9.0]), np.array([-9.0, 9.0]), np.zeros((2, 2)), (1.0, 2.0, 0.0))
        drawn = (Drawn("road", (0.0, 0.0, 0.0), (9.0, 9.0, 0.0)),)
        roads = RoadNetwork(street=street, drawn=drawn, relief=relief)
    lane, along, left = roads.nearest_lane(0.0, 0.0, yaw=0.0)
    up: np.ndarray = roads.normal(along, left, roads.height(along, left))
    mine = Lane(id="1", line=Line.through(np.outer([0.0, 9.0], up)), width=3.5, speed=9.0, junction="j")
    of_map = RoadNetwork(
        lanes=(mine,),
        junctions=(Junction(id="j", lanes=("1",)),),
        crossings=(Crossing(id="c", place=(1.0, 2.0, 0.0), size=(4.0, 7.0)),),
        signals=(Signal(id="s", place=(1.0, 2.0, 0.0), lanes=("1",)),),
        paved=(Pavement(place=(1.0, 2.0, 0.0), size=(4.0, 7.0), label="road"),),
    )
    return (*roads.route(lane.id, lane.id), *of_map.moved((1.0, 0.0, 0.0)).ways())


def layouts(file: str, points: np.ndarray, boxes: list[Box]) -> Iterator[Layout]:
    """One of each input."""
    yield lidardraft.on_relief(lidardraft.layout_from_text("a bus ahead", seed=1, strict=True))
    yield lidardraft.layout_from_llm("a bus ahead", seed=1, url="http://localhost:11434/v1", model="small")
    yield lidardraft.layout_from_image(file, hfov=1.2)
    yield lidardraft.layout_from_sketch(file, metres_per_pixel=0.1, seed=1)
    yield lidardraft.layout_from_boxes(boxes, sensor_height=1.73)
    yield lidardraft.layout_from_cloud(points, np.ones(len(points)), sensor_height=1.73)
    yield lidardraft.layout_from_obj(file, up="z", scale=0.01)
    yield lidardraft.layout_from_glb(file, classes={"Cube": "car"})
    yield lidardraft.layout_from_blender(file, limits=ScriptLimits(steps=10**6))


def errors() -> tuple[type[lidardraft.LidarDraftError], ...]:
    """The family."""
    about_input = (lidardraft.LayoutError, lidardraft.SensorError, lidardraft.FormatError, lidardraft.TextError)
    about_networks = (lidardraft.CheckpointError, lidardraft.TrainingError, lidardraft.LanguageModelError)
    return (*about_input, *about_networks, lidardraft.ScriptError, lidardraft.MissingExtraError)


def edited(layout: Layout) -> Layout:
    """An object goes, another comes."""
    try:
        first: Primitive = layout["car_1"]
    except lidardraft.UnknownNameError:
        return layout
    mesh: TriangleMesh | None = first.mesh
    ids: tuple[SemanticClass, ...] = CLASSES
    assert mesh is None, ids
    layout = edit.add(
        edit.remove(layout, "tree_*"), Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 2), label="car", id="c")
    )
    return lidardraft.detail(lidardraft.surround(edit.move(layout, "c", (1.0, 0.0, 0.0)), seed=1), seed=1)


def sensors() -> Iterator[Sensor]:
    """A preset, one of one's own, and one behind a bonnet."""
    names: tuple[str, ...] = Sensor.presets()
    curve = IntensityCurve(responses=(0.1, 1.0), readings=((0.0, 1.0),))
    yield Sensor.preset(names[0])
    yield Sensor(
        name="mine", elevations=(0.1, 0.0), columns=8, model=SensorModel(rays_per_beam=1, intensity_curve=curve)
    )
    bonnet = Primitive(shape="box", center=(1, 0, 1), size=(2, 2, 0.2), label="car", id="bonnet", instance=1)
    yield lidardraft.with_vehicle(Sensor.preset("vlp16"), Layout((bonnet,)))


def scans(layout: Layout, sensor: Sensor, denoiser: Denoiser) -> Iterator[Scan]:
    """Simulated, generated, in sequences, of streets, of points."""
    yield lidardraft.simulate(layout, sensor, seed=3, weather=Weather(rain=5.0), model=SensorModel())
    yield Simulator("a bus ahead", sensor).scan(sensor.pose(x=1.0), speed=5.0, seed=2)
    motions: Mapping[str, Motion] = {"bus_1": AlongLane(speed=8.0), "person_1": Walk(to=(3.0, 4.0))}
    scenario = Scenario(ego=Straight(8.0), actors=motions)
    simulator = SequenceSimulator(layout, sensor, scenario, frames=3, seed=1)
    tracks: Tracks = simulator.tracks
    ego: Track = tracks.ego
    yield from SequenceSimulator(layout, sensor, Scenario(ego=Waypoints(tuple(map(tuple, ego.places.tolist())))))
    pipeline = Pipeline(denoiser, trained=SensorLimits.from_sensor(sensor))
    yield pipeline("a bus ahead", seed=1)
    yield from pipeline.scans([("a bus ahead", 2), (layout, 3)], sensor=sensor, speed=5.0)
    config = StreetConfig(sensor=sensor, mix=StreetMix(traffic=2.0))
    yield lidardraft.street_scan(3, seed=1, config=config)
    yield lidardraft.street_drive(3, seed=1, config=config, frames=20).frame(4)
    pair = next(streets.streets(seed=1, config=config, workers=2))
    yield Scan.from_points(pair.scan.points(), sensor, intensity=pair.scan.intensity, layout=pair.layout)


def in_a_world(layout: Layout, sensor: Sensor, file: str) -> Iterator[Scan]:
    """Changed, stepped and scanned, from two states."""
    world = World(layout, sensor, seed=1, collisions="stop")
    van: str = world.add("van", at=(22.0, -3.5), yaw=3.14, speed=6.0)
    world.follow(van, behind="car_1", gap=3.0)
    world.move("person_3", (9.0, 2.0), speed=1.0)
    ego: Handle = world.ego
    ego.pose = (1.0, 0.0, 0.1)
    world["bus_1"].motion = Straight(9.0)
    state: WorldState = world.state()
    for _ in range(3):
        world.step(0.1)
        yield world.scan()
    events: tuple[Collision, ...] = world.collisions
    boxes: list[Box] = world.boxes()
    actor: Actor = state.actors[van]
    drive: Drive | None = actor.drive
    assert drive is None or drive.speed >= 0.0
    state.save(file)
    assert events, boxes
    rig = Rig({"top": Mount(sensor, (0.0, 0.0, 1.8, 0.0))})
    yield from World(WorldState.load(file), rig).scans().values()


def casts(layout: Layout, sensor: Sensor, points: np.ndarray) -> tuple[RangeImage, RangeImageBatch, Hits]:
    """Casts, and what a sensor makes of those of others."""
    caster = Raycaster(layout)
    image = lidardraft.raycast(layout, sensor, incidence=True)
    lidardraft.observe_cast(image.depth, image.label, sensor, materials={"car": "dark-paint"}, seed=1)
    lidardraft.observe_points(points, np.ones(len(points), np.uint8), sensor, seed=1)
    return image, caster.scan_batch(sensor, sensor.pose()[None]), caster.cast(np.zeros(3), np.eye(3), seed=1)


def augmented(scan: Scan) -> RecordedScan:
    """A recorded scan with other objects, and what data sets are written from."""
    frame: Frame = scan.frame(as_seen=True)
    lidardraft.export([scan], "nuscenes", "nuscenes", box_margin=0.02)
    annotations: list[Annotation] = list(frame.annotations)
    notes: tuple[str, ...] = scan.notes + scan.layout.notes
    assert annotations, notes
    recorded = RecordedScan.from_points(scan.points(), scan.image.sensor, boxes=scan.boxes())
    ObjectSampling({"car": 3}, scan.image.sensor, seed=1)
    edits: list[Edit] = [Insert("car", (9.0, 2.0)), Remove("car_1"), Move("car_2", (9.0, -2.0), yaw=0.1)]
    edits.append(Replace("car_3", "truck"))
    return lidardraft.edit_scan(recorded, edits, seed=1)
