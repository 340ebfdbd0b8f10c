//! Poses out of numpy arrays [..., 4, 4].

use lidardraft_core::{Error, Pose};
use numpy::PyUntypedArrayMethods;
use numpy::ndarray::{Ix3, Ix4};
use pyo3::prelude::*;

use crate::arrays::{array, misaligned, table_shape};
use crate::errors::{CoreError, CoreResult};

/// `world_from_sensor` [N, K, 4, 4], checked to be rigid: the poses scan by scan, N and K.
pub(crate) fn sensor_poses(argument: &Bound<'_, PyAny>, columns: usize) -> PyResult<(Vec<Pose>, usize, usize)> {
    const NAME: &str = "world_from_sensor";
    let table = array::<f64, Ix4>(NAME, argument)?;
    let &[scans, each, 4, 4] = table.shape() else {
        return Err(table_shape(NAME, table.shape(), "[N, K, 4, 4]"));
    };
    if each != 1 && each != columns {
        return Err(CoreError::from(Error::PoseCount { poses: each, columns }).into());
    }
    let entries = table.as_slice().map_err(|_| misaligned(NAME))?;
    let poses = argument.py().detach(|| poses(NAME, entries, |i| vec![i / each, i % each]))?;
    Ok((poses, scans, each))
}

/// `world_from_primitive` [M, 4, 4], checked to be rigid.
pub(crate) fn primitive_poses(argument: &Bound<'_, PyAny>) -> PyResult<Vec<Pose>> {
    const NAME: &str = "world_from_primitive";
    let table = array::<f64, Ix3>(NAME, argument)?;
    let &[_, 4, 4] = table.shape() else {
        return Err(table_shape(NAME, table.shape(), "[M, 4, 4]"));
    };
    let entries = table.as_slice().map_err(|_| misaligned(NAME))?;
    Ok(poses(NAME, entries, |i| vec![i])?)
}

fn poses(table: &'static str, entries: &[f64], index: impl Fn(usize) -> Vec<usize>) -> CoreResult<Vec<Pose>> {
    let (rows, _) = entries.as_chunks::<4>();
    let (matrices, _) = rows.as_chunks::<4>();
    let pose = |(i, matrix): (usize, &[[f64; 4]; 4])| {
        let named = |source| Error::PoseOfTable { table, index: index(i), source: Box::new(source) };
        Ok(Pose::from_rows(*matrix).map_err(named)?)
    };
    matrices.iter().enumerate().map(pose).collect()
}
