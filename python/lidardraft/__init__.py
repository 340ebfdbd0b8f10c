"""Anything a person has becomes a layout of semantic shapes, and the layout a LiDAR scan."""

import importlib
import warnings
from typing import Any

from lidardraft._core import DEBUG as _DEBUG
from lidardraft.errors import LidarDraftError, extra
from lidardraft.scene.box import Box
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage, RangeImageBatch
from lidardraft.scene.raycast import Hits, Raycaster, raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import CLASSES, SemanticClass

__version__ = "0.1.0"  # that of pyproject.toml and Cargo.toml

# Imported when first asked for: most of it needs scikit-learn, Pillow or torch.
_LAZY = {
    "ObjectSampling": "lidardraft.simulation.object_sampling",
    "Pipeline": "lidardraft.pipeline",
    "RecordedScan": "lidardraft.simulation.recorded_scan",
    "Scan": "lidardraft.scan",
    "Scenario": "lidardraft.scene.scenario",
    "SequenceSimulator": "lidardraft.simulation.sequence",
    "Simulator": "lidardraft.simulation.simulate",
    "detail": "lidardraft.simulation.detail",
    "edit_scan": "lidardraft.simulation.scan_edits",
    "export": "lidardraft.exports",
    "observe_cast": "lidardraft.simulation.observe_cast",
    "observe_points": "lidardraft.simulation.observe_cast",
    "simulate": "lidardraft.simulation.simulate",
    "surround": "lidardraft.simulation.surround",
    "layout_from_blender": "lidardraft.drafting.blender.layout",
    "layout_from_boxes": "lidardraft.drafting.boxes",
    "layout_from_cloud": "lidardraft.drafting.cloud.layout",
    "layout_from_glb": "lidardraft.drafting.models",
    "layout_from_image": "lidardraft.drafting.picture.layout",
    "layout_from_llm": "lidardraft.drafting.language_model.layout",
    "layout_from_obj": "lidardraft.drafting.models",
    "layout_from_sketch": "lidardraft.drafting.sketch.layout",
    "layout_from_text": "lidardraft.drafting.text.layout",
    "with_vehicle": "lidardraft.scene.raycast",
}

__all__ = [
    "CLASSES",
    "Box",
    "Hits",
    "Layout",
    "LidarDraftError",
    "Primitive",
    "RangeImage",
    "RangeImageBatch",
    "Raycaster",
    "SemanticClass",
    "Sensor",
    "raycast",
    *_LAZY,
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        with extra("generate"):
            return getattr(importlib.import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'lidardraft' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


def _warn_of_debug_build(debug: bool) -> None:
    """One warning at the line that imports lidardraft, if the core was compiled without optimisation."""
    if debug:
        message = (
            "lidardraft's compiled core is a debug build: right, but many times slower than a release build; "
            "`make install` or `maturin develop --release` makes that"
        )
        warnings.warn(message, RuntimeWarning, stacklevel=3)


_warn_of_debug_build(_DEBUG)
