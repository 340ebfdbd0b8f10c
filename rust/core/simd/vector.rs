//! Vectors of three coordinates, each of them lanes.
//!
//! Nothing here or in the kernel is a closure over lanes, and no array of lanes is mapped: the compiler may make a function
//! of its own of those, without the processor's features.

use std::ops::{Add, Mul, Sub};

use glam::DMat3;

use super::Lanes;

#[derive(Clone, Copy)]
pub(crate) struct Vector<L> {
    pub(crate) x: L,
    pub(crate) y: L,
    pub(crate) z: L,
}

impl<L: Lanes> Vector<L> {
    #[inline(always)]
    pub(crate) fn new(x: L, y: L, z: L) -> Vector<L> {
        Vector { x, y, z }
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub(crate) fn splat([x, y, z]: [f32; 3]) -> Vector<L> {
        Vector::new(L::splat(x), L::splat(y), L::splat(z))
    }

    /// One vector a lane, from columns of coordinates.
    #[inline(always)]
    pub(crate) fn load<T: AsRef<[f32]>>([x, y, z]: &[T; 3], at: usize) -> Vector<L> {
        Vector::new(L::load(x.as_ref(), at), L::load(y.as_ref(), at), L::load(z.as_ref(), at))
    }

    /// One vector a lane, from these places in columns of coordinates.
    #[inline(always)]
    pub(crate) fn gather([x, y, z]: &[Vec<f32>; 3], at: L) -> Vector<L> {
        Vector::new(at.gather(x), at.gather(y), at.gather(z))
    }

    /// The same at places that are whole numbers.
    #[inline(always)]
    pub(crate) fn gather_at([x, y, z]: &[Vec<f32>; 3], places: &[u32], at: usize) -> Vector<L> {
        Vector::new(L::gather_at(x, places, at), L::gather_at(y, places, at), L::gather_at(z, places, at))
    }

    #[inline(always)]
    pub(crate) fn store<const N: usize>(self, [x, y, z]: &mut [[f32; N]; 3]) {
        self.x.store(x, 0);
        self.y.store(y, 0);
        self.z.store(z, 0);
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Vector<L>) -> L {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Vector<L>) -> Vector<L> {
        Vector::new(
            self.z.neg_mul_add(other.y, self.y * other.z),
            self.x.neg_mul_add(other.z, self.z * other.x),
            self.y.neg_mul_add(other.x, self.x * other.y),
        )
    }

    #[inline(always)]
    pub(crate) fn length(self) -> L {
        self.dot(self).sqrt()
    }

    /// Coordinate by coordinate.
    #[inline(always)]
    pub(crate) fn times(self, other: Vector<L>) -> Vector<L> {
        Vector::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }
}

impl<L: Lanes> Add for Vector<L> {
    type Output = Vector<L>;
    #[inline(always)]
    fn add(self, other: Vector<L>) -> Vector<L> {
        Vector::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<L: Lanes> Sub for Vector<L> {
    type Output = Vector<L>;
    #[inline(always)]
    fn sub(self, other: Vector<L>) -> Vector<L> {
        Vector::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<L: Lanes> Mul<L> for Vector<L> {
    type Output = Vector<L>;
    #[inline(always)]
    fn mul(self, factor: L) -> Vector<L> {
        Vector::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

/// Three rows.
#[derive(Clone, Copy)]
pub(crate) struct Matrix<L> {
    pub(crate) x: Vector<L>,
    pub(crate) y: Vector<L>,
    pub(crate) z: Vector<L>,
}

impl<L: Lanes> Matrix<L> {
    /// The same matrix in every lane.
    #[inline(always)]
    pub(crate) fn splat([x, y, z]: [[f32; 3]; 3]) -> Matrix<L> {
        Matrix { x: Vector::splat(x), y: Vector::splat(y), z: Vector::splat(z) }
    }

    #[inline(always)]
    pub(crate) fn apply(&self, v: Vector<L>) -> Vector<L> {
        Vector::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// The row vector `v` times this matrix.
    #[inline(always)]
    pub(crate) fn combine(&self, v: Vector<L>) -> Vector<L> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// The rows of a matrix, as [`Matrix::splat`] takes them.
pub(crate) fn rows(matrix: &DMat3) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|k| matrix.row(k).as_vec3().to_array())
}
