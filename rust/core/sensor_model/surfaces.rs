//! The responses of primitives.

use super::elementary::{larger, whole_part};
use crate::simd::Lanes;

/// The number of bins of incidence; 0.9 degrees each.
pub const INCIDENCES: usize = 128;

/// The surfaces of a layout as columns: an entry for each primitive, after one for no return.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    /// The share of the light that comes back in each bin of the root of 1 - cosine of incidence.
    pub table: &'a [[f32; INCIDENCES]],
    /// The share that passes through once.
    pub transmission: &'a [f32],
    /// The distance from glass to the next surface behind it [m].
    pub behind: &'a [f32],
    /// Relative scatter of the response from pixel to pixel.
    pub grain: &'a [f32],
    /// The share of the world's texture that the surface has.
    pub texture: &'a [f32],
    /// Standard deviation of the heights of the surface, from return to return [m].
    pub rms_height: &'a [f32],
    /// That from place to place [m].
    pub unevenness: &'a [f32],
}

impl Surfaces<'_> {
    /// The share of the light that comes back from `places`; 1 is a white surface that faces the sensor.
    #[inline(always)]
    pub(super) fn responses<L: Lanes>(&self, places: &[u32], responses: &mut [f32]) {
        look_up::<L>(self.table.as_flattened(), places, responses);
    }
}

/// Where in the table of responses that of a primitive is.
#[inline(always)]
pub(super) fn response_place(primitive: i32, incidence: f32) -> u32 {
    let cell = larger(1.0 - incidence, 0.0).sqrt() * (INCIDENCES as f32 - 1e-3);
    entry(primitive) * INCIDENCES as u32 + whole_part(cell) % INCIDENCES as u32
}

/// The entry of a primitive; negative numbers are no return.
#[inline(always)]
pub(super) fn entry(primitive: i32) -> u32 {
    (primitive.max(-1) + 1).cast_unsigned()
}

/// The values of a table at some places.
#[inline(always)]
pub(super) fn look_up<L: Lanes>(table: &[f32], places: &[u32], values: &mut [f32]) {
    let whole = places.len() - places.len() % L::N;
    for at in (0..whole).step_by(L::N) {
        L::gather_at(table, places, at).store(values, at);
    }
    for (value, &place) in values[whole..].iter_mut().zip(&places[whole..]) {
        *value = table[place as usize];
    }
}
