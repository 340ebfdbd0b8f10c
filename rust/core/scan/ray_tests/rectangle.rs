//! Rays against a rectangle.

use super::{RayTest, ShapeFrame, ShapeInView, Tolerance, three};
use crate::simd::{Lanes, Vector};

/// A level rectangle.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Rectangle(pub(in crate::scan) ShapeFrame);

/// Rows: the axes. A ray crosses the plane at inverse depth `plane` * z, and is within the rectangle if the coordinates
/// there, (x + origin * inverse_depth) / inverse_depth, are at most the half extents.
#[derive(Clone, Copy)]
pub(in crate::scan) struct RectangleTest<L> {
    rows: [Vector<L>; 4],
    plane: L,
    plane_error: L,
    origin: Vector<L>,
    half: Vector<L>,
    error: L,
}

impl ShapeInView for Rectangle {
    type Test<L: Lanes> = RectangleTest<L>;

    #[inline(always)]
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> RectangleTest<L> {
        let (axes, origin) = self.0.axes_and_start(start);
        let (half, _) = self.0.sizes::<L>();
        let plane = -(L::splat(1.0) / origin.z);
        let rounding = L::splat(4.0 * self.0.rounding);
        let plane_error = plane.abs() * rounding;
        let furthest = (origin.x.abs() + half.x).max(origin.y.abs() + half.y);
        let error = furthest.mul_add(plane_error * L::splat(2.0), rounding * L::splat(2.0));
        RectangleTest { rows: three(axes.x, axes.y, axes.z), plane, plane_error, origin, half, error }
    }
}

impl<L: Lanes> RectangleTest<L> {
    /// How far within the edges a ray crosses the plane.
    #[inline(always)]
    fn within(&self, d: &[L; 4], inverse_depth: L) -> L {
        let x = self.half.x * inverse_depth - self.origin.x.mul_add(inverse_depth, d[0]).abs();
        let y = self.half.y * inverse_depth - self.origin.y.mul_add(inverse_depth, d[1]).abs();
        x.min(y)
    }
}

impl<L: Lanes> RayTest<L> for RectangleTest<L> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn upper_bounds(&self, d: [L; 4]) -> (L, L) {
        // The error of the margin includes that of the inverse depth, so that both tests have the same conditions.
        let inverse_depth = d[2] * self.plane;
        (inverse_depth + self.plane_error, self.within(&d, inverse_depth) + self.error)
    }

    #[inline(always)]
    fn resolved(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        let inverse_depth = d[2] * self.plane;
        let within = self.within(&d, inverse_depth).gt(self.error);
        (inverse_depth, within & tolerance.allowed_error(inverse_depth).ge(self.plane_error))
    }
}
