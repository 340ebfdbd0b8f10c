//! The readings of one unit's lasers: a curve and a cut-off of each, and gains by distance that they share.

use super::elementary::{larger, ln, smaller};
use crate::{Error, Result};

/// Readings that are worked out at once.
const LANES: usize = 16;

/// Readings, 0 to 1, of responses: linear in the logarithm of the response between the knots, level beyond them.
#[derive(Clone, Debug)]
pub struct IntensityCurve {
    /// Readings over logarithms of responses: one curve for all beams, or one for each.
    readings: Vec<Pieces>,
    /// Logarithms of gains over distances [m]: for all beams, or for each.
    focus: Vec<Pieces>,
    /// Readings of each beam below this are 0; none for 0.
    cutoffs: Vec<f32>,
}

/// A function that is linear between knots and level beyond them.
#[derive(Clone, Debug)]
struct Pieces {
    /// Its value before the first knot.
    first: f32,
    /// Where pieces start, how wide they are, and their slopes.
    pieces: Vec<[f32; 3]>,
}

impl Pieces {
    fn new(at: &[f32], values: &[f32]) -> Pieces {
        let piece = |(at, of): (&[f32], &[f32])| [at[0], at[1] - at[0], (of[1] - of[0]) / (at[1] - at[0])];
        let pieces = at.windows(2).zip(values.windows(2)).map(piece).collect();
        Pieces { first: values.first().copied().unwrap_or(0.0), pieces }
    }

    /// Adds its values at `at` to `sums`.
    #[inline(always)]
    fn add(&self, at: &[f32; LANES], sums: &mut [f32; LANES]) {
        for sum in &mut *sums {
            *sum += self.first;
        }
        for &[start, width, slope] in &self.pieces {
            for (sum, &at) in sums.iter_mut().zip(at) {
                *sum += slope * smaller(larger(at - start, 0.0), width);
            }
        }
    }
}

impl IntensityCurve {
    /// The curves through `responses` and the readings of all beams, or of each; and gains at `distances`, if any, of
    /// all beams or of each.
    ///
    /// # Errors
    /// [`Error::SensorModel`] or [`Error::CurveTable`].
    pub fn new(
        responses: &[f32],
        readings: &[Vec<f32>],
        distances: &[f32],
        gains: &[Vec<f32>],
        cutoffs: Vec<f32>,
    ) -> Result<IntensityCurve> {
        let same = |table, found, expected| {
            if found == expected { Ok(()) } else { Err(Error::CurveTable { table, found, expected }) }
        };
        same("responses", responses.len().min(1), 1)?;
        gains.iter().try_for_each(|gains| same("distance_gains of a beam", gains.len(), distances.len()))?;
        readings.iter().try_for_each(|curve| same("readings of a beam", curve.len(), responses.len()))?;
        all("a response of the curve", responses, |r| r > 0.0, "finite and greater than 0")?;
        all("a distance of the curve", distances, |d| d >= 0.0, "finite and 0 or more")?;
        for gains in gains {
            all("a gain of the curve", gains, |gain| gain > 0.0, "finite and greater than 0")?;
        }
        all("a cut-off of the curve", &cutoffs, |cutoff| cutoff >= 0.0, "finite and 0 or more")?;
        ascending("a response of the curve", responses)?;
        ascending("a distance of the curve", distances)?;
        for curve in readings {
            all("a reading of the curve", curve, |reading| (0.0..=1.0).contains(&reading), "0 to 1")?;
        }
        let logarithms = |values: &[f32]| values.iter().map(|value| value.ln()).collect::<Vec<_>>();
        let at = logarithms(responses);
        let readings = readings.iter().map(|curve| Pieces::new(&at, curve)).collect();
        let focus = gains.iter().map(|gains| Pieces::new(distances, &logarithms(gains))).collect();
        Ok(IntensityCurve { readings, focus, cutoffs })
    }

    /// Whether there is a curve for all beams or one for each, gains for none, all or each, and as many cut-offs as
    /// beams, or none.
    pub(super) fn check(&self, beams: usize) -> Result<()> {
        for (table, found, least, most) in [
            ("readings", self.readings.len(), 1, 1),
            ("distance_gains", self.focus.len(), 0, 1),
            ("cutoffs", self.cutoffs.len(), 0, 0),
        ] {
            if found != beams && !(least..=most).contains(&found) {
                return Err(Error::CurveTable { table, found, expected: beams });
            }
        }
        Ok(())
    }

    /// Replaces each response by the reading of `beam` at these distances [m].
    #[inline(always)]
    pub(super) fn read(&self, beam: usize, distances: &[f32], responses: &mut [f32]) {
        let curve = &self.readings[beam % self.readings.len()];
        let focus = self.focus.get(beam % self.focus.len().max(1));
        let cutoff = self.cutoffs.get(beam).copied().unwrap_or(0.0);
        for (distances, shown) in distances.chunks(LANES).zip(responses.chunks_mut(LANES)) {
            let (mut distance, mut log, mut reading) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            distance[..distances.len()].copy_from_slice(distances);
            for (log, &response) in log.iter_mut().zip(&*shown) {
                *log = ln(response);
            }
            if let Some(focus) = focus {
                focus.add(&distance, &mut log);
            }
            curve.add(&log, &mut reading);
            for (shown, &reading) in shown.iter_mut().zip(&reading) {
                *shown = if reading < cutoff { 0.0 } else { reading };
            }
        }
    }
}

fn all(field: &'static str, values: &[f32], holds: impl Fn(f32) -> bool, limit: &'static str) -> Result<()> {
    match values.iter().copied().find(|&value| !(holds(value) && value.is_finite())) {
        Some(value) => Err(Error::SensorModel { field, value, limit }),
        None => Ok(()),
    }
}

fn ascending(field: &'static str, values: &[f32]) -> Result<()> {
    match values.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(Error::SensorModel { field, value: pair[1], limit: "greater than the one before it" }),
        None => Ok(()),
    }
}
