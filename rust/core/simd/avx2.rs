//! Eight lanes in one register of AVX2 with FMA.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use super::{Kernel, Lanes, Mask, WIDEST, Word};

const N: usize = 8;

#[derive(Clone, Copy)]
pub(super) struct F32x8(__m256);

#[derive(Clone, Copy)]
pub(super) struct Mask8(__m256);

// SAFETY, of every block below: this type is used only where the processor is known to have AVX2 and FMA (see the rules in
// the parent module), and memory is touched only inside a slice of N elements or at an index below a slice's length.
impl Lanes for F32x8 {
    const N: usize = N;
    type Mask = Mask8;

    #[inline(always)]
    fn splat(value: f32) -> F32x8 {
        unsafe { F32x8(_mm256_set1_ps(value)) }
    }

    #[inline(always)]
    fn splat_bits(bits: u32) -> F32x8 {
        unsafe { F32x8(_mm256_castsi256_ps(_mm256_set1_epi32(bits as i32))) }
    }

    #[inline(always)]
    fn load<W: Word>(from: &[W], at: usize) -> F32x8 {
        let lanes = &from[at..at + N];
        unsafe { F32x8(_mm256_loadu_ps(lanes.as_ptr().cast())) }
    }

    #[inline(always)]
    fn store<W: Word>(self, to: &mut [W], at: usize) {
        let lanes = &mut to[at..at + N];
        unsafe { _mm256_storeu_ps(lanes.as_mut_ptr().cast(), self.0) }
    }

    #[inline(always)]
    fn gather(self, from: &[f32]) -> F32x8 {
        assert!(!from.is_empty(), "nothing to gather from");
        let last = i32::try_from(from.len() - 1).unwrap_or(i32::MAX);
        unsafe {
            // NaN and too large numbers become i32::MIN.
            let index = _mm256_cvttps_epi32(self.0);
            let index = _mm256_min_epi32(_mm256_max_epi32(index, _mm256_setzero_si256()), _mm256_set1_epi32(last));
            F32x8(_mm256_i32gather_ps::<4>(from.as_ptr(), index))
        }
    }

    #[inline(always)]
    fn gather_at(from: &[f32], indices: &[u32], at: usize) -> F32x8 {
        assert!(!from.is_empty(), "nothing to gather from");
        let (lanes, last) = (&indices[at..at + N], i32::try_from(from.len() - 1).unwrap_or(i32::MAX));
        unsafe {
            let index = _mm256_min_epu32(_mm256_loadu_si256(lanes.as_ptr().cast()), _mm256_set1_epi32(last));
            F32x8(_mm256_i32gather_ps::<4>(from.as_ptr(), index))
        }
    }

    #[inline(always)]
    fn mul_add(self, factor: F32x8, summand: F32x8) -> F32x8 {
        unsafe { F32x8(_mm256_fmadd_ps(self.0, factor.0, summand.0)) }
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: F32x8, summand: F32x8) -> F32x8 {
        unsafe { F32x8(_mm256_fnmadd_ps(self.0, factor.0, summand.0)) }
    }

    #[inline(always)]
    fn min(self, other: F32x8) -> F32x8 {
        unsafe { F32x8(_mm256_min_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn max(self, other: F32x8) -> F32x8 {
        unsafe { F32x8(_mm256_max_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn abs(self) -> F32x8 {
        unsafe { F32x8(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
    }

    #[inline(always)]
    fn sqrt(self) -> F32x8 {
        unsafe { F32x8(_mm256_sqrt_ps(self.0)) }
    }

    #[inline(always)]
    fn floor(self) -> F32x8 {
        unsafe { F32x8(_mm256_floor_ps(self.0)) }
    }

    #[inline(always)]
    fn whole(self) -> F32x8 {
        unsafe { F32x8(_mm256_castsi256_ps(_mm256_cvttps_epi32(self.0))) }
    }

    #[inline(always)]
    fn copysign(self, other: F32x8) -> F32x8 {
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            F32x8(_mm256_or_ps(_mm256_andnot_ps(sign, self.0), _mm256_and_ps(sign, other.0)))
        }
    }

    #[inline(always)]
    fn gt(self, other: F32x8) -> Mask8 {
        unsafe { Mask8(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0)) }
    }

    #[inline(always)]
    fn ge(self, other: F32x8) -> Mask8 {
        unsafe { Mask8(_mm256_cmp_ps::<_CMP_GE_OQ>(self.0, other.0)) }
    }

    #[inline(always)]
    fn ordered(self, other: F32x8) -> Mask8 {
        unsafe { Mask8(_mm256_cmp_ps::<_CMP_ORD_Q>(self.0, other.0)) }
    }

    #[inline(always)]
    fn eq_bits(self, other: F32x8) -> Mask8 {
        unsafe {
            let same = _mm256_cmpeq_epi32(_mm256_castps_si256(self.0), _mm256_castps_si256(other.0));
            Mask8(_mm256_castsi256_ps(same))
        }
    }

    #[inline(always)]
    fn select(mask: Mask8, yes: F32x8, no: F32x8) -> F32x8 {
        unsafe { F32x8(_mm256_blendv_ps(no.0, yes.0, mask.0)) }
    }

    #[inline(always)]
    fn masked_store(mask: Mask8, value: u32, to: &mut [u32], at: usize) {
        let lanes: *mut __m256i = to[at..at + N].as_mut_ptr().cast();
        unsafe {
            // A masked store would be one instruction, and twenty times as slow on some processors.
            let old = _mm256_loadu_si256(lanes);
            let new = _mm256_blendv_epi8(old, _mm256_set1_epi32(value as i32), _mm256_castps_si256(mask.0));
            _mm256_storeu_si256(lanes, new);
        }
    }

    #[inline(always)]
    fn low_bytes(self) -> [u8; WIDEST] {
        let mut bytes = [0; WIDEST];
        unsafe {
            // The bytes of each half side by side, and then those of both halves.
            let low = _mm256_set1_epi32(0xff);
            let lanes = _mm256_and_si256(_mm256_castps_si256(self.0), low);
            let (front, back) = (_mm256_castsi256_si128(lanes), _mm256_extracti128_si256::<1>(lanes));
            let words = _mm_packus_epi32(front, back);
            _mm_storel_epi64(bytes.as_mut_ptr().cast(), _mm_packus_epi16(words, words));
        }
        bytes
    }
}

impl Mask for Mask8 {
    const FULL: u32 = 0xff;

    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

macro_rules! operator {
    ($name:ident, $method:ident, $type:ident, $instruction:ident) => {
        impl $name for $type {
            type Output = $type;
            #[inline(always)]
            fn $method(self, other: $type) -> $type {
                unsafe { $type($instruction(self.0, other.0)) }
            }
        }
    };
}

operator!(Add, add, F32x8, _mm256_add_ps);
operator!(Sub, sub, F32x8, _mm256_sub_ps);
operator!(Mul, mul, F32x8, _mm256_mul_ps);
operator!(Div, div, F32x8, _mm256_div_ps);
operator!(BitAnd, bitand, Mask8, _mm256_and_ps);
operator!(BitOr, bitor, Mask8, _mm256_or_ps);

impl Neg for F32x8 {
    type Output = F32x8;
    #[inline(always)]
    fn neg(self) -> F32x8 {
        unsafe { F32x8(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0))) }
    }
}

/// Runs a kernel with these instructions; the processor must have them.
pub(super) fn run(kernel: impl Kernel) {
    #[target_feature(enable = "avx2,fma")]
    fn enabled(kernel: impl Kernel) {
        kernel.run::<F32x8>();
    }
    // SAFETY: `super::run` asks the processor first.
    unsafe { enabled(kernel) }
}
