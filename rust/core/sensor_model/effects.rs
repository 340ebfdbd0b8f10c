//! The effects on echoes, one function each, for a row of pixels at once, in the order in which light meets them.

use super::elementary::{exp, larger, ln, rounded, smaller};
use super::receiver::{Echoes, received_power};
use super::surfaces::entry;
use super::{Backscatter, Ranging, SensorModel, Surfaces};
use crate::simd::Lanes;

/// Behind glass: the response of the interior (seats, curtains, frames), and the spread of its depth from patch to
/// patch: estimates.
const BEHIND_RESPONSE: f32 = 0.25;
const BEHIND_RELIEF: f32 = 0.3;
/// Cosine of incidence below which rays meet the tops of a rough surface: an estimate.
const GRAZING: f32 = 0.3;
/// The same of an uneven surface, about the slope of its waves: flatter rays meet the next crest.
const WAVE_SLOPE: f32 = 0.1;
/// How often echoes at the detection threshold are dropped, as the mean of an exponential distribution.
const WEAK_DROPS: f32 = 2.0;
/// Standard deviations of the dust's pattern above which there is a stain.
const STAINED: f32 = 1.2;

/// Lets rays pass through glass to the interior a little behind it, and back; `patches` are its relief.
///
/// The stronger echo counts: that of the glass, which is weak unless it faces the sensor, or that from behind.
#[inline(always)]
pub(crate) fn transmit_through_glass(
    echoes: &mut Echoes,
    patches: &[f32],
    surfaces: &Surfaces<'_>,
    model: &SensorModel,
) {
    if !model.glass_transmission {
        return;
    }
    for (column, &primitive) in echoes.primitive.iter().enumerate() {
        let glass = entry(primitive) as usize;
        let through = surfaces.transmission[glass];
        if through > 0.0 {
            let relief = larger(1.0 + BEHIND_RELIEF * patches[column], 0.1);
            let deeper = echoes.depth[column] + surfaces.behind[glass] * relief;
            // the short way behind it is in clear air
            let behind = through * through * BEHIND_RESPONSE / (deeper * deeper * model.threshold());
            if behind > echoes.power[column] {
                (echoes.depth[column], echoes.power[column]) = (deeper, behind);
            }
        }
    }
}

/// Multiplies the powers by a gain and by their scatter.
///
/// `gain` is the logarithm of the beam's gain, `texture` that of each place. Speckle is the sensor's, from pulse to
/// pulse; `grain`, which is written, that of the surface at each pixel. Both are independent from pixel to pixel, so
/// one `normal` number serves for both.
#[inline(always)]
pub(crate) fn scatter_power<L: Lanes>(
    echoes: &mut Echoes,
    gain: f32,
    texture: &[f32],
    grain: &mut [f32],
    normal: &[f32],
    surfaces: &Surfaces<'_>,
    model: &SensorModel,
) {
    echoes.look_up::<L>(surfaces.grain, grain);
    let (grainy, speckle) = (if model.material_noise { 1.0 } else { 0.0 }, model.speckle * model.speckle);
    let pulses = echoes.power.iter_mut().zip(grain.iter());
    for (((power, &grain), &normal), &patch) in pulses.zip(normal).zip(texture) {
        let spread = (grainy * grain * grain + speckle).sqrt();
        *power *= exp(gain + patch * model.texture + spread * normal);
    }
}

/// Dims the light through dust on the window, by its pattern `stains`.
#[inline(always)]
pub(crate) fn dim_by_dust(echoes: &mut Echoes, stains: &[f32], model: &SensorModel) {
    if model.dust == 0.0 {
        return;
    }
    for (power, &stain) in echoes.power.iter_mut().zip(stains) {
        *power *= exp(-model.dust * larger(stain - STAINED, 0.0));
    }
}

/// Replaces weaker and further echoes by that of fog, of a raindrop or a snowflake.
///
/// It comes from no primitive of the layout. `white`, which is written, is its power if all light came back.
#[inline(always)]
pub(crate) fn add_backscatter(
    echoes: &mut Echoes,
    backscatter: &Backscatter<'_>,
    white: &mut [f32],
    extinction: f32,
    model: &SensorModel,
) {
    received_power(backscatter.depth, 1.0, extinction, model, white);
    for (column, (&depth, &response)) in backscatter.depth.iter().zip(backscatter.response).enumerate() {
        let power = white[column] * response;
        let nearer = depth < echoes.depth[column] || echoes.depth[column] == 0.0;
        if nearer && power > echoes.power[column] {
            (echoes.depth[column], echoes.power[column]) = (depth, power);
            (echoes.primitive[column], echoes.incidence[column]) = (-1, 0.0);
        }
    }
}

/// Ray drop: pixels without an echo, or with one that is not detected.
///
/// An echo of power P is dropped with probability 1 - exp(-2 f / P^1.25 - drop_exponent): somewhat less speckle than
/// developed speckle, whose power is distributed as the `exponential` numbers. Factor and exponent are fitted to
/// dropped rays on the ground in recordings of a Pandar64, see docs/explanation/sensor-model.md. The fading f has the mean 1 and
/// follows the `patches` of surfaces, so that dropped rays come in runs. `edge_drop` is added to the exponent if the
/// beam made several echoes: receivers often report none of them.
#[inline(always)]
pub(crate) fn drop_rays(
    echoes: &Echoes,
    patches: &[f32],
    exponential: &[f32],
    model: &SensorModel,
    dropped: &mut [bool],
) {
    let pulses = dropped.iter_mut().zip(&echoes.power).zip(&echoes.split);
    for ((((dropped, &power), &split), &patch), &exponential) in pulses.zip(patches).zip(exponential) {
        let fading = exp(-model.fading * patch - model.fading * model.fading / 2.0);
        let weak = 1.0 / power;
        let anyhow = model.drop_exponent + model.edge_drop * split;
        *dropped = exponential - anyhow <= WEAK_DROPS * fading * weak * weak.sqrt().sqrt();
    }
}

/// The stored intensity, 0 to 1: the power on the sensor's scale, as far as that corrects for range; 0 if the beam
/// would show less than its `cutoff`.
#[inline(always)]
pub(crate) fn intensity(echoes: &Echoes, beam: usize, cutoff: f32, model: &SensorModel, shown: &mut [f32]) {
    let (threshold, far) = (model.threshold(), 1.0 / model.compensation_range);
    for ((shown, &depth), &power) in shown.iter_mut().zip(&echoes.depth).zip(&echoes.power) {
        *shown = depth * depth * power * threshold / (1.0 + depth * far * (depth * far));
    }
    if let Some(curve) = &model.intensity_curve {
        curve.read(beam, &echoes.depth, shown);
    } else if model.knee < 1.0 {
        let climb = (1.0 - model.knee) / model.full_scale.max(1.01).ln();
        for shown in &mut *shown {
            *shown = if *shown > 1.0 { model.knee + climb * ln(*shown) } else { *shown * model.knee };
        }
    } else {
        for shown in &mut *shown {
            *shown *= 1.0 / model.full_scale;
        }
    }
    for shown in &mut *shown {
        *shown = if *shown < cutoff { 0.0 } else { smaller(*shown, 1.0) };
    }
    if model.levels > 0.0 {
        for shown in &mut *shown {
            *shown = rounded(*shown * model.levels) * (1.0 / model.levels);
        }
    }
    for shown in shown {
        *shown = larger(*shown, model.least_reading);
    }
}

/// Brings echoes of uneven surfaces nearer where these are high, and further away where they are low, by their
/// `unevenness` times the field `heights`; along the ray as in [`roughness`]. `work` is written.
#[inline(always)]
pub(crate) fn uneven<L: Lanes>(
    echoes: &mut Echoes,
    heights: &[f32],
    surfaces: &Surfaces<'_>,
    model: &SensorModel,
    work: &mut [f32],
) {
    if !model.material_noise {
        return;
    }
    echoes.look_up::<L>(surfaces.unevenness, work);
    let depths = echoes.depth.iter_mut().zip(&echoes.incidence);
    for (((depth, &incidence), &height), &deviation) in depths.zip(heights).zip(&*work) {
        *depth -= deviation * height / larger(incidence, WAVE_SLOPE);
    }
}

/// Variance of ranges to rough surfaces, whose heights vary by their `rms_height`.
///
/// Along the ray it is the height over the cosine of incidence, except for grazing rays, which meet the tops.
#[inline(always)]
pub(crate) fn roughness<L: Lanes>(
    echoes: &mut Echoes,
    surfaces: &Surfaces<'_>,
    model: &SensorModel,
    variance: &mut [f32],
) {
    if !model.material_noise {
        return variance.fill(0.0);
    }
    echoes.look_up::<L>(surfaces.rms_height, variance);
    for (variance, &incidence) in variance.iter_mut().zip(&echoes.incidence) {
        let height = *variance / larger(incidence, GRAZING);
        *variance = height * height;
    }
}

/// Measures ranges: with the beam's `offset`, Gaussian noise, rounded, within the sensor's limits. The variance is that
/// of the surface, `rough`, and of the timing.
///
/// The timing error of a pulse grows with the inverse root of its signal-to-noise ratio (Jutzi and Stilla, ISPRS 2006),
/// here from `ranging.sigma` of strong echoes by `jitter` at the detection threshold.
#[inline(always)]
pub(crate) fn range_noise(
    echoes: &mut Echoes,
    offset: f32,
    rough: &[f32],
    normal: &[f32],
    ranging: &Ranging,
    model: &SensorModel,
) {
    let (strong, timing) = (ranging.sigma * ranging.sigma, model.jitter * model.jitter);
    let pulses = echoes.depth.iter_mut().zip(&echoes.power);
    for (((depth, &power), &rough), &normal) in pulses.zip(rough).zip(normal) {
        let variance = timing / larger(power, 1.0) + strong + rough;
        *depth = *depth + offset + variance.sqrt() * normal;
    }
    if model.range_step > 0.0 {
        let steps = 1.0 / model.range_step;
        for depth in &mut echoes.depth {
            *depth = rounded(larger(*depth, 0.0) * steps) * model.range_step;
        }
    }
    for depth in &mut echoes.depth {
        *depth = smaller(larger(*depth, ranging.min), ranging.max);
    }
}
