//! Labelled points, and the shapes made from them.

use lidardraft_core::cloud::{self as core, FittedBox};
use lidardraft_core::{Error, Shape};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::Out;
use crate::arrays::{Column, Table, array, rows, shaped};
use crate::errors::CoreResult;

/// The points of a scan, and the rays to them.
#[pyclass(frozen, module = "lidardraft._core")]
pub(crate) struct Cloud(core::Cloud);

/// The ground under a cloud.
#[pyclass(frozen, module = "lidardraft._core")]
pub(crate) struct HeightField(core::HeightField);

#[pymethods]
impl Cloud {
    #[new]
    #[pyo3(signature = (points, *, origin, most_rays))]
    fn new(py: Python<'_>, points: &Bound<'_, PyAny>, origin: [f64; 3], most_rays: usize) -> PyResult<Self> {
        let table: Table<'_, f64> = array("points", points)?;
        let points = rows("points", &table, "[N, 3]")?;
        Ok(Cloud(py.detach(|| core::Cloud::new(points, origin, most_rays))))
    }

    fn ground(&self, py: Python<'_>, labels: &Bound<'_, PyAny>, classes: Vec<u8>) -> PyResult<HeightField> {
        let labels: Column<'_, u8> = array("labels", labels)?;
        let labels = self.each("labels", labels.as_slice()?)?;
        Ok(HeightField(py.detach(|| self.0.ground(labels, &classes))))
    }

    fn passed<'py>(
        &self,
        py: Python<'py>,
        weights: &Bound<'py, PyAny>,
        cores: &Bound<'py, PyAny>,
        boxes: &Bound<'py, PyAny>,
    ) -> PyResult<Out<'py, f64>> {
        let weights: Column<'_, f64> = array("weights", weights)?;
        let weights = self.each("weights", weights.as_slice()?)?;
        let (cores, boxes) = (fitted("cores", cores)?, fitted("boxes", boxes)?);
        let found = py.detach(|| self.0.passed(weights, &cores, &boxes));
        let count = found.len();
        shaped(py, found, [count])
    }

    #[pyo3(signature = (*, clusters, crowns, posts, boxes, ground, most_pieces, least_length, worth, grounded))]
    #[expect(clippy::too_many_arguments, reason = "keyword-only in Python")]
    fn refined<'py>(
        &self,
        py: Python<'py>,
        clusters: &Bound<'py, PyAny>,
        crowns: &Bound<'py, PyAny>,
        posts: &Bound<'py, PyAny>,
        boxes: &Bound<'py, PyAny>,
        ground: &HeightField,
        most_pieces: usize,
        least_length: f64,
        worth: f64,
        grounded: bool,
    ) -> PyResult<(Out<'py, u32>, Out<'py, f64>)> {
        let clusters: Column<'_, u32> = array("clusters", clusters)?;
        let crowns: Column<'_, bool> = array("crowns", crowns)?;
        let posts: Column<'_, bool> = array("posts", posts)?;
        let clusters = self.each("clusters", clusters.as_slice()?)?;
        let crowns = self.each("crowns", crowns.as_slice()?)?;
        let shape = |&is_post: &bool| if is_post { Shape::Cylinder } else { Shape::Box };
        let others: Vec<_> = posts.as_slice()?.iter().map(shape).zip(fitted("boxes", boxes)?).collect();
        let detail = core::Detail { most_pieces, least_length, worth, grounded };
        let pieces = py.detach(|| self.0.refined((clusters, crowns), &others, &ground.0, detail));
        let count = pieces.len();
        let (clusters, rows): (Vec<_>, Vec<_>) = pieces.iter().map(|piece| (piece.cluster, piece.around.row())).unzip();
        Ok((shaped(py, clusters, [count])?, shaped(py, rows.into_flattened(), [count, 7])?))
    }
}

impl Cloud {
    /// A column with an entry for each point.
    fn each<'a, T>(&self, table: &'static str, column: &'a [T]) -> CoreResult<&'a [T]> {
        let (entries, points) = (column.len(), self.0.len());
        if entries == points { Ok(column) } else { Err(Error::PointTable { table, entries, points }.into()) }
    }
}

#[pymethods]
impl HeightField {
    fn heights<'py>(&self, py: Python<'py>, places: &Bound<'py, PyAny>) -> PyResult<(Out<'py, f64>, Out<'py, f64>)> {
        let table: Table<'_, f64> = array("places", places)?;
        let places = rows::<f64, 2>("places", &table, "[N, 2]")?;
        let (heights, away): (Vec<_>, Vec<_>) = py.detach(|| places.iter().map(|&place| self.0.height(place)).unzip());
        Ok((shaped(py, heights, [places.len()])?, shaped(py, away, [places.len()])?))
    }

    #[expect(clippy::type_complexity, reason = "the tuple of the stub file")]
    fn grid<'py>(&self, py: Python<'py>) -> PyResult<((i64, i64), Out<'py, f64>, Out<'py, u8>)> {
        let ([x, y], [width, depth]) = self.0.grid();
        let corners = self.0.corners().to_vec();
        Ok(((x, y), shaped(py, corners, [width + 1, depth + 1])?, shaped(py, self.0.labels(), [width, depth])?))
    }
}

fn fitted(name: &str, boxes: &Bound<'_, PyAny>) -> PyResult<Vec<FittedBox>> {
    let table: Table<'_, f64> = array(name, boxes)?;
    Ok(rows(name, &table, "[B, 7]")?.iter().map(FittedBox::from_row).collect())
}

#[pyfunction]
#[pyo3(signature = (points, *, reach, per_range, min_points))]
pub(crate) fn cluster<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    reach: f64,
    per_range: f64,
    min_points: usize,
) -> PyResult<Vec<Bound<'py, PyArray1<u32>>>> {
    let table: Table<'_, f64> = array("points", points)?;
    let points = rows("points", &table, "[N, 3]")?;
    let found = py.detach(|| core::cluster(points, reach, per_range, min_points));
    Ok(found.into_iter().map(|members| PyArray1::from_vec(py, members)).collect())
}

#[pyfunction]
pub(crate) fn fit_box(points: &Bound<'_, PyAny>, outliers: f64) -> PyResult<[f64; 7]> {
    let table: Table<'_, f64> = array("points", points)?;
    let points: Vec<_> = rows::<f64, 3>("points", &table, "[N, 3]")?.iter().map(|&point| point.into()).collect();
    Ok(core::fit_box(&points, outliers).row())
}
