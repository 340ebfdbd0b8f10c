"""Anything a person has becomes a layout of semantic shapes, and the layout a LiDAR scan."""

import importlib
import warnings
from typing import TYPE_CHECKING

from lidardraft._core import DEBUG as _DEBUG
from lidardraft.errors import extra as _extra

__version__ = "0.1.0"  # that of pyproject.toml and Cargo.toml

# What is public, by the module that is imported when one of its names is first asked for: most of it needs
# scikit-learn, Pillow or torch. Type checkers and editors read the same names from the imports below.
_PUBLIC = {
    "lidardraft.diffusion.denoiser": "Denoiser",
    "lidardraft.diffusion.sensor_limits": "SensorLimits",
    "lidardraft.drafting.blender.layout": "layout_from_blender",
    "lidardraft.drafting.blender.script.limits": "ScriptLimits",
    "lidardraft.drafting.boxes": "layout_from_boxes",
    "lidardraft.drafting.cloud.layout": "layout_from_cloud",
    "lidardraft.drafting.language_model.layout": "layout_from_llm",
    "lidardraft.drafting.models": "layout_from_glb layout_from_obj",
    "lidardraft.drafting.picture.layout": "layout_from_image",
    "lidardraft.drafting.sketch.layout": "layout_from_sketch",
    "lidardraft.drafting.text.layout": "layout_from_text",
    "lidardraft.errors": (
        "CheckpointError FormatError LanguageModelError LayoutError LidarDraftError MissingExtraError "
        "ScriptError SensorError TextError TrainingError UnknownNameError"
    ),
    "lidardraft.exports": "export",
    "lidardraft.formats.frame": "Annotation Frame",
    "lidardraft.pipeline": "Pipeline",
    "lidardraft.scan": "Scan",
    "lidardraft.scene.box": "Box",
    "lidardraft.scene.edit": "edit",
    "lidardraft.scene.layout": "Layout Primitive",
    "lidardraft.scene.mesh": "TriangleMesh",
    "lidardraft.scene.range_image": "RangeImage RangeImageBatch",
    "lidardraft.scene.raycast": "Hits Raycaster raycast with_vehicle",
    "lidardraft.scene.scenario": "AlongLane Motion Scenario Straight Track Walk Waypoints",
    "lidardraft.scene.sensor": "Sensor",
    "lidardraft.scene.sensor_model": "IntensityCurve SensorModel",
    "lidardraft.scene.weather": "Weather",
    "lidardraft.semantics": "CLASSES SemanticClass",
    "lidardraft.simulation.detail": "detail",
    "lidardraft.simulation.object_sampling": "ObjectSampling",
    "lidardraft.simulation.observe_cast": "observe_cast observe_points",
    "lidardraft.simulation.recorded_scan": "RecordedScan",
    "lidardraft.simulation.scan_edits": "Edit Insert Move Remove Replace edit_scan",
    "lidardraft.simulation.sequence": "SequenceSimulator",
    "lidardraft.simulation.simulate": "Simulator simulate",
    "lidardraft.simulation.surround": "surround",
    "lidardraft.simulation.tracks": "Tracks",
    "lidardraft.streets": "StreetConfig StreetMix street_scan streets",
}
_MODULE_OF = {name: module for module, names in _PUBLIC.items() for name in names.split()}

if TYPE_CHECKING:
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
    from lidardraft.scene.layout import Layout as Layout, Primitive as Primitive
    from lidardraft.scene.mesh import TriangleMesh as TriangleMesh
    from lidardraft.scene.range_image import RangeImage as RangeImage, RangeImageBatch as RangeImageBatch
    from lidardraft.scene.raycast import (
        Hits as Hits, Raycaster as Raycaster, raycast as raycast, with_vehicle as with_vehicle,
    )
    from lidardraft.scene.scenario import (
        AlongLane as AlongLane, Motion as Motion, Scenario as Scenario, Straight as Straight, Track as Track,
        Walk as Walk, Waypoints as Waypoints,
    )
    from lidardraft.scene.sensor import Sensor as Sensor
    from lidardraft.scene.sensor_model import IntensityCurve as IntensityCurve, SensorModel as SensorModel
    from lidardraft.scene.weather import Weather as Weather
    from lidardraft.semantics import CLASSES as CLASSES, SemanticClass as SemanticClass
    from lidardraft.simulation.detail import detail as detail
    from lidardraft.simulation.object_sampling import ObjectSampling as ObjectSampling
    from lidardraft.simulation.observe_cast import observe_cast as observe_cast, observe_points as observe_points
    from lidardraft.simulation.recorded_scan import RecordedScan as RecordedScan
    from lidardraft.simulation.scan_edits import (
        Edit as Edit, Insert as Insert, Move as Move, Remove as Remove, Replace as Replace, edit_scan as edit_scan,
    )
    from lidardraft.simulation.sequence import SequenceSimulator as SequenceSimulator
    from lidardraft.simulation.simulate import Simulator as Simulator, simulate as simulate
    from lidardraft.simulation.surround import surround as surround
    from lidardraft.simulation.tracks import Tracks as Tracks
    from lidardraft.streets import StreetConfig as StreetConfig, StreetMix as StreetMix, street_scan as street_scan
    # fmt: on
else:
    __all__ = sorted(_MODULE_OF)

    def __getattr__(name):
        if name not in _MODULE_OF:
            raise AttributeError(f"module 'lidardraft' has no attribute {name!r}")
        with _extra():
            module = importlib.import_module(_MODULE_OF[name])
            value = module if name in ("edit", "streets") else getattr(module, name)  # modules are public whole
            return globals().setdefault(name, value)

    def __dir__():
        return __all__


def _warn_of_debug_build(debug: bool) -> None:
    """One warning at the line that imports lidardraft, if the core was compiled without optimisation."""
    if debug:
        message = (
            "lidardraft's compiled core is a debug build: right, but many times slower than a release build; "
            "`make install` or `maturin develop --release` makes that"
        )
        warnings.warn(message, RuntimeWarning, stacklevel=3)


_warn_of_debug_build(_DEBUG)
