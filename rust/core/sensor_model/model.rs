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
    /// How long a pulse lasts [s].
    pub pulse_duration: f64,
    /// The response over range squared of power 1 [1/m2]; 0: everything is detected.
    pub detection_threshold: f32,
    /// The return mode: whether the last of several echoes is reported, and not the strongest.
    pub last_return: bool,
    /// Whether rays pass through glass.
    pub glass_transmission: bool,
    /// Relative scatter of the power from pulse to pulse.
    pub speckle: f32,
    /// Relative spread of what surfaces send back, from place to place.
    pub texture: f32,
    /// Whether materials add their own grain and roughness.
    pub material_noise: bool,
    /// Depth of the stains on the window.
    pub dust: f32,
    /// By how much ray drop differs from patch to patch: the spread of its logarithm.
    pub fading: f32,
    /// What ray drop adds to the exponent at any power.
    pub drop_exponent: f32,
    /// What ray drop adds to the exponent where a beam makes several echoes.
    pub edge_drop: f32,
    /// Which unit of the sensor this is.
    pub unit: u64,
    /// By how much each beam reports more than its range [m]; none for 0.
    pub range_offsets: Vec<f32>,
    /// How the range offsets of beams differ beyond these [m].
    pub offset_spread: f32,
    /// How the gains of beams differ (relative).
    pub gain_spread: f32,
    /// Range noise of an echo of power 1, on top of that of strong echoes [m].
    pub jitter: f32,
    /// What ranges are rounded to [m].
    pub range_step: f32,
    /// The response that an intensity of 1 stands for; more than 0.
    pub full_scale: f32,
    /// What a response of 1 reads, if it is less than 1: brighter ones climb from there by their logarithm.
    pub knee: f32,
    /// Steps of the intensity.
    pub levels: f32,
    /// What a return reads at least.
    pub least_reading: f32,
    /// What the beams show least, of 1, on average: readings below it are 0.
    pub cutoff: f32,
    /// How the cut-offs of beams differ.
    pub cutoff_spread: f32,
    /// Up to which range the intensity is corrected for range [m]; infinite: at all ranges.
    pub compensation_range: f32,
    /// What each beam reads of a response so corrected, in the place of `full_scale` and `knee`.
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

    /// The response over range squared of power 1; where everything is detected, one that nothing is below.
    pub(super) fn threshold(&self) -> f32 {
        if self.detection_threshold > 0.0 { self.detection_threshold } else { 1e-20 }
    }
}

/// How a sensor reports ranges [m].
#[derive(Clone, Copy, Debug)]
pub struct Ranging {
    /// Standard deviation of the noise of strong echoes.
    pub sigma: f32,
    /// The shortest range.
    pub min: f32,
    /// The longest range.
    pub max: f32,
}
