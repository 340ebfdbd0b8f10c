//! Rays against a rectangle.

use super::{Local, Shape, Solid, Tolerance, three};
use crate::simd::{Lanes, Vector};

/// A level rectangle.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Rectangle(pub(in crate::scan) Local);

/// Rows: the axes. A ray crosses the plane at nearness `plane` * z; it does so within the rectangle where the coordinates
/// there, (x + origin * nearness) / nearness, are at most the half extents.
#[derive(Clone, Copy)]
pub(in crate::scan) struct SeenRectangle<L> {
    rows: [Vector<L>; 4],
    plane: L,
    plane_error: L,
    origin: Vector<L>,
    half: Vector<L>,
    error: L,
}

impl Shape for Rectangle {
    type Seen<L: Lanes> = SeenRectangle<L>;

    #[inline(always)]
    fn seen_from<L: Lanes>(&self, start: Vector<L>) -> SeenRectangle<L> {
        let (axes, origin) = self.0.place(start);
        let (half, _) = self.0.sizes::<L>();
        let plane = -(L::splat(1.0) / origin.z);
        let rounding = L::splat(4.0 * self.0.rounding);
        let plane_error = plane.abs() * rounding;
        let furthest = (origin.x.abs() + half.x).max(origin.y.abs() + half.y);
        let error = furthest.mul_add(plane_error * L::splat(2.0), rounding * L::splat(2.0));
        SeenRectangle { rows: three(axes.x, axes.y, axes.z), plane, plane_error, origin, half, error }
    }
}

impl<L: Lanes> SeenRectangle<L> {
    /// How far within the edges a ray crosses the plane.
    #[inline(always)]
    fn within(&self, d: &[L; 4], nearness: L) -> L {
        let x = self.half.x * nearness - self.origin.x.mul_add(nearness, d[0]).abs();
        let y = self.half.y * nearness - self.origin.y.mul_add(nearness, d[1]).abs();
        x.min(y)
    }
}

impl<L: Lanes> Solid<L> for SeenRectangle<L> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn at_most(&self, d: [L; 4]) -> (L, L) {
        // The error of the margin includes that of the nearness, so that both tests ask for the same.
        let nearness = d[2] * self.plane;
        (nearness + self.plane_error, self.within(&d, nearness) + self.error)
    }

    #[inline(always)]
    fn settled(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        let nearness = d[2] * self.plane;
        let within = self.within(&d, nearness).gt(self.error);
        (nearness, within & tolerance.of(nearness).ge(self.plane_error))
    }
}
