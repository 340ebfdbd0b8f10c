//! The constants of a sensor model.

/// What one unit of a sensor makes of light, in this weather; a number at 0 switches an effect off, if its line does
/// not say otherwise.
#[derive(Clone, Debug)]
pub struct SensorModel {
    /// The shares that the sub-rays of a beam have of its power.
    pub shares: Vec<f32>,
    /// Echoes closer than this are one [m].
    pub pulse_length: f32,
    /// The response over range squared of power 1 [1/m2]; 0: everything is detected.
    pub faintest: f32,
    /// Light lost on a metre of the way [1/m]; there and back it is twice that.
    pub extinction: f32,
    /// Whether the last of several echoes counts, and not the strongest.
    pub last: bool,
    /// Whether rays pass through glass.
    pub panes: bool,
    /// Relative scatter of the power from pulse to pulse.
    pub speckle: f32,
    /// Relative scatter of the power over patches of a surface.
    pub texture: f32,
    /// Whether materials add their own grain and relief.
    pub grainy: bool,
    /// Depth of the stains on the window.
    pub dust: f32,
    /// By how much more echoes are lost in some patches than in others: the spread of its logarithm.
    pub fading: f32,
    /// The share of echoes that is lost at any power.
    pub chance: f32,
    /// Which unit of the sensor this is.
    pub unit: u64,
    /// How the range offsets of beams differ [m].
    pub offset_spread: f32,
    /// How the gains of beams differ (relative).
    pub gain_spread: f32,
    /// Noise of strong echoes [m].
    pub range_sigma: f32,
    /// Noise of an echo of power 1 on top of it [m].
    pub jitter: f32,
    /// What ranges are rounded to [m].
    pub range_step: f32,
    /// The shortest range that is told [m].
    pub min_range: f32,
    /// The longest range that is told [m].
    pub max_range: f32,
    /// The response that an intensity of 1 stands for.
    pub full_scale: f32,
    /// What a response of 1 reads, if it is less than 1: brighter ones climb from there by their logarithm.
    pub knee: f32,
    /// Steps of the intensity.
    pub levels: f32,
    /// Up to which range the intensity is corrected for range [m]; infinite: at all ranges.
    pub compensated: f32,
}

impl SensorModel {
    /// The response over range squared of power 1; where everything is detected, one that nothing is below.
    pub(super) fn threshold(&self) -> f32 {
        if self.faintest > 0.0 { self.faintest } else { 1e-20 }
    }
}
