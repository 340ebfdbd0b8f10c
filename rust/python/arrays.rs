//! numpy arrays at the border: exact type and memory order, or an exception that names the given ones.

use lidardraft_core::Error;
use numpy::ndarray::{Dimension, Ix1, Ix2};
use numpy::{
    BorrowError, Element, PyArray, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArray, PyReadwriteArray,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::errors::{CoreError, array_type_error, memory_error};

/// An array of [N].
pub(crate) type Column<'py, T> = PyReadonlyArray<'py, T, Ix1>;
/// An array of [N, M].
pub(crate) type Table<'py, T> = PyReadonlyArray<'py, T, Ix2>;

/// An argument as a C-contiguous array of exactly this type and number of axes.
pub(crate) fn array<'py, T: Element, D: Dimension>(
    name: &str,
    argument: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArray<'py, T, D>> {
    exact::<T, D>(name, argument)?.try_readonly().map_err(|error| borrow_error(name, &error))
}

/// The same, to be written to; no other array of the call may share its memory.
pub(crate) fn writable<'py, T: Element, D: Dimension>(
    name: &str,
    argument: &Bound<'py, PyAny>,
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    exact::<T, D>(name, argument)?.try_readwrite().map_err(|error| borrow_error(name, &error))
}

fn exact<'a, 'py, T: Element, D: Dimension>(
    name: &str,
    argument: &'a Bound<'py, PyAny>,
) -> PyResult<&'a Bound<'py, PyArray<T, D>>> {
    match argument.cast::<PyArray<T, D>>() {
        Ok(array) if array.is_c_contiguous() => Ok(array),
        _ => {
            let given = describe(argument).unwrap_or_else(|_| "something else".to_owned());
            let axes = D::NDIM.unwrap_or_default();
            let expected = format!("{} with {axes} axes", T::get_dtype(argument.py()));
            Err(array_type_error(name, &expected, &given))
        }
    }
}

fn borrow_error(name: &str, error: &BorrowError) -> PyErr {
    let reason = match error {
        BorrowError::NotWriteable => "is read-only",
        _ => "shares memory with an array that is in use",
    };
    memory_error(name, reason)
}

/// The exception for an array with elements at addresses that the machine cannot use.
pub(crate) fn misaligned(name: &str) -> PyErr {
    memory_error(name, "is not aligned to the size of its elements")
}

/// A description of an argument, for a message.
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
    expected: &str,
) -> PyResult<&'a [[T; M]]> {
    let flat = table.as_slice().map_err(|_| misaligned(name))?;
    if table.shape()[1] != M {
        return Err(table_shape(name, table.shape(), expected));
    }
    Ok(flat.as_chunks().0)
}

/// The exception for a table of another shape.
pub(crate) fn table_shape(name: &str, shape: &[usize], expected: &str) -> PyErr {
    let (table, shape, expected) = (name.to_owned(), shape.to_vec(), expected.to_owned());
    CoreError::from(Error::TableShape { table, shape, expected }).into()
}

/// A vector as an array of another shape with as many elements.
pub(crate) fn shaped<'py, T: Element, const N: usize>(
    py: Python<'py>,
    values: Vec<T>,
    shape: [usize; N],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.as_slice())
}
