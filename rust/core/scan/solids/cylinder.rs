//! Rays against a cylinder.

use super::slab::Slab;
use super::{ENDLESS, Local, Shape, Solid, Tolerance, three};
use crate::scan::lanes::Lanes;
use crate::scan::vector::Vector;

/// An upright cylinder seen from outside, in the frame where its outline is the unit circle.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Cylinder(pub(in crate::scan) Local);

/// Rows: along the line to the axis, across it, and up.
#[derive(Clone, Copy)]
pub(in crate::scan) struct SeenCylinder<L> {
    rows: [Vector<L>; 4],
    side: L,
    along: L,
    /// Nearness of entering and of leaving the round side: `along` * first row + these * sqrt(discriminant).
    roots: [L; 2],
    /// 0 where rays start within the outline from above, and have no round side to enter by; else 1.
    outside: L,
    between: L,
    error: L,
    caps: Slab<L>,
}

impl Shape for Cylinder {
    type Seen<L: Lanes> = SeenCylinder<L>;

    #[inline(always)]
    fn seen_from<L: Lanes>(&self, start: Vector<L>) -> SeenCylinder<L> {
        let (axes, origin) = self.0.place(start);
        let (half, scale) = self.0.sizes();
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let (x_axis, y_axis) = (axes.x * scale.x, axes.y * scale.y);
        let (x, y) = (origin.x * scale.x, origin.y * scale.y);
        let distance = x.mul_add(x, y * y).sqrt();
        let inverse = -(one / distance.max(L::splat(1e-20)));
        let (x, y) = (x * inverse, y * inverse);
        let power = (distance - one) * (distance + one);
        let stretch = power.abs().sqrt();
        let outside = power.gt(zero);
        let root = one / power.abs();
        let finest = L::splat((1.0 / self.0.half[0]).max(1.0 / self.0.half[1]) * self.0.rounding);
        SeenCylinder {
            rows: three(x_axis * x + y_axis * y, (y_axis * x - x_axis * y) * stretch, axes.z),
            side: one.copysign(power),
            along: distance / power,
            roots: [root, L::select(outside, -root, root)],
            outside: L::select(outside, one, zero),
            between: L::select(outside, zero, L::splat(ENDLESS)),
            error: finest * L::splat(12.0) * (stretch + one + one / stretch),
            caps: Slab::new(origin.z, half.z, self.0.rounding),
        }
    }
}

impl<L: Lanes> SeenCylinder<L> {
    #[inline(always)]
    fn discriminant(&self, d: &[L; 4]) -> L {
        d[0].mul_add(d[0], -(self.side * d[1] * d[1]))
    }

    /// When a ray enters and leaves: the former at the most and the latter at the least (sign 1), or the other way round.
    #[inline(always)]
    fn meets(&self, d: &[L; 4], sign: f32) -> (L, L) {
        let (zero, error) = (L::splat(0.0), d[0].abs() * self.error * L::splat(sign));
        let discriminant = self.discriminant(d);
        let entering = (discriminant + error).max(zero).sqrt();
        // Seen from within the outline, the round side is left at the other root.
        let leaving = (discriminant + error * self.side).max(zero).sqrt();
        let middle = d[0] * self.along;
        let enter = self.roots[0].mul_add(entering, middle).mul_add(self.outside, self.between);
        let leave = self.roots[1].mul_add(leaving, middle);
        (enter.min(self.caps.enters(d[2], sign)), leave.max(self.caps.leaves(d[2], -sign)))
    }
}

impl<L: Lanes> Solid<L> for SeenCylinder<L> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn at_most(&self, d: [L; 4]) -> (L, L) {
        let (enter, leave) = self.meets(&d, 1.0);
        let discriminant = d[0].abs().mul_add(self.error, self.discriminant(&d));
        (enter, discriminant.min(enter - leave))
    }

    #[inline(always)]
    fn settled(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        let (least, latest) = self.meets(&d, -1.0);
        let (most, _) = self.meets(&d, 1.0);
        let passes = self.discriminant(&d).gt(d[0].abs() * self.error) & least.gt(latest);
        (most, passes & tolerance.of(most).ge(most - least))
    }
}
