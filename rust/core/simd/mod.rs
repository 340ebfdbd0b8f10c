//! A small vector of f32 lanes: all that the scan kernel knows about the machine.
//!
//! The kernel is written once, generic over [`Lanes`]; one backend a file implements it. This folder holds the only `unsafe`
//! code of the crate. Three rules make it sound:
//!
//! - the types of `avx2` and `avx512` are named in their `run` only, inside a function that has those features enabled,
//!   and that is called only where the processor has them;
//! - every method, and everything generic over `Lanes`, is `#[inline(always)]`, so that it is compiled into those functions;
//! - loads, stores and gathers check their bounds, on every backend.

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

pub(crate) use arctangent::{arctangent, small_arctangent};
pub(crate) use vector::{Matrix, Vector, rows};

use crate::Backend;

/// `N` numbers that are worked on at once.
///
/// Comparisons with NaN are false. `a.min(b)` and `a.max(b)` are `b` where one of both is NaN.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// How many; a divisor of [`WIDEST`].
    const N: usize;
    /// One truth value a lane.
    type Mask: Mask;

    fn splat(value: f32) -> Self;
    /// `from[at..at + N]`.
    fn load(from: &[f32], at: usize) -> Self;
    /// Writes `to[at..at + N]`.
    fn store(self, to: &mut [f32], at: usize);
    /// `from[i]` for each lane i of `self` rounded towards 0, which should be within the slice: another element else.
    fn gather(self, from: &[f32]) -> Self;
    /// `from[i]` for each i of `indices[at..at + N]`, which should be within the slice: another element else.
    fn gather_at(from: &[f32], indices: &[u32], at: usize) -> Self;

    /// `self * factor + summand`; rounded once where the processor can.
    fn mul_add(self, factor: Self, summand: Self) -> Self;
    /// `summand - self * factor`, likewise.
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    /// The next whole number below; `self` must be between -2^31 and 2^31.
    fn floor(self) -> Self;
    /// The magnitude of `self` with the sign of `other`.
    fn copysign(self, other: Self) -> Self;

    /// `self > other`.
    fn gt(self, other: Self) -> Self::Mask;
    /// `self >= other`.
    fn ge(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// The least lane.
    #[inline(always)]
    fn reduce_min(self) -> f32 {
        let mut lanes = [f32::INFINITY; WIDEST];
        self.store(&mut lanes, 0);
        lanes.into_iter().fold(f32::INFINITY, f32::min)
    }

    /// Writes `value` to `to[at + i]` for the lanes i where the mask is true.
    fn masked_store(mask: Self::Mask, value: u32, to: &mut [u32], at: usize);
    /// Whether `of[at..at + N]` are all the same.
    fn all_equal(of: &[u32], at: usize) -> bool;
}

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

/// Runs a kernel with the vectors of a backend, or with portable ones where this machine has none of that kind.
pub(crate) fn run(backend: Backend, kernel: impl Kernel) {
    match backend {
        #[cfg(target_arch = "x86_64")]
        Backend::Avx512 if backend.is_available() => avx512::run(kernel),
        #[cfg(target_arch = "x86_64")]
        Backend::Avx2 if backend.is_available() => avx2::run(kernel),
        _ => kernel.run::<portable::F32x8>(),
    }
}
