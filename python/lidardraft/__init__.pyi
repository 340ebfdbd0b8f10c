"""The public names and their types; `__init__.py` reads from here the module of each."""

# fmt: off
# isort: off
from lidardraft import streets as streets
from lidardraft.diffusion.denoiser import Denoiser as Denoiser
from lidardraft.diffusion.sensor_limits import SensorLimits as SensorLimits
from lidardraft.drafting.blender.layout import layout_from_blender as layout_from_blender
from lidardraft.drafting.blender.script.limits import ScriptLimits as ScriptLimits
from lidardraft.drafting.boxes import layout_from_boxes as layout_from_boxes
from lidardraft.drafting.cloud.layout import layout_from_cloud as layout_from_cloud
from lidardraft.drafting.language_model.layout import layout_from_llm as layout_from_llm
from lidardraft.drafting.models import layout_from_glb as layout_from_glb, layout_from_obj as layout_from_obj
from lidardraft.drafting.picture.layout import layout_from_image as layout_from_image
from lidardraft.drafting.sketch.layout import layout_from_sketch as layout_from_sketch
from lidardraft.drafting.text.layout import layout_from_text as layout_from_text
from lidardraft.errors import (
    CheckpointError as CheckpointError, FormatError as FormatError, LanguageModelError as LanguageModelError,
    LayoutError as LayoutError, LidarDraftError as LidarDraftError, MissingExtraError as MissingExtraError,
    ScriptError as ScriptError, SensorError as SensorError, TextError as TextError, TrainingError as TrainingError,
    UnknownNameError as UnknownNameError,
)
from lidardraft.exports import export as export
from lidardraft.formats.frame import Annotation as Annotation, Frame as Frame
from lidardraft.pipeline import Pipeline as Pipeline
from lidardraft.scan import Scan as Scan
from lidardraft.scene import edit as edit
from lidardraft.scene.box import Box as Box
from lidardraft.scene.intent import Asked as Asked, Intent as Intent
from lidardraft.scene.lane import (
    Crossing as Crossing, Junction as Junction, Lane as Lane, Pavement as Pavement, Signal as Signal,
)
from lidardraft.scene.layout import Layout as Layout, Primitive as Primitive
from lidardraft.scene.line import Line as Line
from lidardraft.scene.mesh import TriangleMesh as TriangleMesh
from lidardraft.scene.range_image import RangeImage as RangeImage, RangeImageBatch as RangeImageBatch
from lidardraft.scene.raycast import Hits as Hits, Raycaster as Raycaster, raycast as raycast
from lidardraft.scene.road import PavedArea as PavedArea, Road as Road
from lidardraft.scene.relief import Relief as Relief
from lidardraft.scene.road_network import Drawn as Drawn, RoadNetwork as RoadNetwork
from lidardraft.scene.scenario import (
    AlongLane as AlongLane, Motion as Motion, Scenario as Scenario, Straight as Straight, Track as Track,
    Walk as Walk, Waypoints as Waypoints,
)
from lidardraft.scene.sensor import Sensor as Sensor
from lidardraft.scene.sensor_model import IntensityCurve as IntensityCurve, SensorModel as SensorModel
from lidardraft.scene.street import StreetFrame as StreetFrame
from lidardraft.scene.weather import Weather as Weather
from lidardraft.semantics import CLASSES as CLASSES, SemanticClass as SemanticClass
from lidardraft.simulation.carrier import with_vehicle as with_vehicle
from lidardraft.simulation.detail.detail import detail as detail
from lidardraft.simulation.recorded.object_sampling import ObjectSampling as ObjectSampling
from lidardraft.simulation.observe_cast import observe_cast as observe_cast, observe_points as observe_points
from lidardraft.simulation.recorded.recorded_scan import RecordedScan as RecordedScan
from lidardraft.simulation.recorded.scan_edits import (
    Edit as Edit, Insert as Insert, Move as Move, Remove as Remove, Replace as Replace, edit_scan as edit_scan,
)
from lidardraft.simulation.motion.sequence import SequenceSimulator as SequenceSimulator
from lidardraft.simulation.simulate import Simulator as Simulator, simulate as simulate
from lidardraft.simulation.around.surround import surround as surround
from lidardraft.simulation.on_relief import on_relief as on_relief
from lidardraft.simulation.motion.tracks import Tracks as Tracks
from lidardraft.streets import (
    StreetConfig as StreetConfig, StreetMix as StreetMix, street_drive as street_drive, street_scan as street_scan,
)
from lidardraft.world.rig import Mount as Mount, Rig as Rig
from lidardraft.world.state import (
    Actor as Actor, Collision as Collision, Drive as Drive, WorldState as WorldState,
)
from lidardraft.world.world import Handle as Handle, World as World

__version__: str
