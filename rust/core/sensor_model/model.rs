//! The constants of a sensor model.

use super::IntensityCurve;
use crate::{Error, Result};

/// The most sub-rays that a beam can have.
pub const MOST_RAYS: usize = 32;

const LIGHT: f64 = 299_792_458.0; // m/s

/// The effects of one unit of a sensor; a number at 0 switches an effect off, if its line does not say otherwise.
#[derive(Clone, Debug)]
pub struct SensorModel {
    /// The shares that the sub-rays of a beam have of its power.
    pub shares: Vec<f32>,
    /// The duration of a pulse [s].
    pub pulse_duration: f64,
    /// The response over range squared of power 1 [1/m2]; 0: everything is detected.
    pub detection_threshold: f32,
    /// The return mode: whether the last of several echoes is reported, and not the strongest.
    pub last_return: bool,
    /// Whether rays pass through glass.
    pub glass_transmission: bool,
    /// Relative scatter of the power from pulse to pulse.
    pub speckle: f32,
    /// Relative spread of the response of surfaces, from place to place.
    pub texture: f32,
    /// Whether materials add their own grain and roughness.
    pub material_noise: bool,
    /// Depth of the stains on the window.
    pub dust: f32,
    /// By how much ray drop differs from patch to patch: the spread of its logarithm.
    pub fading: f32,
    /// The addend of ray drop to the exponent at any power.
    pub drop_exponent: f32,
    /// The addend of ray drop to the exponent if a beam makes several echoes.
    pub edge_drop: f32,
    /// The number of this unit of the sensor.
    pub unit: u64,
    /// By how much each beam reports more than its range [m]; none for 0.
    pub range_offsets: Vec<f32>,
    /// The spread of the range offsets of beams beyond these [m].
    pub offset_spread: f32,
    /// The spread of the gains of beams (relative).
    pub gain_spread: f32,
    /// Range noise of an echo of power 1, on top of that of strong echoes [m].
    pub jitter: f32,
    /// The step to which ranges are rounded [m].
    pub range_step: f32,
    /// The response with an intensity of 1; more than 0.
    pub full_scale: f32,
    /// The reading of a response of 1, if it is less than 1: brighter ones rise from there by their logarithm.
    pub knee: f32,
    /// Steps of the intensity.
    pub levels: f32,
    /// The least reading of a return.
    pub least_reading: f32,
    /// The least reading of the beams, of 1, on average: lower readings are 0.
    pub cutoff: f32,
    /// The spread of the cut-offs of beams.
    pub cutoff_spread: f32,
    /// The range up to which the intensity is corrected for range [m]; infinite: at all ranges.
    pub compensation_range: f32,
    /// The readings of each beam for a response corrected in this way, in place of `full_scale` and `knee`.
    pub intensity_curve: Option<IntensityCurve>,
}

impl SensorModel {
    /// Looks at every number once.
    ///
    /// # Errors
    /// [`Error::Rays`] or [`Error::SensorModel`].
    pub fn check(&self) -> Result<()> {
        let rays = self.shares.len();
        if !(1..=MOST_RAYS).contains(&rays) {
            return Err(Error::Rays { rays, limit: MOST_RAYS });
        }
        let held = |field, value, holds, limit| {
            if holds { Ok(()) } else { Err(Error::SensorModel { field, value, limit }) }
        };
        for (field, value) in [
            ("detection_threshold", self.detection_threshold),
            ("speckle", self.speckle),
            ("texture", self.texture),
            ("dust", self.dust),
            ("fading", self.fading),
            ("edge_drop", self.edge_drop),
            ("offset_spread", self.offset_spread),
            ("gain_spread", self.gain_spread),
            ("cutoff_spread", self.cutoff_spread),
            ("jitter", self.jitter),
            ("range_step", self.range_step),
            ("levels", self.levels),
        ] {
            held(field, value, value >= 0.0 && value.is_finite(), "finite and 0 or more")?;
        }
        for (field, value) in [("pulse_duration", self.pulse_duration as f32), ("full_scale", self.full_scale)] {
            held(field, value, value > 0.0 && value.is_finite(), "finite and greater than 0")?;
        }
        for &offset in &self.range_offsets {
            held("a range offset", offset, offset.is_finite(), "finite")?;
        }
        let (drop, knee, range) = (self.drop_exponent, self.knee, self.compensation_range);
        held("cutoff", self.cutoff, (0.0..=1.0).contains(&self.cutoff), "0 to 1")?;
        held("least_reading", self.least_reading, (0.0..=1.0).contains(&self.least_reading), "0 to 1")?;
        held("drop_exponent", drop, (0.0..=1.0).contains(&drop), "0 to 1")?;
        held("knee", knee, knee > 0.0 && knee <= 1.0, "greater than 0 and at most 1")?;
        held("compensation_range", range, range > 0.0, "greater than 0")
    }

    /// Whether there is a range offset for each beam, or none.
    pub(super) fn check_offsets(&self, beams: usize) -> Result<()> {
        let found = self.range_offsets.len();
        if found == 0 || found == beams { Ok(()) } else { Err(Error::OffsetTable { found, expected: beams }) }
    }

    /// Echoes closer than this are one [m].
    pub fn pulse_length(&self) -> f64 {
        LIGHT * self.pulse_duration / 2.0
    }

    /// The response over range squared of power 1; if everything is detected, a value below all.
    pub(super) fn threshold(&self) -> f32 {
        if self.detection_threshold > 0.0 { self.detection_threshold } else { 1e-20 }
    }
}

/// The ranging of a sensor [m].
#[derive(Clone, Copy, Debug)]
pub struct Ranging {
    /// Standard deviation of the noise of strong echoes.
    pub sigma: f32,
    /// The shortest range.
    pub min: f32,
    /// The longest range.
    pub max: f32,
}
