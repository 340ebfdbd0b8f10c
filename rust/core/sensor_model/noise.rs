//! Random numbers of pixels: pure functions of seed, stream, row and column, the same on any number of threads.

use std::f32::consts::FRAC_PI_2;

use super::elementary::{cos_sin, ln};
use crate::medium::mix;

/// The uses of random numbers; each stream is independent of the others.
#[derive(Clone, Copy)]
pub(crate) enum Stream {
    /// Speckle, ray drop and range of each pulse.
    Pulses,
    /// Where weak echoes are dropped in patches.
    Fading,
    /// Offsets and gains of a unit's beams.
    Beams,
    /// Stains on a unit's window.
    Stains,
    /// Cut-offs of a unit's beams.
    Cutoffs,
}

/// The key that is hashed, with the column, to the random numbers of a row.
#[derive(Clone, Copy)]
pub(crate) struct Key(u64);

impl Key {
    pub(crate) fn new(seed: u64, stream: Stream, row: usize) -> Key {
        Key(mix(mix(seed) ^ ((stream as u64) << 32 | row as u64)))
    }

    /// 64 random bits of a column: those of SplitMix64 from this state on.
    #[inline(always)]
    pub(crate) fn bits(self, column: usize) -> u64 {
        mix(self.0.wrapping_add((column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }
}

/// Three independent random numbers for each pixel of a row.
#[derive(Default)]
pub(crate) struct Numbers {
    /// Normally distributed, up to 5.8 standard deviations.
    pub(crate) normal: Vec<f32>,
    /// Another one.
    pub(crate) other: Vec<f32>,
    /// Exponentially distributed with mean 1, up to 16.6.
    pub(crate) exponential: Vec<f32>,
    high: Vec<u32>,
    low: Vec<u32>,
}

impl Numbers {
    #[inline(always)]
    pub(crate) fn sample(&mut self, key: Key, columns: usize) {
        for numbers in [&mut self.normal, &mut self.other, &mut self.exponential] {
            numbers.resize(columns, 0.0);
        }
        for words in [&mut self.high, &mut self.low] {
            words.resize(columns, 0);
        }
        for (column, (high, low)) in self.high.iter_mut().zip(&mut self.low).enumerate() {
            let bits = key.bits(column);
            (*high, *low) = ((bits >> 32) as u32, bits as u32);
        }
        let two = self.normal.iter_mut().zip(&mut self.other);
        for (((normal, other), &high), &low) in two.zip(&self.high).zip(&self.low) {
            (*normal, *other) = two_normal(high, low);
        }
        for (exponential, &high) in self.exponential.iter_mut().zip(&self.high) {
            *exponential = -ln(uniform(high >> 9));
        }
    }
}

/// Two independent numbers of a normal distribution out of the lower 9 bits of one word and the 32 of another.
///
/// Box and Muller, "A Note on the Generation of Random Normal Deviates", 1958, for an angle within one quarter of the
/// circle, and a sign of each. The middle of the quarter is 0 here, which turns (cos, sin) by an eighth.
#[inline(always)]
fn two_normal(high: u32, low: u32) -> (f32, f32) {
    let radius = (-ln(uniform(low >> 9))).sqrt();
    let steps = (high & 0x1ff) << 7 | low >> 2 & 0x7f;
    let angle = (steps as i32 as f32 + 0.5) * (FRAC_PI_2 / 65536.0) - FRAC_PI_2 / 2.0;
    let (cosine, sine) = cos_sin(angle);
    let signed = |x: f32, sign: u32| f32::from_bits(x.to_bits() ^ sign << 31);
    (signed(radius * (cosine - sine), low & 1), signed(radius * (cosine + sine), low >> 1 & 1))
}

/// A number within (0, 1), in 2^23 steps, out of the lower 23 bits.
#[inline(always)]
pub(crate) fn uniform(bits: u32) -> f32 {
    ((bits & 0x7f_ffff) as i32 as f32 + 0.5) * (1.0 / 8_388_608.0)
}

/// Rows of noise of variance 1 that changes slowly: over [`PATCH`] columns and half as many rows.
pub(crate) struct Patches {
    /// Normal numbers, a row for each `PATCH / 2` rows and one more.
    coarse: Vec<Vec<f32>>,
}

/// The columns over which fading and dust change.
const PATCH: usize = 8;

impl Patches {
    pub(crate) fn new(seed: u64, stream: Stream, rows: usize, columns: usize) -> Patches {
        let mut numbers = Numbers::default();
        let coarse_row = |row| {
            numbers.sample(Key::new(seed, stream, row), columns / PATCH + 2);
            numbers.normal.clone()
        };
        Patches { coarse: (0..rows / (PATCH / 2) + 2).map(coarse_row).collect() }
    }

    /// One row, blended from its neighbours so that the variance stays.
    #[inline(always)]
    pub(crate) fn blend(&self, row: usize, noise: &mut [f32]) {
        let (above, step) = (row / (PATCH / 2), row % (PATCH / 2));
        let blend = |step: usize, steps: usize| {
            let (sine, cosine) = (step as f32 * FRAC_PI_2 / steps as f32).sin_cos();
            move |a: f32, b: f32| a * cosine + b * sine
        };
        let down = blend(step, PATCH / 2);
        let between: Vec<f32> =
            self.coarse[above].iter().zip(&self.coarse[above + 1]).map(|(&a, &b)| down(a, b)).collect();
        let across: [_; PATCH] = std::array::from_fn(|step| blend(step, PATCH));
        for (patch, ends) in noise.chunks_mut(PATCH).zip(between.windows(2)) {
            for (value, blend) in patch.iter_mut().zip(&across) {
                *value = blend(ends[0], ends[1]);
            }
        }
    }
}
