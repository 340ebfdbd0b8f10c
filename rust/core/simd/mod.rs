//! A small vector of f32 lanes: all that the scan kernel knows about the machine.
//!
//! The kernel is written once, generic over [`Lanes`]; one backend a file implements it. This folder holds the only `unsafe`
//! code of the crate. Three rules make it sound:
//!
//! - the types of `avx2` and `avx512` are named in their `run` only, inside a function that has those features enabled,
//!   and that is called only where the processor has them;
//! - every method, and everything generic over `Lanes`, is `#[inline(always)]`, so that it is compiled into those functions;
//! - loads, stores and gathers check their bounds, on every backend.

mod aligned;
mod arctangent;
#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "processor instructions")]
mod avx2;
#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "processor instructions")]
mod avx512;
mod portable;
mod vector;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

pub(crate) use aligned::Aligned;
pub(crate) use arctangent::{arctangent, small_arctangent};
pub(crate) use vector::{Matrix, Vector, rows};

use crate::Backend;

/// `N` numbers that are worked on at once.
///
/// Comparisons with NaN are false. `a.min(b)` and `a.max(b)` are `b` if one of both is NaN.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The number of lanes; a divisor of [`WIDEST`].
    const N: usize;
    /// One truth value a lane.
    type Mask: Mask;

    fn splat(value: f32) -> Self;
    /// The same 32 bits in every lane.
    fn splat_bits(bits: u32) -> Self;
    /// `from[at..at + N]`.
    fn load<W: Word>(from: &[W], at: usize) -> Self;
    /// Writes `to[at..at + N]`.
    fn store<W: Word>(self, to: &mut [W], at: usize);
    /// `from[i]` for each lane i of `self` rounded towards 0, which should be within the slice: another element else.
    fn gather(self, from: &[f32]) -> Self;
    /// `from[i]` for each i of `indices[at..at + N]`, which should be within the slice: another element else.
    fn gather_at(from: &[f32], indices: &[u32], at: usize) -> Self;

    /// `self * factor + summand`; rounded once if the processor can.
    fn mul_add(self, factor: Self, summand: Self) -> Self;
    /// `summand - self * factor`, likewise.
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    /// The next whole number below; `self` must be between -2^31 and 2^31.
    fn floor(self) -> Self;
    /// The bits of whole numbers: `self` rounded towards 0, which must be between -2^31 and 2^31.
    fn whole(self) -> Self;
    /// The magnitude of `self` with the sign of `other`.
    fn copysign(self, other: Self) -> Self;

    /// `self > other`.
    fn gt(self, other: Self) -> Self::Mask;
    /// `self >= other`.
    fn ge(self, other: Self) -> Self::Mask;
    /// Where neither is NaN.
    fn ordered(self, other: Self) -> Self::Mask;
    /// Where both have the same 32 bits.
    fn eq_bits(self, other: Self) -> Self::Mask;
    /// `yes` for lanes with a true mask, else `no`; bit by bit, for any content of the lanes.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// The least lane.
    #[inline(always)]
    fn reduce_min(self) -> f32 {
        let mut lanes = [f32::INFINITY; WIDEST];
        self.store(&mut lanes, 0);
        lanes.into_iter().fold(f32::INFINITY, f32::min)
    }

    /// The lowest eight bits of each lane.
    fn low_bytes(self) -> [u8; WIDEST];

    /// Writes the lowest eight bits of the first lanes, as many as fit; no more than `N`.
    #[inline(always)]
    fn store_bytes(self, to: &mut [u8]) {
        let bytes = self.low_bytes();
        if to.len() == Self::N {
            to.copy_from_slice(&bytes[..Self::N]);
        } else {
            to.copy_from_slice(&bytes[..to.len()]);
        }
    }

    /// Writes the first lanes, as many as fit; no more than `N`.
    #[inline(always)]
    fn store_first<W: Word>(self, to: &mut [W]) {
        if to.len() == Self::N {
            return self.store(to, 0);
        }
        let mut lanes = [W::default(); WIDEST];
        self.store(&mut lanes, 0);
        to.copy_from_slice(&lanes[..to.len()]);
    }

    /// Writes `value` to `to[at + i]` for the lanes i with a true mask.
    fn masked_store(mask: Self::Mask, value: u32, to: &mut [u32], at: usize);
}

/// The content of a lane: 32 bits.
pub(crate) trait Word: Copy + Default {
    fn to_lane(self) -> f32;
    fn from_lane(lane: f32) -> Self;
}

macro_rules! word {
    ($type:ident, $to_lane:expr, $from_lane:expr) => {
        impl Word for $type {
            #[inline(always)]
            fn to_lane(self) -> f32 {
                $to_lane(self)
            }

            #[inline(always)]
            fn from_lane(lane: f32) -> $type {
                $from_lane(lane)
            }
        }
    };
}

word!(f32, |x| x, |x| x);
word!(u32, f32::from_bits, f32::to_bits);
word!(i32, |x| f32::from_bits(x as u32), |x: f32| x.to_bits() as i32);

/// One truth value a lane.
pub(crate) trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// Bit i is lane i.
    fn bits(self) -> u32;

    /// The bits of a mask that is true in every lane.
    const FULL: u32;

    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }

    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == Self::FULL
    }
}

/// The most lanes of any backend; tables are padded to a multiple of it.
pub(crate) const WIDEST: usize = 16;

/// Something to be done with vectors of any width.
pub(crate) trait Kernel {
    fn run<L: Lanes>(self);
}

/// Runs a kernel with the vectors of a backend, or with portable ones if this machine has none of that kind.
pub(crate) fn run(backend: Backend, kernel: impl Kernel) {
    match backend {
        #[cfg(target_arch = "x86_64")]
        Backend::Avx512 if backend.is_available() => avx512::run(kernel),
        #[cfg(target_arch = "x86_64")]
        Backend::Avx2 if backend.is_available() => avx2::run(kernel),
        _ => kernel.run::<portable::F32x8>(),
    }
}
