//! What one unit's lasers read of an echo: a curve of all of them, and a gain, an offset and a cut-off of each.

use super::elementary::{larger, ln, smaller};
use crate::{Error, Result};

/// Readings that are worked out at once.
const LANES: usize = 16;

/// Readings, 0 to 1, of responses: linear in the logarithm of the response between the knots, level beyond them.
#[derive(Clone, Debug)]
pub struct IntensityCurve {
    /// What the first knot reads.
    first: f32,
    segments: Vec<Segment>,
    /// What each beam's responses are multiplied by; none for 1. So with the next two, for 0.
    gains: Vec<f32>,
    /// What each beam reads less.
    offsets: Vec<f32>,
    /// Readings below this are 0.
    cutoffs: Vec<f32>,
}

/// A piece of the curve, from one knot to the next.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// The logarithm of the response where it starts.
    start: f32,
    width: f32,
    slope: f32,
}

impl IntensityCurve {
    /// The curve through `knots` of response and reading; the other tables have a value for each beam, or none.
    ///
    /// # Errors
    /// [`Error::SensorModel`] or [`Error::CurveTable`].
    pub fn new(knots: &[(f32, f32)], gains: Vec<f32>, offsets: Vec<f32>, cutoffs: Vec<f32>) -> Result<IntensityCurve> {
        let held = |field, value: f32, holds, limit| {
            if holds && value.is_finite() { Ok(()) } else { Err(Error::SensorModel { field, value, limit }) }
        };
        for &(response, reading) in knots {
            held("a response of the curve", response, response > 0.0, "finite and greater than 0")?;
            held("a reading of the curve", reading, (0.0..=1.0).contains(&reading), "0 to 1")?;
        }
        for pair in knots.windows(2) {
            held("a response of the curve", pair[1].0, pair[0].0 < pair[1].0, "greater than the one before it")?;
        }
        for &gain in &gains {
            held("a gain of the curve", gain, gain > 0.0, "finite and greater than 0")?;
        }
        for &offset in &offsets {
            held("an offset of the curve", offset, true, "finite")?;
        }
        for &cutoff in &cutoffs {
            held("a cut-off of the curve", cutoff, cutoff >= 0.0, "finite and 0 or more")?;
        }
        let first = knots.first().ok_or(Error::CurveTable { table: "knots", found: 0, expected: 1 })?.1;
        let segment = |pair: &[(f32, f32)]| {
            let (start, end) = (pair[0].0.ln(), pair[1].0.ln());
            Segment { start, width: end - start, slope: (pair[1].1 - pair[0].1) / (end - start) }
        };
        Ok(IntensityCurve { first, segments: knots.windows(2).map(segment).collect(), gains, offsets, cutoffs })
    }

    /// Whether each table has as many values as there are beams, or none.
    pub(super) fn check(&self, beams: usize) -> Result<()> {
        for (table, values) in [("gains", &self.gains), ("offsets", &self.offsets), ("cutoffs", &self.cutoffs)] {
            if ![0, beams].contains(&values.len()) {
                return Err(Error::CurveTable { table, found: values.len(), expected: beams });
            }
        }
        Ok(())
    }

    /// Puts what `beam` reads in the place of each response.
    #[inline(always)]
    pub(super) fn read(&self, beam: usize, responses: &mut [f32]) {
        let of = |values: &[f32], otherwise| values.get(beam).copied().unwrap_or(otherwise);
        let (gain, offset, cutoff) = (of(&self.gains, 1.0), of(&self.offsets, 0.0), of(&self.cutoffs, 0.0));
        for shown in responses.chunks_mut(LANES) {
            let (mut log, mut reading) = ([0.0; LANES], [self.first - offset; LANES]);
            for (log, &response) in log.iter_mut().zip(&*shown) {
                *log = ln(response * gain);
            }
            for &Segment { start, width, slope } in &self.segments {
                for (reading, &log) in reading.iter_mut().zip(&log) {
                    *reading += slope * smaller(larger(log - start, 0.0), width);
                }
            }
            for (shown, &reading) in shown.iter_mut().zip(&reading) {
                *shown = if reading < cutoff { 0.0 } else { larger(reading, 0.0) };
            }
        }
    }
}
