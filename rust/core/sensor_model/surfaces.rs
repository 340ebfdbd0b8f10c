//! What primitives send back.

use super::elementary::{larger, whole_part};

/// How many bins of incidence there are; 0.9 degrees each.
pub const INCIDENCES: usize = 128;

/// The surfaces of a layout as columns: an entry for each primitive, after one for no return.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    /// The share of the light that comes back in each bin of the root of 1 - cosine of incidence.
    pub table: &'a [[f32; INCIDENCES]],
    /// What passes through once.
    pub transmission: &'a [f32],
    /// Relative scatter of the response from pixel to pixel.
    pub grain: &'a [f32],
    /// Standard deviation of the heights of the surface [m].
    pub rms_height: &'a [f32],
}

impl Surfaces<'_> {
    /// The share of the light that comes back from a primitive; 1 is a white surface that faces the sensor.
    #[inline(always)]
    pub(super) fn response(&self, primitive: i32, incidence: f32) -> f32 {
        let cell = larger(1.0 - incidence, 0.0).sqrt() * (INCIDENCES as f32 - 1e-3);
        self.table[entry(primitive)][whole_part(cell) as usize % INCIDENCES]
    }
}

/// The entry of a primitive; what is below 0 is no return.
#[inline(always)]
pub(super) fn entry(primitive: i32) -> usize {
    (primitive.max(-1) + 1) as usize
}
