//! Rays against a cylinder.

use super::slab::Slab;
use super::{MediumTest, RayTest, ShapeFrame, ShapeInView, Tolerance, UNBOUNDED, root_error, three};
use crate::simd::{Lanes, Vector};

/// An upright cylinder seen from outside, in the frame in which its outline is the unit circle.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Cylinder(pub(in crate::scan) ShapeFrame);

/// Rows: along the line to the axis, across it, and up.
#[derive(Clone, Copy)]
pub(in crate::scan) struct CylinderTest<L> {
    rows: [Vector<L>; 4],
    side: L,
    along: L,
    /// Inverse depth of entering and of leaving the round side: `along` * first row + these * sqrt(discriminant).
    roots: [L; 2],
    /// 0 if rays start within the outline from above, and cannot enter by the round side; else 1.
    outside: L,
    between: L,
    error: L,
    /// The relative error of the inputs of the roots.
    root_error: L,
    caps: Slab<L>,
}

impl ShapeInView for Cylinder {
    type Test<L: Lanes> = CylinderTest<L>;

    #[inline(always)]
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> CylinderTest<L> {
        let (axes, origin) = self.0.axes_and_start(start);
        let (_, scale) = self.0.sizes();
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let (x_axis, y_axis) = (axes.x * scale.x, axes.y * scale.y);
        let (x, y) = (origin.x * scale.x, origin.y * scale.y);
        let distance = x.mul_add(x, y * y).sqrt();
        let inverse = -(one / distance.max(L::splat(1e-20)));
        let (x, y) = (x * inverse, y * inverse);
        let power = (distance - one) * (distance + one);
        let span = power.abs().sqrt();
        let outside = power.gt(zero);
        let root = one / power.abs();
        let finest = L::splat((1.0 / self.0.half[0]).max(1.0 / self.0.half[1]) * self.0.rounding);
        CylinderTest {
            rows: three(x_axis * x + y_axis * y, (y_axis * x - x_axis * y) * span, axes.z),
            side: one.copysign(power),
            along: distance / power,
            roots: [root, L::select(outside, -root, root)],
            outside: L::select(outside, one, zero),
            between: L::select(outside, zero, L::splat(UNBOUNDED)),
            error: finest * L::splat(12.0) * (span + one + one / span),
            root_error: root_error(distance, power),
            caps: self.0.slab(2, origin.z),
        }
    }
}

impl<L: Lanes> CylinderTest<L> {
    #[inline(always)]
    fn discriminant(&self, d: &[L; 4]) -> L {
        d[0].mul_add(d[0], -(self.side * d[1] * d[1]))
    }

    /// The entry and exit of a ray: the former at the most and the latter at the least (sign 1), or the other way
    /// round.
    #[inline(always)]
    fn meets(&self, d: &[L; 4], sign: f32) -> (L, L) {
        let (enter, leave) = self.sides(d, d[0].abs() * self.error * L::splat(sign));
        (enter.min(self.caps.enters(d[2], sign)), leave.max(self.caps.leaves(d[2], -sign)))
    }

    /// The same of the round side, given the error of the discriminant.
    #[inline(always)]
    fn sides(&self, d: &[L; 4], error: L) -> (L, L) {
        let zero = L::splat(0.0);
        let discriminant = self.discriminant(d);
        let entering = (discriminant + error).max(zero).sqrt();
        // Seen from within the outline, the round side is left at the other root.
        let leaving = (discriminant + error * self.side).max(zero).sqrt();
        let middle = d[0] * self.along;
        let enter = self.roots[0].mul_add(entering, middle).mul_add(self.outside, self.between);
        let leave = self.roots[1].mul_add(leaving, middle);
        (enter, leave)
    }

    /// As `meets`, for rays with any start; and the error of the discriminant.
    #[inline(always)]
    fn passes(&self, d: &[L; 4], sign: f32) -> (L, L, L) {
        let error = d[0].abs().max(d[1].abs()) * self.error;
        let (enter, leave) = self.sides(d, error * L::splat(sign));
        // Both are sums of the same two terms.
        let terms = self.roots[0].mul_add(self.discriminant(d).abs().sqrt(), (d[0] * self.along).abs());
        let root_error = terms * self.root_error * L::splat(sign);
        let enter = root_error.mul_add(self.outside, enter).min(self.caps.enters(d[2], sign));
        (enter, (leave - root_error).max(self.caps.leaves(d[2], -sign)), error)
    }
}

impl<L: Lanes> RayTest<L> for CylinderTest<L> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn upper_bounds(&self, d: [L; 4]) -> (L, L) {
        let (enter, leave) = self.meets(&d, 1.0);
        let discriminant = d[0].abs().mul_add(self.error, self.discriminant(&d));
        (enter, discriminant.min(enter - leave))
    }

    #[inline(always)]
    fn resolved(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        let (least, latest) = self.meets(&d, -1.0);
        let (most, _) = self.meets(&d, 1.0);
        let passes = self.discriminant(&d).gt(d[0].abs() * self.error) & least.gt(latest);
        (most, passes & tolerance.allowed_error(most).ge(most - least))
    }
}

impl<L: Lanes> MediumTest<L> for CylinderTest<L> {
    #[inline(always)]
    fn widest_interval(&self, d: [L; 4]) -> (L, L, L) {
        let (enter, leave, error) = self.passes(&d, 1.0);
        (enter, leave, (self.discriminant(&d) + error).min(enter - leave))
    }

    #[inline(always)]
    fn narrowest_interval(&self, d: [L; 4]) -> (L, L, L::Mask) {
        let (enter, leave, error) = self.passes(&d, -1.0);
        (enter, leave, self.discriminant(&d).gt(error) & enter.gt(leave))
    }
}
