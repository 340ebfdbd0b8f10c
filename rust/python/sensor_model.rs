//! The sensor model: its constants, checked once; arrays of images and surfaces in, images written in place.

use lidardraft_core::Error;
use lidardraft_core::sensor_model as core;
use numpy::ndarray::Ix2;
use numpy::{Element, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::arrays::{Column, Table, array, misaligned, rows, writable};
use crate::errors::{CoreError, CoreResult};
use crate::poses::sensor_poses;
use crate::{SensorPattern, checked_seed, thread_count};

/// The effects of one unit of a sensor.
#[pyclass(frozen, module = "lidardraft._core")]
pub(crate) struct SensorModel(core::SensorModel);

/// The tables of Python's `IntensityCurve`.
#[derive(FromPyObject)]
struct CurveTables {
    responses: Vec<f32>,
    readings: Vec<Vec<f32>>,
    distances: Vec<f32>,
    distance_gains: Vec<Vec<f32>>,
    cutoffs: Vec<f32>,
}

/// The attribute `name` of a Python object.
fn attribute<'py, T: FromPyObjectOwned<'py>>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<T> {
    object.getattr(name)?.extract().map_err(Into::into)
}

#[pymethods]
impl SensorModel {
    #[new]
    fn new(numbers: &Bound<'_, PyAny>, shares: Vec<f32>) -> PyResult<Self> {
        let unit: i64 = attribute(numbers, "unit")?;
        let curve: Option<CurveTables> = attribute(numbers, "intensity_curve")?;
        let curve = curve.map(|tables| {
            let CurveTables { responses, readings, distances, distance_gains, cutoffs } = tables;
            core::IntensityCurve::new(&responses, &readings, &distances, &distance_gains, cutoffs)
        });
        let model = core::SensorModel {
            shares,
            unit: u64::try_from(unit).map_err(|_| CoreError::from(negative_unit(unit)))?,
            intensity_curve: curve.transpose().map_err(CoreError::from)?,
            pulse_duration: attribute(numbers, "pulse_duration")?,
            detection_threshold: attribute(numbers, "detection_threshold")?,
            last_return: attribute(numbers, "last_return")?,
            glass_transmission: attribute(numbers, "glass_transmission")?,
            speckle: attribute(numbers, "speckle")?,
            texture: attribute(numbers, "texture")?,
            material_noise: attribute(numbers, "material_noise")?,
            dust: attribute(numbers, "dust")?,
            fading: attribute(numbers, "fading")?,
            drop_exponent: attribute(numbers, "drop_exponent")?,
            edge_drop: attribute(numbers, "edge_drop")?,
            range_offsets: attribute(numbers, "range_offsets")?,
            offset_spread: attribute(numbers, "offset_spread")?,
            gain_spread: attribute(numbers, "gain_spread")?,
            jitter: attribute(numbers, "jitter")?,
            range_step: attribute(numbers, "range_step")?,
            full_scale: attribute(numbers, "full_scale")?,
            knee: attribute(numbers, "knee")?,
            cutoff: attribute(numbers, "cutoff")?,
            cutoff_spread: attribute(numbers, "cutoff_spread")?,
            levels: attribute(numbers, "levels")?,
            least_reading: attribute(numbers, "least_reading")?,
            compensation_range: attribute(numbers, "compensation_range")?,
        };
        model.check().map_err(CoreError::from)?;
        Ok(SensorModel(model))
    }

    #[getter]
    fn pulse_length(&self) -> f64 {
        self.0.pulse_length()
    }
}

#[pyfunction]
#[pyo3(signature = (image, surfaces, *, rays, poses, pattern, range_sigma, model, extinction=0.0, backscatter=Vec::new(), scan, seed=0, threads=0))]
#[expect(clippy::too_many_arguments, reason = "keyword-only in Python")]
pub(crate) fn observe(
    py: Python<'_>,
    image: &Bound<'_, PyAny>,
    surfaces: &Bound<'_, PyAny>,
    rays: &SensorPattern,
    poses: &Bound<'_, PyAny>,
    pattern: &SensorPattern,
    range_sigma: f32,
    model: &SensorModel,
    extinction: f32,
    backscatter: Vec<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
    scan: &Bound<'_, PyAny>,
    seed: i64,
    threads: i64,
) -> PyResult<()> {
    let (seed, threads) = (checked_seed(seed)?, thread_count(threads)?);
    let (image, surfaces) = (Image::of(image)?, Surfaces::of(surfaces)?);
    let backscatter = backscatter.iter().map(Backscatter::of).collect::<PyResult<Vec<_>>>()?;
    let backscatter = backscatter.iter().map(Backscatter::slices).collect::<PyResult<Vec<_>>>()?;
    let mut scan = Scan::of(scan)?;
    let (poses, _, _) = sensor_poses(poses, pattern.0.columns())?;
    let light = core::Light {
        returns: image.slices()?,
        surfaces: surfaces.slices()?,
        backscatter: &backscatter,
        extinction,
        shape: [pattern.0.rows(), pattern.0.columns()],
        places: core::Places { rays: &rays.0, poses: &poses },
    };
    let (min, max) = (pattern.0.spec().min_range as f32, pattern.0.spec().max_range as f32);
    let ranging = core::Ranging { sigma: range_sigma, min, max };
    let mut written = scan.slices()?;
    let done: CoreResult<()> =
        py.detach(|| core::observe(&light, ranging, &model.0, seed, &mut written, threads)).map_err(CoreError::from);
    Ok(done?)
}

fn negative_unit(unit: i64) -> Error {
    Error::SensorModel { field: "unit", value: unit as f32, limit: "0 or more" }
}

/// The arrays of the `RangeImage` of sub-rays.
struct Image<'py> {
    depth: PyReadonlyArray2<'py, f32>,
    label: PyReadonlyArray2<'py, u8>,
    instance: PyReadonlyArray2<'py, u32>,
    primitive: PyReadonlyArray2<'py, i32>,
    incidence: PyReadonlyArray2<'py, f32>,
}

impl<'py> Image<'py> {
    fn of(image: &Bound<'py, PyAny>) -> PyResult<Image<'py>> {
        Ok(Image {
            depth: read(image, "depth")?,
            label: read(image, "label")?,
            instance: read(image, "instance")?,
            primitive: read(image, "primitive")?,
            incidence: read(image, "incidence")?,
        })
    }

    fn slices(&self) -> PyResult<core::Returns<'_>> {
        Ok(core::Returns {
            depth: flat("depth", &self.depth)?,
            label: flat("label", &self.label)?,
            instance: flat("instance", &self.instance)?,
            primitive: flat("primitive", &self.primitive)?,
            incidence: flat("incidence", &self.incidence)?,
        })
    }
}

/// The arrays of `Surfaces`.
struct Surfaces<'py> {
    table: Table<'py, f32>,
    transmission: Column<'py, f32>,
    behind: Column<'py, f32>,
    grain: Column<'py, f32>,
    texture: Column<'py, f32>,
    rms_height: Column<'py, f32>,
    unevenness: Column<'py, f32>,
}

impl<'py> Surfaces<'py> {
    fn of(surfaces: &Bound<'py, PyAny>) -> PyResult<Surfaces<'py>> {
        Ok(Surfaces {
            table: read(surfaces, "table")?,
            transmission: array("transmission", &surfaces.getattr("transmission")?)?,
            behind: array("behind", &surfaces.getattr("behind")?)?,
            grain: array("grain", &surfaces.getattr("grain")?)?,
            texture: array("texture", &surfaces.getattr("texture")?)?,
            rms_height: array("rms_height", &surfaces.getattr("rms_height")?)?,
            unevenness: array("unevenness", &surfaces.getattr("unevenness")?)?,
        })
    }

    fn slices(&self) -> PyResult<core::Surfaces<'_>> {
        Ok(core::Surfaces {
            table: rows("table", &self.table, "[P + 1, 128]")?,
            transmission: self.transmission.as_slice()?,
            behind: self.behind.as_slice()?,
            grain: self.grain.as_slice()?,
            texture: self.texture.as_slice()?,
            rms_height: self.rms_height.as_slice()?,
            unevenness: self.unevenness.as_slice()?,
        })
    }
}

/// Range and response of particles in the air.
struct Backscatter<'py> {
    depth: PyReadonlyArray2<'py, f32>,
    response: PyReadonlyArray2<'py, f32>,
}

impl<'py> Backscatter<'py> {
    fn of((depth, response): &(Bound<'py, PyAny>, Bound<'py, PyAny>)) -> PyResult<Backscatter<'py>> {
        Ok(Backscatter {
            depth: array("backscatter depth", depth)?,
            response: array("backscatter response", response)?,
        })
    }

    fn slices(&self) -> PyResult<core::Backscatter<'_>> {
        let (depth, response) =
            (flat("backscatter depth", &self.depth)?, flat("backscatter response", &self.response)?);
        Ok(core::Backscatter { depth, response })
    }
}

/// The arrays of the `RangeImage` that is written.
struct Scan<'py> {
    depth: PyReadwriteArray2<'py, f32>,
    label: PyReadwriteArray2<'py, u8>,
    instance: PyReadwriteArray2<'py, u32>,
    primitive: PyReadwriteArray2<'py, i32>,
    incidence: PyReadwriteArray2<'py, f32>,
    intensity: PyReadwriteArray2<'py, f32>,
}

impl<'py> Scan<'py> {
    fn of(scan: &Bound<'py, PyAny>) -> PyResult<Scan<'py>> {
        Ok(Scan {
            depth: written(scan, "depth")?,
            label: written(scan, "label")?,
            instance: written(scan, "instance")?,
            primitive: written(scan, "primitive")?,
            incidence: written(scan, "incidence")?,
            intensity: written(scan, "intensity")?,
        })
    }

    fn slices(&mut self) -> PyResult<core::ReturnsMut<'_>> {
        Ok(core::ReturnsMut {
            depth: self.depth.as_slice_mut()?,
            label: self.label.as_slice_mut()?,
            instance: self.instance.as_slice_mut()?,
            primitive: self.primitive.as_slice_mut()?,
            incidence: self.incidence.as_slice_mut()?,
            intensity: self.intensity.as_slice_mut()?,
        })
    }
}

fn read<'py, T: Element>(of: &Bound<'py, PyAny>, name: &str) -> PyResult<PyReadonlyArray2<'py, T>> {
    array::<T, Ix2>(name, &of.getattr(name)?)
}

fn written<'py, T: Element>(of: &Bound<'py, PyAny>, name: &str) -> PyResult<PyReadwriteArray2<'py, T>> {
    writable::<T, Ix2>(name, &of.getattr(name)?)
}

fn flat<'a, T: Element>(name: &str, image: &'a PyReadonlyArray2<'_, T>) -> PyResult<&'a [T]> {
    image.as_slice().map_err(|_| misaligned(name))
}
