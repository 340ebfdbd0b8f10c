//! The possible errors of the core's input.

use std::path::PathBuf;

/// The result of functions that check their input.
pub type Result<T> = std::result::Result<T, Error>;

/// One variant for each kind of invalid input; its message names the thing, the value and the limit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "each field is named in the message of its variant")]
pub enum Error {
    /// A mesh without surface.
    #[error("the mesh has {vertices} vertices and {faces} faces; it needs at least one of each")]
    EmptyMesh { vertices: usize, faces: usize },
    /// A vertex with a coordinate that is NaN or infinite.
    #[error("vertex {vertex} is {position:?}; coordinates must be finite")]
    VertexNotFinite { vertex: usize, position: [f64; 3] },
    /// A face with a vertex that the mesh does not have.
    #[error("face {face} refers to vertex {vertex}; the mesh has {vertices} vertices")]
    FaceIndex { face: usize, vertex: u32, vertices: usize },

    /// An OBJ file that cannot be opened.
    #[error("{}: {reason}", path.display())]
    ObjUnreadable { path: PathBuf, reason: String },
    /// An OBJ file with a line that is not OBJ.
    #[error("{}, line {line}: {reason}", path.display())]
    ObjBroken { path: PathBuf, line: usize, reason: String },
    /// An OBJ file without a face.
    #[error("{} has no faces; it needs at least one", path.display())]
    ObjWithoutFaces { path: PathBuf },
    /// An OBJ file with an object that is not a mesh.
    #[error("{}, object {object:?}: {source}", path.display())]
    ObjMesh { path: PathBuf, object: String, source: Box<Error> },

    /// A sensor without beams.
    #[error("elevations has 0 entries; a sensor needs at least one beam")]
    NoBeams,
    /// A table of beams that is longer or shorter than the elevations.
    #[error("{table} has {entries} entries; the sensor has {beams} beams")]
    BeamTable { table: &'static str, entries: usize, beams: usize },
    /// A beam with a value that is NaN or infinite.
    #[error("{table}[{beam}] is {value}; it must be finite")]
    BeamNotFinite { table: &'static str, beam: usize, value: f64 },
    /// A beam with an invalid origin.
    #[error("origins[{beam}] is {value:?} m; every coordinate must be finite and at most {limit:e} in size")]
    BeamOrigin { beam: usize, value: [f64; 3], limit: f64 },
    /// A beam that points straight up or down, or beyond.
    #[error("elevations[{beam}] is {value} rad; it must be between -pi/2 and pi/2, both excluded")]
    ElevationLimit { beam: usize, value: f64 },
    /// A beam that is not below the one before it.
    #[error("elevations[{beam}] is {value} rad after {previous} rad; elevations must strictly decrease")]
    ElevationOrder { beam: usize, value: f64, previous: f64 },
    /// No columns, or more than an image can have.
    #[error("columns is {columns}; it must be 1 to {limit}")]
    Columns { columns: i64, limit: usize },
    /// A start azimuth that is NaN or infinite.
    #[error("azimuth_start is {value}; it must be finite")]
    AzimuthStart { value: f64 },
    /// No span, or more than a turn.
    #[error("azimuth_span is {value} rad; it must be greater than 0 and at most 2 pi")]
    AzimuthSpan { value: f64 },
    /// Range limits with no range between them.
    #[error("min_range is {min} m and max_range is {max} m; it must be 0 <= min_range < max_range <= 1e9")]
    RangeLimits { min: f64, max: f64 },
    /// An image of another sensor.
    #[error("the image has {rows} x {columns} pixels; the sensor has {beams} beams and {pattern_columns} columns")]
    ImageShape { rows: usize, columns: usize, beams: usize, pattern_columns: usize },
    /// A distance that is negative, NaN or infinite.
    #[error("depth[{row}, {column}] is {value}; it must be finite and >= 0")]
    Depth { row: usize, column: usize, value: f32 },

    /// A table of primitives that is longer or shorter than the others.
    #[error("{table} has {entries} entries; there are {primitives} primitives")]
    PrimitiveTable { table: &'static str, entries: usize, primitives: usize },
    /// A table of points that is longer or shorter than the others.
    #[error("{table} has {entries} entries; there are {points} points")]
    PointTable { table: &'static str, entries: usize, points: usize },
    /// A table or an image whose rows have the wrong length.
    #[error("{table} has the shape {shape:?}; it must be {expected}")]
    TableShape { table: String, shape: Vec<usize>, expected: String },
    /// A number that is not a shape.
    #[error("shapes[{primitive}] is {code}; it must be 0 box, 1 ellipsoid, 2 cylinder, 3 plane or 4 mesh")]
    ShapeCode { primitive: usize, code: u8 },
    /// More or fewer meshes than primitives of shape mesh.
    #[error("there are {meshes} meshes; {primitives} primitives have the shape mesh")]
    MeshCount { meshes: usize, primitives: usize },
    /// A mesh that is invalid.
    #[error("meshes[{mesh}]: {source}")]
    Mesh { mesh: usize, source: Box<Error> },
    /// A mesh that reaches too far after scaling.
    #[error(
        "vertex {vertex} of the mesh of primitive {primitive} is {value:?} m from its center; the limit is {limit:e}"
    )]
    MeshReach { primitive: usize, vertex: usize, value: [f64; 3], limit: f64 },
    /// A primitive with an invalid place.
    #[error("centers[{primitive}] is {value:?} m; every coordinate must be finite and at most {limit:e} in size")]
    Center { primitive: usize, value: [f64; 3], limit: f64 },
    /// A primitive without extent.
    #[error("sizes[{primitive}] is {value:?} m; {rule}, and none may exceed {limit:e}")]
    Size { primitive: usize, value: [f64; 3], rule: &'static str, limit: f64 },
    /// A turn that is NaN or infinite.
    #[error("yaws[{primitive}] is {value}; it must be finite")]
    Yaw { primitive: usize, value: f64 },

    /// A medium with an invalid density.
    #[error("extinctions[{primitive}] is {value} per metre; it must be finite and greater than 0, or 0 for a solid")]
    Extinction { primitive: usize, value: f64 },
    /// A medium without volume.
    #[error("primitive {primitive} is a plane with an extinction; only what has a volume can be a medium")]
    PlaneMedium { primitive: usize },
    /// A medium with a hole in its surface.
    #[error(
        "primitive {primitive} is an open mesh with an extinction: no triangle runs from vertex {to} to vertex {from}, \
         against the one that runs from {from} to {to}, or there are more; only a closed mesh can be a medium"
    )]
    OpenMedium { primitive: usize, from: u32, to: u32 },

    /// More or fewer poses than primitives to move.
    #[error("primitives has {primitives} entries and world_from_primitive has {poses}; it must be one pose for each")]
    MovedCount { primitives: usize, poses: usize },
    /// A primitive to move that the scene does not have.
    #[error("primitives[{entry}] is {primitive}; the scene has {count} primitives")]
    MovedIndex { entry: usize, primitive: u32, count: usize },
    /// A primitive that is moved to two places.
    #[error("primitives[{entry}] is {primitive}, as is primitives[{first}]; a primitive can be moved once")]
    MovedTwice { entry: usize, first: usize, primitive: u32 },

    /// A pose with an entry that is NaN or infinite, or too far away.
    #[error("entry [{row}, {column}] of the pose is {value}; it must be finite and at most {limit:e} in size")]
    PoseEntry { row: usize, column: usize, value: f64, limit: f64 },
    /// A pose that is projective.
    #[error("the last row of the pose is {value:?}; it must be [0, 0, 0, 1]")]
    PoseLastRow { value: [f64; 4] },
    /// A pose that scales or shears.
    #[error("the rotation of the pose is off R^T R = 1 by {deviation:e}; the limit is {limit:e}")]
    PoseNotRigid { deviation: f64, limit: f64 },
    /// A pose that mirrors.
    #[error("the rotation of the pose has the determinant {determinant}; a mirrored pose is not rigid")]
    PoseMirrored { determinant: f64 },
    /// An entry of a table of poses that is not a pose.
    #[error("{table}{index:?}: {source}")]
    PoseOfTable { table: &'static str, index: Vec<usize>, source: Box<Error> },
    /// Neither one pose for a scan nor one for each of its columns.
    #[error("there are {poses} poses for a scan; it must be 1, or {columns}, one for each column")]
    PoseCount { poses: usize, columns: usize },
    /// Lists of poses and images that differ in length.
    #[error("there are poses for {scans} scans and images for {images}; there must be as many")]
    ScanCount { scans: usize, images: usize },
    /// An image that has more or fewer pixels than the pattern.
    #[error("the {image} image has {pixels} pixels; the sensor has {rows} beams and {columns} columns")]
    ImageSize { image: &'static str, pixels: usize, rows: usize, columns: usize },
    /// An array for images of other scans or another pattern.
    #[error("{image} has the shape {shape:?}; it must be {expected:?} for these poses and this sensor")]
    OutputShape { image: &'static str, shape: Vec<usize>, expected: Vec<usize> },
    /// A beam without sub-rays, or with more than a receiver sums up.
    #[error("a beam has {rays} sub-rays; it must be 1 to {limit}")]
    Rays { rays: usize, limit: usize },
    /// An invalid number of a sensor model.
    #[error("{field} is {value}; it must be {limit}")]
    SensorModel { field: &'static str, value: f32, limit: &'static str },
    /// A table of an intensity curve that does not fit its knots or the beams of the sensor.
    #[error("{table} of the intensity curve has {found} values; it needs {expected}")]
    CurveTable { table: &'static str, found: usize, expected: usize },
    /// Range offsets that are neither one for each beam nor none.
    #[error("range_offsets has {found} values; it needs one for each of {expected} beams")]
    OffsetTable { found: usize, expected: usize },
    /// An image with more or fewer pixels than a sensor with these sub-rays.
    #[error("the {image} image has {pixels} pixels; the sensor model needs {expected}")]
    ObservedSize { image: &'static str, pixels: usize, expected: usize },
    /// A column of surfaces that is longer or shorter than the table of responses.
    #[error("{column} has {found} entries; the table of responses has {entries}")]
    SurfaceColumn { column: &'static str, found: usize, entries: usize },
    /// An image with a primitive that the layout does not have.
    #[error("the image shows primitive {primitive}; the layout has {primitives}")]
    ImagePrimitive { primitive: i32, primitives: usize },

    /// A backend that this machine does not have.
    #[error("backend is {given:?}; it must be one of {available}")]
    Backend { given: String, available: String },
    /// An invalid seed.
    #[error("seed is {seed}; it must be 0 or more")]
    Seed { seed: i64 },
    /// An invalid number of threads.
    #[error("threads is {threads}; it must be 0 (all cores) to {limit}")]
    Threads { threads: i64, limit: usize },

    /// Lists of origins and directions that differ in length.
    #[error("there are {origins} origins and {directions} directions; there must be as many")]
    RayCount { origins: usize, directions: usize },
    /// A ray with an invalid origin.
    #[error("origins[{ray}] is {value:?} m; every coordinate must be finite and at most {limit:e} in size")]
    RayOrigin { ray: usize, value: [f64; 3], limit: f64 },
    /// A ray without a direction.
    #[error("directions[{ray}] is {value:?}; it must be finite and not 0")]
    RayDirection { ray: usize, value: [f64; 3] },
    /// An invalid range.
    #[error("max_range is {value} m; it must be greater than 0")]
    MaxRange { value: f64 },
}
