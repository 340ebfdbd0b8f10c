//! The sensor model: objects with arrays and numbers as attributes in, images written in place.

use lidardraft_core::sensor_model as core;
use numpy::ndarray::Ix2;
use numpy::{Element, PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Column, Table, array, misaligned, rows, writable};
use crate::errors::{CoreError, CoreResult};
use crate::{checked_seed, thread_count};

#[pyfunction]
#[pyo3(signature = (image, surfaces, *, sensor, model, shares, extinction=0.0, aloft=Vec::new(), scan, seed=0, threads=0))]
#[expect(clippy::too_many_arguments, reason = "keyword-only in Python")]
pub(crate) fn observe(
    py: Python<'_>,
    image: &Bound<'_, PyAny>,
    surfaces: &Bound<'_, PyAny>,
    sensor: &Bound<'_, PyAny>,
    model: &Bound<'_, PyAny>,
    shares: Vec<f32>,
    extinction: f32,
    aloft: Vec<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
    scan: &Bound<'_, PyAny>,
    seed: i64,
    threads: i64,
) -> PyResult<()> {
    let model = sensor_model(sensor, model, shares, extinction)?;
    let (seed, threads) = (checked_seed(seed)?, thread_count(threads)?);
    let (image, surfaces) = (Image::of(image)?, Surfaces::of(surfaces)?);
    let aloft = aloft.iter().map(Aloft::of).collect::<PyResult<Vec<_>>>()?;
    let aloft = aloft.iter().map(Aloft::slices).collect::<PyResult<Vec<_>>>()?;
    let mut scan = Scan::of(scan)?;
    let shape = [scan.depth.shape()[0], scan.depth.shape()[1]];
    let light = core::Light { returns: image.slices()?, surfaces: surfaces.slices()?, aloft: &aloft, shape };
    let mut written = scan.slices()?;
    let done: CoreResult<()> =
        py.detach(|| core::observe(&light, &model, seed, &mut written, threads)).map_err(CoreError::from);
    Ok(done?)
}

/// The numbers of a `Sensor` and a `SensorModel`.
fn sensor_model(
    sensor: &Bound<'_, PyAny>,
    model: &Bound<'_, PyAny>,
    shares: Vec<f32>,
    extinction: f32,
) -> PyResult<core::SensorModel> {
    let number = |name: &str| model.getattr(name)?.extract::<f32>();
    let switch = |name: &str| model.getattr(name)?.extract::<bool>();
    let of_sensor = |name: &str| sensor.getattr(name)?.extract::<f32>();
    Ok(core::SensorModel {
        shares,
        pulse_length: number("pulse_length")?,
        faintest: number("faintest")?,
        extinction,
        last: switch("last")?,
        panes: switch("panes")?,
        speckle: number("speckle")?,
        texture: number("texture")?,
        grainy: switch("grainy")?,
        dust: number("dust")?,
        fading: number("fading")?,
        chance: number("chance")?,
        unit: model.getattr("unit")?.extract()?,
        offset_spread: number("offset_spread")?,
        gain_spread: number("gain_spread")?,
        range_sigma: of_sensor("range_sigma")?,
        jitter: number("jitter")?,
        range_step: number("range_step")?,
        min_range: of_sensor("min_range")?,
        max_range: of_sensor("max_range")?,
        full_scale: number("full_scale")?,
        knee: number("knee")?,
        levels: number("levels")?,
        compensated: number("compensated")?,
    })
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
    grain: Column<'py, f32>,
    relief: Column<'py, f32>,
}

impl<'py> Surfaces<'py> {
    fn of(surfaces: &Bound<'py, PyAny>) -> PyResult<Surfaces<'py>> {
        Ok(Surfaces {
            table: read(surfaces, "table")?,
            transmission: array("transmission", &surfaces.getattr("transmission")?)?,
            grain: array("grain", &surfaces.getattr("grain")?)?,
            relief: array("relief", &surfaces.getattr("relief")?)?,
        })
    }

    fn slices(&self) -> PyResult<core::Surfaces<'_>> {
        Ok(core::Surfaces {
            table: rows("table", &self.table, "[P + 1, 128]")?,
            transmission: self.transmission.as_slice()?,
            grain: self.grain.as_slice()?,
            relief: self.relief.as_slice()?,
        })
    }
}

/// Range and response of what hangs in the air.
struct Aloft<'py> {
    depth: PyReadonlyArray2<'py, f32>,
    response: PyReadonlyArray2<'py, f32>,
}

impl<'py> Aloft<'py> {
    fn of((depth, response): &(Bound<'py, PyAny>, Bound<'py, PyAny>)) -> PyResult<Aloft<'py>> {
        Ok(Aloft { depth: array("aloft depth", depth)?, response: array("aloft response", response)? })
    }

    fn slices(&self) -> PyResult<core::Aloft<'_>> {
        let (depth, response) = (flat("aloft depth", &self.depth)?, flat("aloft response", &self.response)?);
        Ok(core::Aloft { depth, response })
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
