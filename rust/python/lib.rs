//! `lidardraft._core`: numpy arrays in, numpy arrays out. The stub file `_core.pyi` is its documentation.

mod arrays;
mod cloud;
mod errors;
mod images;
mod poses;
mod sensor_model;

use std::path::PathBuf;

use lidardraft_core as core;
use numpy::ndarray::Ix1;
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use arrays::{Column, Table, array, rows, shaped, table_shape};
use errors::{CoreError, CoreResult};
use images::{Given, Outputs};
use poses::{primitive_poses, sensor_poses};

/// An array of any shape, on its way out.
type Out<'py, T> = Bound<'py, PyArrayDyn<T>>;

/// The map from (row, column) to a ray.
#[pyclass(frozen, module = "lidardraft._core")]
struct SensorPattern(core::SensorPattern);

#[pymethods]
impl SensorPattern {
    #[new]
    #[pyo3(signature = (*, elevations, azimuth_offsets, origins, columns, azimuth_start, azimuth_span, min_range, max_range))]
    #[expect(clippy::too_many_arguments, reason = "keyword-only in Python")]
    fn new(
        elevations: &Bound<'_, PyAny>,
        azimuth_offsets: &Bound<'_, PyAny>,
        origins: &Bound<'_, PyAny>,
        columns: i64,
        azimuth_start: f64,
        azimuth_span: f64,
        min_range: f64,
        max_range: f64,
    ) -> PyResult<Self> {
        let origins: Table<'_, f64> = array("origins", origins)?;
        let spec = core::SensorSpec {
            elevations: vector("elevations", elevations)?,
            azimuth_offsets: vector("azimuth_offsets", azimuth_offsets)?,
            origins: rows("origins", &origins, "[H, 3]")?.to_vec(),
            // A negative number is as wrong as 0, and is named in the message.
            columns: usize::try_from(columns).unwrap_or_default(),
            azimuth_start,
            azimuth_span,
            min_range,
            max_range,
        };
        match core::SensorPattern::new(spec) {
            Ok(pattern) => Ok(SensorPattern(pattern)),
            Err(core::Error::Columns { limit, .. }) => {
                Err(CoreError::from(core::Error::Columns { columns, limit }).into())
            }
            Err(error) => Err(CoreError::from(error).into()),
        }
    }

    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.rows(), self.0.columns())
    }

    fn directions<'py>(&self, py: Python<'py>) -> PyResult<Out<'py, f64>> {
        let directions = py.detach(|| self.0.directions());
        shaped(py, directions.into_flattened(), [self.0.rows(), self.0.columns(), 3])
    }

    fn origins<'py>(&self, py: Python<'py>) -> PyResult<Out<'py, f64>> {
        let origins = py.detach(|| self.0.origins());
        shaped(py, origins.into_flattened(), [self.0.rows(), self.0.columns(), 3])
    }

    fn points<'py>(&self, py: Python<'py>, depth: &Bound<'py, PyAny>) -> PyResult<Out<'py, f64>> {
        let depth: Table<'_, f32> = array("depth", depth)?;
        let (shape, values) = ([depth.shape()[0], depth.shape()[1]], depth.as_slice()?);
        let points = py.detach(|| self.0.points(values, shape)).map_err(CoreError::from)?;
        shaped(py, points.into_flattened(), [shape[0], shape[1], 3])
    }

    fn project<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<(Out<'py, i32>, Out<'py, i32>, Out<'py, f32>)> {
        let table: Table<'_, f64> = array("points", points)?;
        let points = rows("points", &table, "[N, 3]")?;
        let count = [points.len()];
        let found = py.detach(|| self.0.project(points));
        Ok((shaped(py, found.rows, count)?, shaped(py, found.columns, count)?, shaped(py, found.distances, count)?))
    }
}

/// Shapes with class and instance, compiled for casting.
#[pyclass(frozen, module = "lidardraft._core")]
struct Scene(core::Scene);

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (*, shapes, centers, sizes, yaws, labels, instances, meshes, extinctions=None, media=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword-only in Python")]
    fn new(
        py: Python<'_>,
        shapes: &Bound<'_, PyAny>,
        centers: &Bound<'_, PyAny>,
        sizes: &Bound<'_, PyAny>,
        yaws: &Bound<'_, PyAny>,
        labels: &Bound<'_, PyAny>,
        instances: &Bound<'_, PyAny>,
        meshes: Vec<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
        extinctions: Option<&Bound<'_, PyAny>>,
        media: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let shapes: Column<'_, u8> = array("shapes", shapes)?;
        let centers: Table<'_, f64> = array("centers", centers)?;
        let sizes: Table<'_, f64> = array("sizes", sizes)?;
        let yaws: Column<'_, f64> = array("yaws", yaws)?;
        let labels: Column<'_, u8> = array("labels", labels)?;
        let instances: Column<'_, u32> = array("instances", instances)?;
        let extinctions: Option<Column<'_, f64>> =
            extinctions.map(|argument| array("extinctions", argument)).transpose()?;
        let meshes = meshes.iter().enumerate().map(|(i, mesh)| triangle_mesh(i, mesh));
        let meshes = meshes.collect::<PyResult<Vec<_>>>()?;
        let tables = core::PrimitiveTables {
            shapes: shapes.as_slice()?,
            centers: rows("centers", &centers, "[P, 3]")?,
            sizes: rows("sizes", &sizes, "[P, 3]")?,
            yaws: yaws.as_slice()?,
            labels: labels.as_slice()?,
            instances: instances.as_slice()?,
            extinctions: extinctions.as_ref().map_or(Ok(&[][..]), |column| column.as_slice())?,
        };
        let media: Option<Column<'_, u32>> = media.map(|argument| array("media", argument)).transpose()?;
        let media = media.as_ref().map(|column| column.as_slice()).transpose()?.map(<[u32]>::to_vec);
        let scene = py.detach(|| {
            let scene = core::Scene::new(tables.primitives(meshes)?)?;
            if let Some(media) = media { scene.with_media(media) } else { Ok(scene) }
        });
        Ok(Scene(scene.map_err(CoreError::from)?))
    }

    #[staticmethod]
    fn joined(
        py: Python<'_>,
        scenes: Vec<Bound<'_, Scene>>,
        primitives: Vec<Bound<'_, PyAny>>,
        origin: Option<[f64; 3]>,
    ) -> PyResult<Self> {
        let name = |i: usize| format!("primitives[{i}]");
        let columns = primitives.iter().enumerate().map(|(i, some)| array(&name(i), some));
        let columns: Vec<Column<'_, u32>> = columns.collect::<PyResult<_>>()?;
        let some = columns.iter().map(|column| column.as_slice()).collect::<Result<Vec<_>, _>>()?;
        let parts: Vec<(&core::Scene, &[u32])> = scenes.iter().map(|scene| &scene.get().0).zip(some).collect();
        let scene = py.detach(|| core::Scene::joined(&parts, origin.map(Into::into)));
        Ok(Scene(scene.map_err(CoreError::from)?))
    }

    #[getter]
    fn origin(&self) -> [f64; 3] {
        self.0.origin().to_array()
    }

    fn moved(
        &self,
        py: Python<'_>,
        primitives: &Bound<'_, PyAny>,
        world_from_primitive: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let primitives: Column<'_, u32> = array("primitives", primitives)?;
        let poses = primitive_poses(world_from_primitive)?;
        let primitives = primitives.as_slice()?;
        let scene = py.detach(|| self.0.moved(primitives, &poses));
        Ok(Scene(scene.map_err(CoreError::from)?))
    }

    #[pyo3(signature = (pattern, world_from_sensor, *, depth, label, instance, primitive=None, incidence=None, normal=None, seed=0, threads=0, backend=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword-only in Python")]
    fn scan(
        &self,
        py: Python<'_>,
        pattern: &SensorPattern,
        world_from_sensor: &Bound<'_, PyAny>,
        depth: &Bound<'_, PyAny>,
        label: &Bound<'_, PyAny>,
        instance: &Bound<'_, PyAny>,
        primitive: Option<&Bound<'_, PyAny>>,
        incidence: Option<&Bound<'_, PyAny>>,
        normal: Option<&Bound<'_, PyAny>>,
        seed: i64,
        threads: i64,
        backend: Option<&str>,
    ) -> PyResult<()> {
        let (rows, columns) = (pattern.0.rows(), pattern.0.columns());
        let (seed, threads) = (checked_seed(seed)?, thread_count(threads)?);
        let backend = backend.map(str::parse::<core::Backend>).transpose().map_err(CoreError::from)?;
        let (poses, scans, each) = sensor_poses(world_from_sensor, columns)?;
        let given = Given { depth, label, instance, primitive, incidence, normal };
        let mut outputs = Outputs::new(&given, [scans, rows, columns])?;
        let mut all = outputs.images()?;
        let done = py.detach(|| {
            let poses: Vec<&[core::Pose]> = poses.chunks(each).collect();
            core::scan_batch(&self.0, &pattern.0, &poses, seed, &mut all.pieces(rows * columns), backend, threads)
        });
        Ok(done.map_err(CoreError::from)?)
    }

    #[pyo3(signature = (origins, directions, *, max_range=f64::INFINITY, seed=0, threads=0))]
    #[expect(clippy::type_complexity, reason = "the tuple of the stub file")]
    fn cast<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        max_range: f64,
        seed: i64,
        threads: i64,
    ) -> PyResult<(Out<'py, f32>, Out<'py, u8>, Out<'py, u32>, Out<'py, i32>, Out<'py, f32>)> {
        let (seed, threads) = (checked_seed(seed)?, thread_count(threads)?);
        let origins: Table<'_, f64> = array("origins", origins)?;
        let directions: Table<'_, f64> = array("directions", directions)?;
        let origins = rows("origins", &origins, "[R, 3]")?;
        let directions = rows("directions", &directions, "[R, 3]")?;
        let hits = py.detach(|| core::cast(&self.0, origins, directions, max_range, seed, threads));
        let hits = hits.map_err(CoreError::from)?;
        let count = hits.distance.len();
        Ok((
            shaped(py, hits.distance, [count])?,
            shaped(py, hits.label, [count])?,
            shaped(py, hits.instance, [count])?,
            shaped(py, hits.primitive, [count])?,
            shaped(py, hits.normal.into_flattened(), [count, 3])?,
        ))
    }
}

#[pyfunction]
fn backends() -> Vec<&'static str> {
    core::Backend::available().into_iter().map(core::Backend::name).collect()
}

#[pyfunction]
#[expect(clippy::type_complexity, reason = "the list of the stub file")]
fn read_obj(
    py: Python<'_>,
    path: PathBuf,
) -> PyResult<Vec<(String, String, Out<'_, f64>, Out<'_, u32>, Out<'_, u32>)>> {
    let meshes = py.detach(|| core::read_obj(&path)).map_err(CoreError::from)?;
    let entry = |entry: core::ObjMesh| {
        let (vertices, corners, counts) = (entry.vertices.len(), entry.corners.len(), entry.counts.len());
        Ok((
            entry.object,
            entry.material,
            shaped(py, entry.vertices.into_flattened(), [vertices, 3])?,
            shaped(py, entry.corners, [corners])?,
            shaped(py, entry.counts, [counts])?,
        ))
    };
    meshes.into_iter().map(entry).collect()
}

#[pyfunction]
fn lay<'py>(
    py: Python<'py>,
    mesh: (Bound<'py, PyAny>, Bound<'py, PyAny>),
    x: &Bound<'py, PyAny>,
    y: &Bound<'py, PyAny>,
    heights: &Bound<'py, PyAny>,
) -> PyResult<(Out<'py, f64>, Out<'py, u32>)> {
    let (mesh, x, y) = (triangle_mesh(0, &mesh)?, vector("x", x)?, vector("y", y)?);
    let table: Table<'_, f64> = array("heights", heights)?;
    if table.shape() != [x.len(), y.len()] || x.len().min(y.len()) < 2 {
        return Err(table_shape("heights", table.shape(), "[X, Y] of two lines or more"));
    }
    let heights = table.as_slice()?;
    let (vertices, faces) = py.detach(|| core::Relief { x: &x, y: &y, heights }.lay(&mesh));
    let (count, number) = (vertices.len(), faces.len());
    Ok((shaped(py, vertices.into_flattened(), [count, 3])?, shaped(py, faces.into_flattened(), [number, 3])?))
}

fn vector(name: &str, argument: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let values: Column<'_, f64> = array::<f64, Ix1>(name, argument)?;
    Ok(values.as_slice()?.to_vec())
}

/// More threads than any machine has cores are a mistake.
const MOST_THREADS: usize = 1024;

fn thread_count(threads: i64) -> CoreResult<usize> {
    let count = usize::try_from(threads).ok().filter(|&count| count <= MOST_THREADS);
    Ok(count.ok_or(core::Error::Threads { threads, limit: MOST_THREADS })?)
}

fn checked_seed(seed: i64) -> CoreResult<u64> {
    Ok(u64::try_from(seed).map_err(|_| core::Error::Seed { seed })?)
}

fn triangle_mesh(
    mesh: usize,
    (vertices, faces): &(Bound<'_, PyAny>, Bound<'_, PyAny>),
) -> PyResult<core::TriangleMesh> {
    let (v, f) = (format!("meshes[{mesh}][0]"), format!("meshes[{mesh}][1]"));
    let vertices: Table<'_, f64> = array(&v, vertices)?;
    let faces: Table<'_, u32> = array(&f, faces)?;
    let vertices = rows(&v, &vertices, "[V, 3]")?.to_vec();
    let faces = rows(&f, &faces, "[F, 3]")?.to_vec();
    let named = |source| core::Error::Mesh { mesh, source: Box::new(source) };
    Ok(core::TriangleMesh::new(vertices, faces).map_err(named).map_err(CoreError::from)?)
}

/// The compiled core of lidardraft.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<SensorPattern>()?;
    module.add_class::<Scene>()?;
    module.add_class::<cloud::Cloud>()?;
    module.add_class::<cloud::HeightField>()?;
    module.add_class::<sensor_model::SensorModel>()?;
    module.add_function(wrap_pyfunction!(cloud::cluster, module)?)?;
    module.add_function(wrap_pyfunction!(cloud::fit_box, module)?)?;
    module.add_function(wrap_pyfunction!(backends, module)?)?;
    module.add_function(wrap_pyfunction!(sensor_model::observe, module)?)?;
    module.add_function(wrap_pyfunction!(read_obj, module)?)?;
    module.add_function(wrap_pyfunction!(lay, module)?)?;
    module.add("DEBUG", cfg!(debug_assertions))
}
