//! Elementary functions without branches or calls, so that the compiler vectorises loops over them.
//!
//! Errors are a few units in the last place. There is no fused multiplication: the bits of these functions are the same on
//! every machine. What calls the functions of the platform beside them, as [`super::noise::Patches`] does, may differ there in
//! the last bits.

use std::f32::consts::{LN_2, LOG2_E};

/// Adding this and subtracting it again rounds to a whole number; numbers of 2^22 or more are out of its range.
const ROUNDING: f32 = 12_582_912.0;
const MANTISSA: u32 = 23; // bits

/// The natural logarithm of a number over 0; that of 0 is some -88.
#[inline(always)]
pub(crate) fn ln(x: f32) -> f32 {
    const ROOT_HALF: u32 = 0x3f35_04f3; // the bits of the root of 1/2
    let exponent = x.to_bits().wrapping_sub(ROOT_HALF).cast_signed() >> MANTISSA;
    // from there to the root of 2
    let m = f32::from_bits(x.to_bits().wrapping_sub((exponent << MANTISSA).cast_unsigned()));
    // 2 artanh((m - 1) / (m + 1))
    let s = (m - 1.0) / (m + 1.0);
    let q = s * s;
    let series = 1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0)));
    exponent as f32 * LN_2 + 2.0 * s * series
}

/// The exponential of a number, at least that of -87 and at most that of 88.
#[inline(always)]
pub(crate) fn exp(x: f32) -> f32 {
    // ln 2 in two parts: multiples of the first are exact
    const MOST: f32 = 355.0 / 512.0;
    const REST: f32 = (std::f64::consts::LN_2 - 355.0 / 512.0) as f32;
    let x = x.clamp(-87.0, 88.0);
    let shifted = x * LOG2_E + ROUNDING;
    let n = shifted - ROUNDING;
    let r = (x - n * MOST) - n * REST;
    let series = r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0))));
    let power_of_two = f32::from_bits((shifted.to_bits() << MANTISSA).wrapping_add(1.0_f32.to_bits()));
    (1.0 + r * (1.0 + r * (0.5 + series))) * power_of_two
}

/// The cosine and the sine of an angle of at most pi / 4.
#[inline(always)]
pub(crate) fn cos_sin(x: f32) -> (f32, f32) {
    let q = x * x;
    let cosine = 1.0 - q * (1.0 / 2.0 - q * (1.0 / 24.0 - q * (1.0 / 720.0 - q * (1.0 / 40320.0))));
    let sine = x * (1.0 - q * (1.0 / 6.0 - q * (1.0 / 120.0 - q * (1.0 / 5040.0))));
    (cosine, sine)
}

/// The larger of two numbers, or the second if one is NaN: one instruction, unlike `f32::max`.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, likewise.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The whole part of a number from 0 to less than 2^22, or one less if it is whole: quicker than a cast, which must
/// check its input.
#[inline(always)]
pub(crate) fn whole_part(x: f32) -> u32 {
    (x - 0.5 + ROUNDING).to_bits() & 0x3f_ffff
}

/// The nearest whole number, the even one of two, of a number that is not negative.
#[inline(always)]
pub(crate) fn rounded(x: f32) -> f32 {
    // numbers this large are whole, or nearly
    if x < ROUNDING / 3.0 { (x + ROUNDING) - ROUNDING } else { x }
}
