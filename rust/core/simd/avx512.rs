//! Sixteen lanes in one register of AVX-512 (F, DQ, BW, VL).

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use super::{Kernel, Lanes, Mask, WIDEST, Word};

const N: usize = 16;

#[derive(Clone, Copy)]
pub(super) struct F32x16(__m512);

#[derive(Clone, Copy)]
pub(super) struct Mask16(__mmask16);

// SAFETY, of every block below: this type is used only where the processor is known to have these features (see the rules in
// the parent module), and memory is touched only inside a slice of N elements or at an index below a slice's length.
impl Lanes for F32x16 {
    const N: usize = N;
    type Mask = Mask16;

    #[inline(always)]
    fn splat(value: f32) -> F32x16 {
        unsafe { F32x16(_mm512_set1_ps(value)) }
    }

    #[inline(always)]
    fn splat_bits(bits: u32) -> F32x16 {
        unsafe { F32x16(_mm512_castsi512_ps(_mm512_set1_epi32(bits as i32))) }
    }

    #[inline(always)]
    fn load<W: Word>(from: &[W], at: usize) -> F32x16 {
        let lanes = &from[at..at + N];
        unsafe { F32x16(_mm512_loadu_ps(lanes.as_ptr().cast())) }
    }

    #[inline(always)]
    fn store<W: Word>(self, to: &mut [W], at: usize) {
        let lanes = &mut to[at..at + N];
        unsafe { _mm512_storeu_ps(lanes.as_mut_ptr().cast(), self.0) }
    }

    #[inline(always)]
    fn gather(self, from: &[f32]) -> F32x16 {
        assert!(!from.is_empty(), "nothing to gather from");
        let last = i32::try_from(from.len() - 1).unwrap_or(i32::MAX);
        unsafe {
            // NaN and too large numbers become i32::MIN.
            let index = _mm512_cvttps_epi32(self.0);
            let index = _mm512_min_epi32(_mm512_max_epi32(index, _mm512_setzero_si512()), _mm512_set1_epi32(last));
            F32x16(_mm512_i32gather_ps::<4>(index, from.as_ptr()))
        }
    }

    #[inline(always)]
    fn gather_at(from: &[f32], indices: &[u32], at: usize) -> F32x16 {
        assert!(!from.is_empty(), "nothing to gather from");
        let (lanes, last) = (&indices[at..at + N], i32::try_from(from.len() - 1).unwrap_or(i32::MAX));
        unsafe {
            let index = _mm512_min_epu32(_mm512_loadu_si512(lanes.as_ptr().cast()), _mm512_set1_epi32(last));
            F32x16(_mm512_i32gather_ps::<4>(index, from.as_ptr()))
        }
    }

    #[inline(always)]
    fn mul_add(self, factor: F32x16, summand: F32x16) -> F32x16 {
        unsafe { F32x16(_mm512_fmadd_ps(self.0, factor.0, summand.0)) }
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: F32x16, summand: F32x16) -> F32x16 {
        unsafe { F32x16(_mm512_fnmadd_ps(self.0, factor.0, summand.0)) }
    }

    #[inline(always)]
    fn min(self, other: F32x16) -> F32x16 {
        unsafe { F32x16(_mm512_min_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn max(self, other: F32x16) -> F32x16 {
        unsafe { F32x16(_mm512_max_ps(self.0, other.0)) }
    }

    #[inline(always)]
    fn abs(self) -> F32x16 {
        unsafe { F32x16(_mm512_abs_ps(self.0)) }
    }

    #[inline(always)]
    fn sqrt(self) -> F32x16 {
        unsafe { F32x16(_mm512_sqrt_ps(self.0)) }
    }

    #[inline(always)]
    fn floor(self) -> F32x16 {
        unsafe { F32x16(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0)) }
    }

    #[inline(always)]
    fn whole(self) -> F32x16 {
        unsafe { F32x16(_mm512_castsi512_ps(_mm512_cvttps_epi32(self.0))) }
    }

    #[inline(always)]
    fn copysign(self, other: F32x16) -> F32x16 {
        unsafe {
            let sign = _mm512_set1_ps(-0.0);
            F32x16(_mm512_or_ps(_mm512_andnot_ps(sign, self.0), _mm512_and_ps(sign, other.0)))
        }
    }

    #[inline(always)]
    fn gt(self, other: F32x16) -> Mask16 {
        unsafe { Mask16(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, other.0)) }
    }

    #[inline(always)]
    fn ge(self, other: F32x16) -> Mask16 {
        unsafe { Mask16(_mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, other.0)) }
    }

    #[inline(always)]
    fn ordered(self, other: F32x16) -> Mask16 {
        unsafe { Mask16(_mm512_cmp_ps_mask::<_CMP_ORD_Q>(self.0, other.0)) }
    }

    #[inline(always)]
    fn eq_bits(self, other: F32x16) -> Mask16 {
        unsafe { Mask16(_mm512_cmpeq_epi32_mask(_mm512_castps_si512(self.0), _mm512_castps_si512(other.0))) }
    }

    #[inline(always)]
    fn select(mask: Mask16, yes: F32x16, no: F32x16) -> F32x16 {
        unsafe { F32x16(_mm512_mask_blend_ps(mask.0, no.0, yes.0)) }
    }

    #[inline(always)]
    fn masked_store(mask: Mask16, value: u32, to: &mut [u32], at: usize) {
        let lanes = &mut to[at..at + N];
        unsafe { _mm512_mask_storeu_epi32(lanes.as_mut_ptr().cast(), mask.0, _mm512_set1_epi32(value as i32)) }
    }

    #[inline(always)]
    fn low_bytes(self) -> [u8; WIDEST] {
        let mut bytes = [0; WIDEST];
        unsafe { _mm_storeu_si128(bytes.as_mut_ptr().cast(), _mm512_cvtepi32_epi8(_mm512_castps_si512(self.0))) }
        bytes
    }
}

impl Mask for Mask16 {
    const FULL: u32 = 0xffff;

    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

macro_rules! operator {
    ($name:ident, $method:ident, $instruction:ident) => {
        impl $name for F32x16 {
            type Output = F32x16;
            #[inline(always)]
            fn $method(self, other: F32x16) -> F32x16 {
                unsafe { F32x16($instruction(self.0, other.0)) }
            }
        }
    };
}

operator!(Add, add, _mm512_add_ps);
operator!(Sub, sub, _mm512_sub_ps);
operator!(Mul, mul, _mm512_mul_ps);
operator!(Div, div, _mm512_div_ps);

impl Neg for F32x16 {
    type Output = F32x16;
    #[inline(always)]
    fn neg(self) -> F32x16 {
        unsafe { F32x16(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0))) }
    }
}

impl BitAnd for Mask16 {
    type Output = Mask16;
    #[inline(always)]
    fn bitand(self, other: Mask16) -> Mask16 {
        Mask16(self.0 & other.0)
    }
}

impl BitOr for Mask16 {
    type Output = Mask16;
    #[inline(always)]
    fn bitor(self, other: Mask16) -> Mask16 {
        Mask16(self.0 | other.0)
    }
}

/// Runs a kernel with these instructions; the processor must have them.
pub(super) fn run(kernel: impl Kernel) {
    #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma")]
    fn enabled(kernel: impl Kernel) {
        kernel.run::<F32x16>();
    }
    // SAFETY: `super::run` asks the processor first.
    unsafe { enabled(kernel) }
}
