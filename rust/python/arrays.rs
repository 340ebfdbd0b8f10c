//! numpy arrays at the border: exact type and memory order, or an exception that says what came instead.

use lidardraft_core::Error;
use numpy::ndarray::{Dimension, Ix1, Ix2};
use numpy::{
    Element, PyArray, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArray, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::errors::{CoreError, CoreResult, array_type_error};

/// An array of [N].
pub(crate) type Column<'py, T> = PyReadonlyArray<'py, T, Ix1>;
/// An array of [N, M].
pub(crate) type Table<'py, T> = PyReadonlyArray<'py, T, Ix2>;

/// An argument as a C-contiguous array of exactly this type and number of axes.
pub(crate) fn array<'py, T: Element, D: Dimension>(
    name: &str,
    argument: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArray<'py, T, D>> {
    let given = || describe(argument).unwrap_or_else(|_| "something else".to_owned());
    let axes = D::NDIM.unwrap_or_default();
    let expected = format!("{} with {axes} axes", T::get_dtype(argument.py()));
    match argument.cast::<PyArray<T, D>>() {
        Ok(array) if array.is_c_contiguous() => Ok(array.try_readonly()?),
        _ => Err(array_type_error(name, &expected, &given())),
    }
}

/// What an argument is, for a message.
fn describe(argument: &Bound<'_, PyAny>) -> PyResult<String> {
    let Ok(array) = argument.cast::<PyUntypedArray>() else {
        return Ok(format!("a {}", argument.get_type().name()?));
    };
    let order = if array.is_c_contiguous() { "" } else { "a strided view of " };
    Ok(format!("{order}{} with the shape {:?}", array.dtype(), array.shape()))
}

/// The rows of a table of [N, M].
pub(crate) fn rows<'a, T: Element, const M: usize>(
    name: &str,
    table: &'a Table<'_, T>,
    expected: &'static str,
) -> CoreResult<&'a [[T; M]]> {
    let wrong = || Error::TableShape { table: name.to_owned(), shape: table.shape().to_vec(), expected };
    let flat = table.as_slice().map_err(|_| wrong())?;
    if table.shape()[1] != M {
        return Err(CoreError::from(wrong()));
    }
    Ok(flat.as_chunks().0)
}

/// A vector as an array of another shape with as many elements.
pub(crate) fn shaped<'py, T: Element, const N: usize>(
    py: Python<'py>,
    values: Vec<T>,
    shape: [usize; N],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.as_slice())
}
