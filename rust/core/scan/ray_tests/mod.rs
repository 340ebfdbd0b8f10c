//! Vectors of rays against shapes: the tests of `intersect`, in f32 and with their errors.
//!
//! A ray direction enters as four numbers that are linear in it (the rows of [`RayTest`]): its coordinates in the frame
//! of the shape, or the edge functions of a triangle. The result is an **inverse depth**, 1 / t, which is linear in the
//! direction for a flat surface. Each test is made twice. [`RayTest::upper_bounds`] is never less than the truth, so
//! the rays that it leaves out are certainly no hits. [`RayTest::resolved`] reports a hit only if rounding cannot have
//! decided. Rays in between are unresolved, and left to the f64 tests of `intersect`.

mod cuboid;
mod cylinder;
mod ellipsoid;
mod rectangle;
mod slab;
mod triangle;

use crate::simd::{Lanes, Matrix, Vector};
use slab::Slab;

pub(super) use cuboid::Cuboid;
pub(super) use cylinder::Cylinder;
pub(super) use ellipsoid::Ellipsoid;
pub(super) use rectangle::Rectangle;
pub(super) use triangle::{Facet, Triangle, TriangleTest};

/// A shape against rays that start at one point, or at one point a lane.
pub(super) trait RayTest<L: Lanes>: Copy {
    /// The vectors whose products with a ray direction are the inputs of the tests.
    fn rows(&self) -> &[Vector<L>; 4];
    /// An inverse depth and a margin, neither less than the truth; the ray misses if the margin is negative.
    fn upper_bounds(&self, direction: [L; 4]) -> (L, L);
    /// The inverse depth, and whether it certainly is a hit within the `tolerance`.
    fn resolved(&self, direction: [L; 4], tolerance: Tolerance) -> (L, L::Mask);

    /// The slopes between which rays with products `along + slope * rise` can hit it; `None` if unknown.
    #[inline(always)]
    fn slopes(&self, _along: &[L; 4], _rise: &[L; 4]) -> Option<(L, L)> {
        None
    }
}

/// A shape that rays travel through. From within, its entry is at [`UNBOUNDED`].
pub(super) trait MediumTest<L: Lanes>: RayTest<L> {
    /// The inverse depth of the entry, not less than the truth, and of the exit, not more than the truth; and a margin
    /// as in [`RayTest::upper_bounds`].
    fn widest_interval(&self, direction: [L; 4]) -> (L, L, L);
    /// The inverse depth of the entry, not more than the truth, and of the exit, not less; and whether the ray
    /// certainly passes through.
    fn narrowest_interval(&self, direction: [L; 4]) -> (L, L, L::Mask);
}

/// A shape in the frame of a view, before the start of the rays is known.
pub(super) trait ShapeInView: Copy {
    type Test<L: Lanes>: RayTest<L>;
    /// The test for rays that start at these points.
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> Self::Test<L>;
}

/// The required precision of a range: within `absolute` metres and a share `RELATIVE` of it.
#[derive(Clone, Copy)]
pub(super) struct Tolerance {
    pub(super) absolute: f32,
}

impl Tolerance {
    pub(super) const RELATIVE: f32 = 8e-6;

    /// The largest error of an inverse depth that is still exact enough.
    #[inline(always)]
    pub(super) fn allowed_error<L: Lanes>(self, inverse_depth: L) -> L {
        inverse_depth * inverse_depth.mul_add(L::splat(self.absolute), L::splat(Tolerance::RELATIVE))
    }
}

/// Larger than the inverse depth of any hit, and still a number.
pub(super) const UNBOUNDED: f32 = 1e30;

/// The frame of a shape in a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapeFrame {
    /// The axes of the shape, as rows: they take a vector of the view into the shape's frame.
    pub(super) axes: [[f32; 3]; 3],
    /// The view's origin in that frame [m].
    pub(super) origin: [f32; 3],
    /// Half extents [m].
    pub(super) half: [f32; 3],
    /// The largest error of f32 in the direction of a ray (`View::rounding`).
    pub(super) rounding: f32,
    /// The largest distance of a ray's start from the origin [m].
    pub(super) shift: f32,
}

impl ShapeFrame {
    /// The axes, and the starts of rays in the frame of the shape.
    #[inline(always)]
    fn axes_and_start<L: Lanes>(&self, start: Vector<L>) -> (Matrix<L>, Vector<L>) {
        let axes = Matrix::splat(self.axes);
        (axes, Vector::splat(self.origin) + axes.apply(start))
    }

    /// The slabs between the faces across one axis, for rays that start at this coordinate of it.
    #[inline(always)]
    fn slab<L: Lanes>(&self, axis: usize, from: L) -> Slab<L> {
        Slab::new(from, L::splat(self.half[axis]), L::splat(self.shift), self.rounding)
    }

    /// Half extents, and their inverses.
    #[inline(always)]
    fn sizes<L: Lanes>(&self) -> (Vector<L>, Vector<L>) {
        let [x, y, z] = self.half;
        (Vector::splat(self.half), Vector::splat([1.0 / x, 1.0 / y, 1.0 / z]))
    }
}

/// The rows of a shape without a fourth.
#[inline(always)]
fn three<L: Lanes>(x: Vector<L>, y: Vector<L>, z: Vector<L>) -> [Vector<L>; 4] {
    [x, y, z, Vector::splat([0.0; 3])]
}

/// The largest error of the roots of a round surface, as a share of their terms, if rays start at this distance from
/// its middle, in radii; `power` is the square of the distance less 1.
#[inline(always)]
fn root_error<L: Lanes>(distance: L, power: L) -> L {
    (distance * distance / power.abs()).mul_add(L::splat(8.0 * f32::EPSILON), L::splat(4.0 * f32::EPSILON))
}
