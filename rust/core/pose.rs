//! Rigid poses.

use glam::{DMat3, DVec3};

use crate::{Error, Result};

/// The place and rotation of an object: `p_outside = rotation * p_inside + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Its axes in the outer frame, as columns.
    pub rotation: DMat3,
    /// Its origin in the outer frame [m].
    pub translation: DVec3,
}

/// The largest deviation of R^T R from the identity; enough for matrices from float32 text files.
const RIGIDITY: f64 = 1e-6;
/// The largest coordinate [m]; beyond, positions would be coarser than 0.1 micrometres.
const FURTHEST: f64 = 1e9;

impl Pose {
    /// At the origin, without rotation.
    pub const IDENTITY: Pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// A pose from the rows of a homogeneous matrix.
    ///
    /// # Errors
    /// [`Error::PoseEntry`], [`Error::PoseLastRow`], [`Error::PoseNotRigid`] or [`Error::PoseMirrored`].
    pub fn from_rows(rows: [[f64; 4]; 4]) -> Result<Pose> {
        for (row, entries) in rows.iter().enumerate() {
            if let Some(column) = entries.iter().position(|x| !(-FURTHEST..=FURTHEST).contains(x)) {
                let value = entries[column];
                let limit = FURTHEST;
                return Err(Error::PoseEntry { row, column, value, limit });
            }
        }
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(Error::PoseLastRow { value: rows[3] });
        }
        let axis = |k: usize| DVec3::new(rows[0][k], rows[1][k], rows[2][k]);
        let rotation = DMat3::from_cols(axis(0), axis(1), axis(2));
        let gram = rotation.transpose() * rotation - DMat3::IDENTITY;
        let deviation = gram.to_cols_array().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        if deviation > RIGIDITY {
            return Err(Error::PoseNotRigid { deviation, limit: RIGIDITY });
        }
        let determinant = rotation.determinant();
        if determinant < 0.0 {
            return Err(Error::PoseMirrored { determinant });
        }
        // Restores the digits lost in float32 texts: rays keep their lengths, and a transpose is an inverse.
        Ok(Pose { rotation, translation: axis(3) }.orthonormal())
    }

    /// A point of its frame in the outer frame.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// A direction of its frame in the outer frame.
    pub fn vector(&self, vector: DVec3) -> DVec3 {
        self.rotation * vector
    }

    /// A point of the outer frame in its frame.
    pub(crate) fn inverse_point(&self, point: DVec3) -> DVec3 {
        self.rotation.mul_transpose_vec3(point - self.translation)
    }

    /// A direction of the outer frame in its frame.
    pub(crate) fn inverse_vector(&self, vector: DVec3) -> DVec3 {
        self.rotation.mul_transpose_vec3(vector)
    }

    /// The pose with axes of length 1 at right angles (Gram and Schmidt).
    pub(crate) fn orthonormal(&self) -> Pose {
        let x = self.rotation.x_axis.normalize();
        let y = self.rotation.y_axis;
        let y = (y - x * x.dot(y)).normalize();
        Pose { rotation: DMat3::from_cols(x, y, x.cross(y)), ..*self }
    }
}
