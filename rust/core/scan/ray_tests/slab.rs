//! The space between two parallel planes.

use super::UNBOUNDED;
use crate::simd::Lanes;

/// Closer to a plane than this share of the terms of its distance, a start is in it: some ten times f32's rounding.
const IN_PLANE: f32 = 1e-6;

/// The part of a ray between two parallel planes, seen from outside or from between them.
#[derive(Clone, Copy)]
pub(super) struct Slab<L> {
    /// Inverse depth of entering and of leaving through either plane, for a unit of direction along the normal.
    enter: L,
    leave: [L; 2],
    /// Added to the inverse depth of the entry, which has no meaning between the planes.
    between: L,
    /// The errors of those.
    enter_error: L,
    leave_error: L,
}

impl<L: Lanes> Slab<L> {
    #[inline(always)]
    pub(super) fn new(origin: L, half: L, shift: L, rounding: f32) -> Slab<L> {
        let (zero, one, unbounded) = (L::splat(0.0), L::splat(1.0), L::splat(UNBOUNDED));
        let outside = origin.abs().gt(half);
        // In the plane itself, the side is unknown: then this slab decides nothing.
        let known = (origin.abs() - half).abs().gt((origin.abs() + half + shift) * L::splat(IN_PLANE));
        let near = one / (half.copysign(origin) - origin);
        let far = one / (-half.copysign(origin) - origin);
        // Origin and half extent are rounded themselves, which counts where the plane is close.
        let lost = (origin.abs() + half) * near.abs();
        let rounding = lost.mul_add(L::splat(2.0 * rounding), L::splat(4.0 * rounding));
        Slab {
            enter: L::select(known & outside, near, zero),
            leave: [far, L::select(outside, far, L::select(known, near, far))],
            between: L::select(outside, zero, unbounded),
            enter_error: L::select(known, L::select(outside, near.abs() * rounding, zero), unbounded),
            leave_error: L::select(known, far.abs().max(L::select(outside, zero, near.abs())) * rounding, unbounded),
        }
    }

    /// The entry of a ray, at the most (sign 1) or at the least (sign -1).
    #[inline(always)]
    pub(super) fn enters(&self, direction: L, sign: f32) -> L {
        direction.mul_add(self.enter, self.enter_error.mul_add(L::splat(sign), self.between))
    }

    /// The exit of a ray, at the most or at the least.
    #[inline(always)]
    pub(super) fn leaves(&self, direction: L, sign: f32) -> L {
        let error = self.leave_error * L::splat(sign);
        direction.mul_add(self.leave[0], error).max(direction.mul_add(self.leave[1], error))
    }
}
