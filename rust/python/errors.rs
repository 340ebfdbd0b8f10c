//! Errors of the core as Python exceptions.

use lidardraft_core::Error;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

pyo3::import_exception!(lidardraft.errors, FormatError);
pyo3::import_exception!(lidardraft.errors, LayoutError);
pyo3::import_exception!(lidardraft.errors, LidarDraftError);
pyo3::import_exception!(lidardraft.errors, SensorError);

/// An error of the core on its way to Python.
pub(crate) struct CoreError(Error);

/// The result of a function of the module.
pub(crate) type CoreResult<T> = Result<T, CoreError>;

impl From<Error> for CoreError {
    fn from(error: Error) -> Self {
        CoreError(error)
    }
}

impl From<CoreError> for PyErr {
    fn from(CoreError(error): CoreError) -> PyErr {
        let message = error.to_string();
        match error {
            Error::NoBeams
            | Error::BeamTable { .. }
            | Error::BeamNotFinite { .. }
            | Error::BeamOrigin { .. }
            | Error::ElevationLimit { .. }
            | Error::ElevationOrder { .. }
            | Error::Columns { .. }
            | Error::AzimuthStart { .. }
            | Error::AzimuthSpan { .. }
            | Error::RangeLimits { .. }
            | Error::ImageShape { .. }
            | Error::ImageSize { .. }
            | Error::OutputShape { .. }
            | Error::Depth { .. }
            | Error::Rays { .. }
            | Error::SensorModel { .. }
            | Error::CurveTable { .. }
            | Error::OffsetTable { .. }
            | Error::ObservedSize { .. }
            | Error::SurfaceColumn { .. }
            | Error::ImagePrimitive { .. } => SensorError::new_err(message),
            Error::ObjUnreadable { .. }
            | Error::ObjBroken { .. }
            | Error::ObjWithoutFaces { .. }
            | Error::ObjMesh { .. } => FormatError::new_err(message),
            Error::Backend { .. } | Error::Threads { .. } | Error::Seed { .. } => LidarDraftError::new_err(message),
            Error::EmptyMesh { .. }
            | Error::VertexNotFinite { .. }
            | Error::FaceIndex { .. }
            | Error::PrimitiveTable { .. }
            | Error::PointTable { .. }
            | Error::TableShape { .. }
            | Error::ShapeCode { .. }
            | Error::MeshCount { .. }
            | Error::Mesh { .. }
            | Error::MeshReach { .. }
            | Error::Center { .. }
            | Error::Size { .. }
            | Error::Yaw { .. }
            | Error::Extinction { .. }
            | Error::PlaneMedium { .. }
            | Error::OpenMedium { .. }
            | Error::MovedCount { .. }
            | Error::MovedIndex { .. }
            | Error::MovedTwice { .. }
            | Error::PoseEntry { .. }
            | Error::PoseLastRow { .. }
            | Error::PoseNotRigid { .. }
            | Error::PoseMirrored { .. }
            | Error::PoseOfTable { .. }
            | Error::PoseCount { .. }
            | Error::ScanCount { .. }
            | Error::RayCount { .. }
            | Error::RayOrigin { .. }
            | Error::RayDirection { .. }
            | Error::MaxRange { .. } => LayoutError::new_err(message),
        }
    }
}

/// The exception for an array that cannot be read or written in place.
pub(crate) fn memory_error(name: &str, reason: &str) -> PyErr {
    PyTypeError::new_err(format!("{name} {reason}"))
}

/// The exception for an array of another type or memory order than required.
pub(crate) fn array_type_error(name: &str, expected: &str, given: &str) -> PyErr {
    PyTypeError::new_err(format!("{name} must be a C-contiguous array of {expected}; it is {given}"))
}
