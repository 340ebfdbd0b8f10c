//! Eight lanes in plain Rust, for any processor; compilers turn the loops into its vector instructions (NEON, SSE2).

use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use super::{Lanes, Mask, WIDEST, Word};

const N: usize = 8;

#[derive(Clone, Copy)]
pub(super) struct F32x8([f32; N]);

/// All bits of a lane are 1 or 0.
#[derive(Clone, Copy)]
pub(super) struct Mask8([u32; N]);

impl F32x8 {
    #[inline(always)]
    fn zip(self, other: F32x8, f: impl Fn(f32, f32) -> f32) -> F32x8 {
        F32x8(from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn compare(self, other: F32x8, f: impl Fn(f32, f32) -> bool) -> Mask8 {
        Mask8(from_fn(|i| u32::from(f(self.0[i], other.0[i])).wrapping_neg()))
    }
}

impl Lanes for F32x8 {
    const N: usize = N;
    type Mask = Mask8;

    #[inline(always)]
    fn splat(value: f32) -> F32x8 {
        F32x8([value; N])
    }

    #[inline(always)]
    fn splat_bits(bits: u32) -> F32x8 {
        F32x8([f32::from_bits(bits); N])
    }

    #[inline(always)]
    fn load<W: Word>(from: &[W], at: usize) -> F32x8 {
        let lanes = &from[at..at + N];
        F32x8(from_fn(|i| lanes[i].to_lane()))
    }

    #[inline(always)]
    fn store<W: Word>(self, to: &mut [W], at: usize) {
        for (to, lane) in to[at..at + N].iter_mut().zip(self.0) {
            *to = W::from_lane(lane);
        }
    }

    #[inline(always)]
    fn gather(self, from: &[f32]) -> F32x8 {
        // A cast from NaN is 0.
        F32x8(self.0.map(|index| from[(index as usize).min(from.len() - 1)]))
    }

    #[inline(always)]
    fn gather_at(from: &[f32], indices: &[u32], at: usize) -> F32x8 {
        let lanes = &indices[at..at + N];
        F32x8(from_fn(|i| from[(lanes[i] as usize).min(from.len() - 1)]))
    }

    /// Not fused: without such an instruction that would be a function call for each lane.
    #[inline(always)]
    fn mul_add(self, factor: F32x8, summand: F32x8) -> F32x8 {
        self * factor + summand
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: F32x8, summand: F32x8) -> F32x8 {
        summand - self * factor
    }

    #[inline(always)]
    fn min(self, other: F32x8) -> F32x8 {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, other: F32x8) -> F32x8 {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn abs(self) -> F32x8 {
        F32x8(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn sqrt(self) -> F32x8 {
        F32x8(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn floor(self) -> F32x8 {
        // Without an instruction for it, f32::floor is a call.
        F32x8(self.0.map(|a| {
            let whole = a as i32 as f32;
            whole - f32::from(u8::from(whole > a))
        }))
    }

    #[inline(always)]
    fn whole(self) -> F32x8 {
        F32x8(self.0.map(|a| f32::from_bits(a as i32 as u32)))
    }

    #[inline(always)]
    fn copysign(self, other: F32x8) -> F32x8 {
        self.zip(other, f32::copysign)
    }

    #[inline(always)]
    fn gt(self, other: F32x8) -> Mask8 {
        self.compare(other, |a, b| a > b)
    }

    #[inline(always)]
    fn ge(self, other: F32x8) -> Mask8 {
        self.compare(other, |a, b| a >= b)
    }

    #[inline(always)]
    fn ordered(self, other: F32x8) -> Mask8 {
        self.compare(other, |a, b| !a.is_nan() && !b.is_nan())
    }

    #[inline(always)]
    fn eq_bits(self, other: F32x8) -> Mask8 {
        self.compare(other, |a, b| a.to_bits() == b.to_bits())
    }

    #[inline(always)]
    fn select(mask: Mask8, yes: F32x8, no: F32x8) -> F32x8 {
        let bits = |i: usize| (mask.0[i] & yes.0[i].to_bits()) | (!mask.0[i] & no.0[i].to_bits());
        F32x8(from_fn(|i| f32::from_bits(bits(i))))
    }

    #[inline(always)]
    fn masked_store(mask: Mask8, value: u32, to: &mut [u32], at: usize) {
        for (lane, mask) in to[at..at + N].iter_mut().zip(mask.0) {
            *lane = (mask & value) | (!mask & *lane);
        }
    }

    #[inline(always)]
    fn low_bytes(self) -> [u8; WIDEST] {
        from_fn(|i| if i < N { self.0[i].to_bits() as u8 } else { 0 })
    }
}

impl Mask for Mask8 {
    const FULL: u32 = 0xff;

    #[inline(always)]
    fn bits(self) -> u32 {
        (0..N).fold(0, |bits, i| bits | (self.0[i] & 1) << i)
    }
}

macro_rules! operator {
    ($name:ident, $method:ident, $f:expr) => {
        impl $name for F32x8 {
            type Output = F32x8;
            #[inline(always)]
            fn $method(self, other: F32x8) -> F32x8 {
                self.zip(other, $f)
            }
        }
    };
}

operator!(Add, add, |a, b| a + b);
operator!(Sub, sub, |a, b| a - b);
operator!(Mul, mul, |a, b| a * b);
operator!(Div, div, |a, b| a / b);

impl Neg for F32x8 {
    type Output = F32x8;
    #[inline(always)]
    fn neg(self) -> F32x8 {
        F32x8(self.0.map(|a| -a))
    }
}

impl BitAnd for Mask8 {
    type Output = Mask8;
    #[inline(always)]
    fn bitand(self, other: Mask8) -> Mask8 {
        Mask8(from_fn(|i| self.0[i] & other.0[i]))
    }
}

impl BitOr for Mask8 {
    type Output = Mask8;
    #[inline(always)]
    fn bitor(self, other: Mask8) -> Mask8 {
        Mask8(from_fn(|i| self.0[i] | other.0[i]))
    }
}
