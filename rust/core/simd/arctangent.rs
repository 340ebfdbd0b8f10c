//! Arctangents of lanes, by polynomials.

use std::f32::consts::{FRAC_PI_2, PI};

use super::Lanes;

/// The angle of (x, y) [rad], off by 1e-5 at most: Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.49.
#[inline(always)]
pub(crate) fn arctangent<L: Lanes>(y: L, x: L) -> L {
    let (across, along) = (y.abs(), x.abs());
    let (small, large) = (across.min(along), across.max(along));
    let angle = small_arctangent(small / large.max(L::splat(1e-30)));
    let angle = L::select(across.gt(along), L::splat(FRAC_PI_2) - angle, angle);
    let angle = L::select(L::splat(0.0).gt(x), L::splat(PI) - angle, angle);
    angle.copysign(y)
}

/// The arctangent of a number between -1 and 1, with an error of 1e-5 at most.
#[inline(always)]
pub(crate) fn small_arctangent<L: Lanes>(tangent: L) -> L {
    let square = tangent * tangent;
    let sum = L::splat(0.020_835_1).mul_add(square, L::splat(-0.085_133));
    let sum = sum.mul_add(square, L::splat(0.180_141)).mul_add(square, L::splat(-0.330_299_5));
    sum.mul_add(square, L::splat(0.999_866)) * tangent
}
