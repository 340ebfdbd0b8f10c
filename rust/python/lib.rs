//! `lidardraft._core`: numpy arrays in, numpy arrays out. The stub file `_core.pyi` is its documentation.

mod arrays;
mod errors;

use std::path::PathBuf;

use lidardraft_core as core;
use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use arrays::{Column, Table, array, rows, shaped};
use errors::{CoreError, CoreResult};

/// An array of any shape, on its way out.
type Out<'py, T> = Bound<'py, PyArrayDyn<T>>;

/// The map from (row, column) to a ray.
#[pyclass(frozen, module = "lidardraft._core")]
struct SensorPattern(core::SensorPattern);

#[pymethods]
impl SensorPattern {
    #[new]
    #[pyo3(signature = (*, elevations, azimuth_offsets, origin_heights, columns, azimuth_start, azimuth_span, min_range, max_range))]
    #[expect(clippy::too_many_arguments, reason = "keyword-only in Python")]
    fn new(
        elevations: &Bound<'_, PyAny>,
        azimuth_offsets: &Bound<'_, PyAny>,
        origin_heights: &Bound<'_, PyAny>,
        columns: i64,
        azimuth_start: f64,
        azimuth_span: f64,
        min_range: f64,
        max_range: f64,
    ) -> PyResult<Self> {
        let spec = core::SensorSpec {
            elevations: vector("elevations", elevations)?,
            azimuth_offsets: vector("azimuth_offsets", azimuth_offsets)?,
            origin_heights: vector("origin_heights", origin_heights)?,
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
    #[pyo3(signature = (*, shapes, centers, sizes, yaws, labels, instances, meshes))]
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
    ) -> PyResult<Self> {
        let shapes: Column<'_, u8> = array("shapes", shapes)?;
        let centers: Table<'_, f64> = array("centers", centers)?;
        let sizes: Table<'_, f64> = array("sizes", sizes)?;
        let yaws: Column<'_, f64> = array("yaws", yaws)?;
        let labels: Column<'_, u8> = array("labels", labels)?;
        let instances: Column<'_, u32> = array("instances", instances)?;
        let meshes = meshes.iter().enumerate().map(|(i, mesh)| triangle_mesh(i, mesh));
        let meshes = meshes.collect::<PyResult<Vec<_>>>()?;
        let tables = core::PrimitiveTables {
            shapes: shapes.as_slice()?,
            centers: rows("centers", &centers, "[P, 3]")?,
            sizes: rows("sizes", &sizes, "[P, 3]")?,
            yaws: yaws.as_slice()?,
            labels: labels.as_slice()?,
            instances: instances.as_slice()?,
        };
        let scene = py.detach(|| core::Scene::new(tables.primitives(meshes)?));
        Ok(Scene(scene.map_err(CoreError::from)?))
    }

    #[expect(clippy::type_complexity, reason = "the tuple of the stub file")]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        pattern: &SensorPattern,
        world_from_sensor: &Bound<'py, PyAny>,
    ) -> PyResult<(Out<'py, f32>, Out<'py, u8>, Out<'py, u32>, Out<'py, i32>, Out<'py, f32>)> {
        let pose = pose(world_from_sensor)?;
        let images = py.detach(|| core::scan(&self.0, &pattern.0, &pose));
        let shape = [images.rows, images.columns];
        Ok((
            shaped(py, images.depth, shape)?,
            shaped(py, images.label, shape)?,
            shaped(py, images.instance, shape)?,
            shaped(py, images.primitive, shape)?,
            shaped(py, images.incidence, shape)?,
        ))
    }
}

#[pyfunction]
#[expect(clippy::type_complexity, reason = "the list of the stub file")]
fn read_obj(py: Python<'_>, path: PathBuf) -> PyResult<Vec<(String, String, Out<'_, f64>, Out<'_, u32>)>> {
    let meshes = py.detach(|| core::read_obj(&path)).map_err(CoreError::from)?;
    let entry = |entry: core::ObjMesh| {
        let (vertices, faces) = entry.mesh.into_parts();
        let (v, f) = (vertices.len(), faces.len());
        Ok((
            entry.object,
            entry.material,
            shaped(py, vertices.into_flattened(), [v, 3])?,
            shaped(py, faces.into_flattened(), [f, 3])?,
        ))
    };
    meshes.into_iter().map(entry).collect()
}

fn vector(name: &str, argument: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let values: Column<'_, f64> = array::<f64, Ix1>(name, argument)?;
    Ok(values.as_slice()?.to_vec())
}

fn pose(argument: &Bound<'_, PyAny>) -> PyResult<core::Pose> {
    let table: Table<'_, f64> = array::<f64, Ix2>("world_from_sensor", argument)?;
    Ok(pose_from_table(&table)?)
}

fn pose_from_table(table: &Table<'_, f64>) -> CoreResult<core::Pose> {
    let entries = rows("world_from_sensor", table, "[4, 4]")?;
    let matrix = <[[f64; 4]; 4]>::try_from(entries).map_err(|_| core::Error::TableShape {
        table: "world_from_sensor".to_owned(),
        shape: table.shape().to_vec(),
        expected: "[4, 4]",
    })?;
    Ok(core::Pose::from_rows(matrix)?)
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
    module.add_function(wrap_pyfunction!(read_obj, module)?)
}
