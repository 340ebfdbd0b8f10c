//! Mixed pixels: pulses whose sub-rays met more than one surface, and the echo that is reported of each.

use super::elementary::larger;
use super::surfaces::response_place;
use super::{Returns, SensorModel, Surfaces};
use crate::simd::Lanes;

/// The N mixed pixels of a row, whose pulses are S sub-rays.
#[derive(Default)]
pub(crate) struct Mixed {
    /// Their columns [N].
    pub(crate) columns: Vec<u32>,
    /// Ranges of the sub-rays [S, N] [m].
    pub(crate) depth: Vec<f32>,
    /// Powers of the sub-rays [S, N].
    pub(crate) power: Vec<f32>,
    /// The hits of the sub-rays [S, N]: indices of primitives.
    primitive: Vec<i32>,
    /// The echoes [N] that are reported.
    pub(crate) echo: Echo,
    /// Where the responses of sub-rays are, and those.
    places: Vec<u32>,
    responses: Vec<f32>,
    sum: Vec<f32>,
    most: Vec<f32>,
    middle: Vec<f32>,
    brightest: Vec<f32>,
}

/// One echo of each mixed pixel.
#[derive(Default)]
pub(crate) struct Echo {
    /// Mean ranges of the sub-rays that are in it, weighted by power [m].
    pub(crate) depth: Vec<f32>,
    /// Their powers together.
    pub(crate) power: Vec<f32>,
    /// The sub-ray that brought most of it.
    pub(crate) winner: Vec<u32>,
    /// 1 where sub-rays that met another primitive are not in it, else 0.
    pub(crate) split: Vec<f32>,
}

impl Mixed {
    /// Takes the sub-rays of the mixed pixels out of a row; `white` [S, W] are their powers if all were white.
    #[inline(always)]
    pub(crate) fn gather<L: Lanes>(
        &mut self,
        rays: &Returns<'_>,
        white: &[f32],
        columns: usize,
        surfaces: &Surfaces<'_>,
    ) {
        let pulses = self.columns.len();
        restart(&mut self.places, pulses, 0);
        restart(&mut self.responses, pulses, 0.0);
        for numbers in [&mut self.depth, &mut self.power] {
            numbers.resize(pulses * white.len() / columns, 0.0);
        }
        self.primitive.resize(pulses * white.len() / columns, 0);
        for ray in 0..white.len() / columns {
            let (row, pulses) = (ray * columns..(ray + 1) * columns, ray * pulses..(ray + 1) * pulses);
            let (far, primitive) = (&rays.depth[row.clone()], &rays.primitive[row.clone()]);
            let (white, incidence) = (&white[row.clone()], &rays.incidence[row]);
            let (power, met) = (&mut self.power[pulses.clone()], &mut self.primitive[pulses.clone()]);
            let taken = self.depth[pulses].iter_mut().zip(&mut *power).zip(met).zip(&mut self.places);
            for ((((depth, power), met), place), &column) in taken.zip(&self.columns) {
                let column = column as usize;
                (*depth, *power, *met) = (far[column], white[column], primitive[column]);
                *place = response_place(primitive[column], incidence[column]);
            }
            surfaces.responses::<L>(&self.places, &mut self.responses);
            for (power, &response) in power.iter_mut().zip(&self.responses) {
                *power *= response;
            }
        }
    }

    /// Finds the echo of each pulse: the strongest, or with `last_return` the last above the threshold.
    ///
    /// Sub-rays with ranges within the length of a pulse of each other make one echo at their mean range.
    #[inline(always)]
    pub(crate) fn separate(&mut self, model: &SensorModel) {
        let pulses = self.columns.len();
        if pulses == 0 {
            return;
        }
        self.choose(model);
        let pulse_length = model.pulse_length() as f32;
        for numbers in [&mut self.echo.depth, &mut self.echo.power, &mut self.echo.split, &mut self.brightest] {
            restart(numbers, pulses, 0.0);
        }
        restart(&mut self.echo.winner, pulses, 0);
        let Echo { depth: mean, power: total, winner, split } = &mut self.echo;
        let rays = self.depth.chunks_exact(pulses).zip(self.power.chunks_exact_mut(pulses));
        for (ray, (depth, power)) in (0..).zip(rays) {
            // loops over few columns each: the compiler makes no vectors of one over all of them
            for ((power, &depth), &middle) in power.iter_mut().zip(depth).zip(&self.middle) {
                *power = if together(depth, middle, pulse_length) { *power } else { 0.0 };
            }
            for ((mean, &power), (&depth, &middle)) in mean.iter_mut().zip(&*power).zip(depth.iter().zip(&self.middle))
            {
                *mean += power * (depth - middle);
            }
            for (total, &power) in total.iter_mut().zip(&*power) {
                *total += power;
            }
            for ((winner, brightest), &power) in winner.iter_mut().zip(&mut self.brightest).zip(&*power) {
                *winner = if power > *brightest { ray } else { *winner };
                *brightest = larger(power, *brightest);
            }
        }
        for (depth, primitive) in self.depth.chunks_exact(pulses).zip(self.primitive.chunks_exact(pulses)) {
            for pulse in 0..pulses {
                // the far end of slanted ground is no other surface
                let other = primitive[pulse] != self.primitive[winner[pulse] as usize * pulses + pulse];
                let apart = depth[pulse] > 0.0 && !together(depth[pulse], self.middle[pulse], pulse_length);
                split[pulse] = if other && apart { 1.0 } else { split[pulse] };
            }
        }
        for ((mean, &total), &middle) in mean.iter_mut().zip(&*total).zip(&self.middle) {
            *mean = if total > 0.0 { middle + *mean / total } else { 0.0 };
        }
    }

    /// Finds the range in the middle of each echo that is reported: that of a sub-ray.
    #[inline(always)]
    fn choose(&mut self, model: &SensorModel) {
        let pulses = self.columns.len();
        let pulse_length = model.pulse_length() as f32;
        restart(&mut self.most, pulses, f32::NEG_INFINITY);
        restart(&mut self.middle, pulses, 0.0);
        for at in self.depth.chunks_exact(pulses) {
            restart(&mut self.sum, pulses, 0.0);
            for (depth, power) in self.depth.chunks_exact(pulses).zip(self.power.chunks_exact(pulses)) {
                for (((sum, &depth), &power), &at) in self.sum.iter_mut().zip(depth).zip(power).zip(at) {
                    *sum += if together(depth, at, pulse_length) { power } else { 0.0 };
                }
            }
            if model.last_return {
                for (sum, &at) in self.sum.iter_mut().zip(at) {
                    // the furthest above the threshold, or else, below 0, the strongest
                    *sum = if *sum > 1.0 { at } else { -1.0 / (1.0 + *sum) };
                }
            }
            let best = self.most.iter_mut().zip(&mut self.middle);
            for (((most, middle), &preferred), &at) in best.zip(&self.sum).zip(at) {
                *middle = if preferred > *most { at } else { *middle };
                *most = larger(preferred, *most);
            }
        }
    }
}

/// Whether echoes at two ranges are one.
#[inline(always)]
fn together(a: f32, b: f32, pulse_length: f32) -> bool {
    (a - b).abs() <= pulse_length
}

/// The same value repeated, in the memory of the earlier content.
#[inline(always)]
pub(crate) fn restart<T: Copy>(numbers: &mut Vec<T>, count: usize, value: T) {
    numbers.clear();
    numbers.resize(count, value);
}
