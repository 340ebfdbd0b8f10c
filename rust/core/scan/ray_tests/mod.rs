//! Vectors of rays against shapes: the tests of `intersect`, in f32 and with their errors.
//!
//! A ray direction enters as four numbers that are linear in it (the rows of [`RayTest`]): its coordinates in the frame of the
//! shape, or the edge functions of a triangle. The answer is an **inverse depth**, 1 / t, which is linear in the direction
//! where a surface is flat. Each test is asked twice: [`RayTest::upper_bounds`] never says less than the truth, so what it
//! leaves out is certainly no hit; [`RayTest::resolved`] says a hit only where rounding cannot have decided. What lies between
//! is unresolved, and left to the f64 tests of `intersect`.

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
    /// The vectors whose products with a ray direction the tests want.
    fn rows(&self) -> &[Vector<L>; 4];
    /// An inverse depth and a margin, neither less than the truth; the ray misses where the margin is negative.
    fn upper_bounds(&self, direction: [L; 4]) -> (L, L);
    /// The inverse depth, and where it certainly is a hit and as exact as `tolerance` asks.
    fn resolved(&self, direction: [L; 4], tolerance: Tolerance) -> (L, L::Mask);

    /// Between which slopes rays can hit it whose products are `along + slope * rise`; `None` if that is not known.
    #[inline(always)]
    fn slopes(&self, _along: &[L; 4], _rise: &[L; 4]) -> Option<(L, L)> {
        None
    }
}

/// A shape that rays travel through. From within it is entered at [`UNBOUNDED`].
pub(super) trait MediumTest<L: Lanes>: RayTest<L> {
    /// The inverse depth of entering, not less than the truth, and of leaving, not more than the truth; and a margin as that
    /// of [`RayTest::upper_bounds`].
    fn widest_interval(&self, direction: [L; 4]) -> (L, L, L);
    /// The inverse depth of entering, not more than the truth, and of leaving, not less; and where the ray certainly passes
    /// through.
    fn narrowest_interval(&self, direction: [L; 4]) -> (L, L, L::Mask);
}

/// A shape in the frame of a view, before it is known where rays start.
pub(super) trait ShapeInView: Copy {
    type Test<L: Lanes>: RayTest<L>;
    /// The test for rays that start at these points.
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> Self::Test<L>;
}

/// How exact a range must be to count: within `absolute` metres and a share `RELATIVE` of it.
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
    /// Where the view's origin lies in that frame [m].
    pub(super) origin: [f32; 3],
    /// Half extents [m].
    pub(super) half: [f32; 3],
    /// How far f32 may be off in the direction of a ray (`View::rounding`).
    pub(super) rounding: f32,
    /// How far from the origin rays may start [m].
    pub(super) shift: f32,
}

impl ShapeFrame {
    /// The axes, and where rays that start at these points start in the frame of the shape.
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

/// The rows of a shape that has no fourth.
#[inline(always)]
fn three<L: Lanes>(x: Vector<L>, y: Vector<L>, z: Vector<L>) -> [Vector<L>; 4] {
    [x, y, z, Vector::splat([0.0; 3])]
}

/// How far the roots of a round surface may be off, as a share of their terms, if rays start at this distance from its
/// middle, in radii, and `power` is what is left of its square less 1.
#[inline(always)]
fn root_error<L: Lanes>(distance: L, power: L) -> L {
    (distance * distance / power.abs()).mul_add(L::splat(8.0 * f32::EPSILON), L::splat(4.0 * f32::EPSILON))
}
