//! The images of a scan as numpy arrays that are written in place.

use lidardraft_core::{Error, ImagesMut};
use numpy::ndarray::{Dimension, Ix3, Ix4};
use numpy::{Element, PyReadwriteArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{misaligned, writable};
use crate::errors::CoreError;

/// The arguments of `Scene.scan` that are written to, as Python gives them.
pub(crate) struct Given<'a, 'py> {
    pub(crate) depth: &'a Bound<'py, PyAny>,
    pub(crate) label: &'a Bound<'py, PyAny>,
    pub(crate) instance: &'a Bound<'py, PyAny>,
    pub(crate) primitive: Option<&'a Bound<'py, PyAny>>,
    pub(crate) incidence: Option<&'a Bound<'py, PyAny>>,
    pub(crate) normal: Option<&'a Bound<'py, PyAny>>,
}

/// Arrays of [N, H, W] and [N, H, W, 3] that nobody else reads or writes.
pub(crate) struct Outputs<'py> {
    depth: PyReadwriteArray<'py, f32, Ix3>,
    label: PyReadwriteArray<'py, u8, Ix3>,
    instance: PyReadwriteArray<'py, u32, Ix3>,
    primitive: Option<PyReadwriteArray<'py, i32, Ix3>>,
    incidence: Option<PyReadwriteArray<'py, f32, Ix3>>,
    normal: Option<PyReadwriteArray<'py, f32, Ix4>>,
}

impl<'py> Outputs<'py> {
    /// The arrays, if every one of them is as it must be.
    pub(crate) fn new(given: &Given<'_, 'py>, shape: [usize; 3]) -> PyResult<Outputs<'py>> {
        let [scans, rows, columns] = shape;
        Ok(Outputs {
            depth: image("depth", given.depth, &shape)?,
            label: image("label", given.label, &shape)?,
            instance: image("instance", given.instance, &shape)?,
            primitive: given.primitive.map(|array| image("primitive", array, &shape)).transpose()?,
            incidence: given.incidence.map(|array| image("incidence", array, &shape)).transpose()?,
            normal: given.normal.map(|array| image("normal", array, &[scans, rows, columns, 3])).transpose()?,
        })
    }

    /// Their memory.
    pub(crate) fn images(&mut self) -> PyResult<ImagesMut<'_>> {
        let normal = self.normal.as_mut().map(|array| pixels("normal", array)).transpose()?;
        Ok(ImagesMut {
            depth: pixels("depth", &mut self.depth)?,
            label: pixels("label", &mut self.label)?,
            instance: pixels("instance", &mut self.instance)?,
            primitive: self.primitive.as_mut().map(|array| pixels("primitive", array)).transpose()?,
            incidence: self.incidence.as_mut().map(|array| pixels("incidence", array)).transpose()?,
            normal: normal.map(|flat| flat.as_chunks_mut().0),
        })
    }
}

fn image<'py, T: Element, D: Dimension>(
    image: &'static str,
    argument: &Bound<'py, PyAny>,
    expected: &[usize],
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    let array = writable::<T, D>(image, argument)?;
    if array.shape() != expected {
        let (shape, expected) = (array.shape().to_vec(), expected.to_vec());
        return Err(CoreError::from(Error::OutputShape { image, shape, expected }).into());
    }
    Ok(array)
}

fn pixels<'a, T: Element, D: Dimension>(
    image: &str,
    array: &'a mut PyReadwriteArray<'_, T, D>,
) -> PyResult<&'a mut [T]> {
    array.as_slice_mut().map_err(|_| misaligned(image))
}
