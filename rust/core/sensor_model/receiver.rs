//! From the sub-rays of a pulse to its echo: their powers, and one echo.

use super::elementary::{exp, larger, smaller};
use super::mixed::{Mixed, restart};
use super::surfaces::{entry, look_up, response_place};
use super::{Returns, SensorModel, Surfaces};
use crate::simd::Lanes;

/// The echo of each pulse of a row.
#[derive(Default)]
pub(crate) struct Echoes {
    /// Ranges [m], 0 without an echo.
    pub(crate) depth: Vec<f32>,
    /// Powers over the detection threshold.
    pub(crate) power: Vec<f32>,
    /// Primitives, -1 without an echo.
    pub(crate) primitive: Vec<i32>,
    /// Cosines of incidence.
    pub(crate) incidence: Vec<f32>,
    /// 1 where the pulse made several echoes, of which this is one, else 0.
    pub(crate) split: Vec<f32>,
    /// The sub-rays with different surfaces, and the brightest of them: elsewhere they are alike.
    pub(crate) mixed: Mixed,
    /// Power of each sub-ray [S, W] if everything were white and faced the sensor.
    white: Vec<f32>,
    spread: Spread,
    /// Where in a table of the surfaces something of each pulse is.
    places: Vec<u32>,
    responses: Vec<f32>,
}

/// The differences between the sub-rays of each pulse.
#[derive(Default)]
struct Spread {
    nearest: Vec<f32>,
    furthest: Vec<f32>,
    /// Not 0 if they met several primitives.
    primitive: Vec<i32>,
}

/// The power of echoes from these ranges, 1 being the detection threshold (1 in 7 is detected); depth 0 is no range.
///
/// The lidar equation for surfaces that fill the (sub-)beam: response over range squared, less the extinction there and
/// back.
#[inline(always)]
pub(crate) fn received_power(depth: &[f32], response: f32, extinction: f32, model: &SensorModel, power: &mut [f32]) {
    let scale = 1.0 / model.threshold();
    for (power, &depth) in power.iter_mut().zip(depth) {
        *power = response * scale / larger(depth * depth, 1e-6);
    }
    if extinction > 0.0 {
        for (power, &depth) in power.iter_mut().zip(depth) {
            *power *= exp(-2.0 * extinction * depth);
        }
    }
}

/// One echo a pulse from a row of sub-rays, each with its share of the power.
///
/// Where all of them met one surface, its response is that at their mean incidence.
#[inline(always)]
pub(crate) fn receive<L: Lanes>(
    rays: &Returns<'_>,
    surfaces: &Surfaces<'_>,
    extinction: f32,
    model: &SensorModel,
    echoes: &mut Echoes,
) {
    let columns = rays.depth.len() / model.shares.len();
    echoes.white.resize(rays.depth.len(), 0.0);
    let pieces = echoes.white.chunks_exact_mut(columns).zip(rays.depth.chunks_exact(columns));
    for ((white, depth), &share) in pieces.zip(&model.shares) {
        received_power(depth, share, extinction, model, white);
    }
    echoes.sum_up(rays, columns);
    echoes.find_mixed(rays, columns, model);
    let Echoes { primitive, incidence, places, responses, .. } = echoes;
    restart(places, columns, 0);
    restart(responses, columns, 0.0);
    for ((place, &primitive), &incidence) in places.iter_mut().zip(&*primitive).zip(&*incidence) {
        *place = response_place(primitive, incidence);
    }
    surfaces.responses::<L>(places, responses);
    for (power, &response) in echoes.power.iter_mut().zip(&echoes.responses) {
        *power *= response;
    }
    echoes.incidence.copy_from_slice(&rays.incidence[..columns]);

    restart(&mut echoes.split, columns, 0.0);
    let Echoes { mixed, white, .. } = echoes;
    mixed.gather::<L>(rays, white, columns, surfaces);
    mixed.separate(model);
    for (pulse, &column) in mixed.columns.iter().enumerate() {
        let column = column as usize;
        let pixel = mixed.echo.winner[pulse] as usize * columns + column;
        (echoes.depth[column], echoes.power[column]) = (mixed.echo.depth[pulse], mixed.echo.power[pulse]);
        echoes.split[column] = mixed.echo.split[pulse];
        (echoes.primitive[column], echoes.incidence[column]) = (rays.primitive[pixel], rays.incidence[pixel]);
    }
}

impl Echoes {
    /// The value in a column of the surfaces for the primitive of each pulse.
    #[inline(always)]
    pub(super) fn look_up<L: Lanes>(&mut self, column: &[f32], values: &mut [f32]) {
        for (place, &primitive) in self.places.iter_mut().zip(&self.primitive) {
            *place = entry(primitive);
        }
        look_up::<L>(column, &self.places, values);
    }

    /// Power, range, primitive and mean incidence of each pulse, as if its sub-rays had met one surface, which is white.
    #[inline(always)]
    fn sum_up(&mut self, rays: &Returns<'_>, columns: usize) {
        for image in [&mut self.power, &mut self.depth, &mut self.incidence] {
            restart(image, columns, 0.0);
        }
        self.primitive.clear();
        self.primitive.extend_from_slice(&rays.primitive[..columns]);
        let first = &rays.depth[..columns];
        let (total, mean) = (&mut self.power[..columns], &mut self.depth[..columns]);
        for (depth, white) in rays.depth.chunks_exact(columns).zip(self.white.chunks_exact(columns)) {
            for column in 0..columns {
                total[column] += white[column];
                // from the first on: what is all at one range stays there
                mean[column] += white[column] * (depth[column] - first[column]);
            }
        }
        for column in 0..columns {
            mean[column] = first[column] + mean[column] / total[column];
        }
        let share = columns as f32 / rays.depth.len() as f32;
        for incidence in rays.incidence.chunks_exact(columns) {
            for (mean, &incidence) in self.incidence.iter_mut().zip(incidence) {
                *mean += incidence * share;
            }
        }
    }

    /// Finds the pulses whose sub-rays met more than one primitive, or one in places further apart than a pulse is long.
    #[inline(always)]
    fn find_mixed(&mut self, rays: &Returns<'_>, columns: usize, model: &SensorModel) {
        let Spread { nearest, furthest, primitive } = &mut self.spread;
        restart(nearest, columns, f32::INFINITY);
        restart(furthest, columns, 0.0);
        restart(primitive, columns, 0);
        for depth in rays.depth.chunks_exact(columns) {
            for ((nearest, furthest), &depth) in nearest.iter_mut().zip(&mut *furthest).zip(depth) {
                *nearest = smaller(depth, *nearest);
                *furthest = larger(depth, *furthest);
            }
        }
        for met in rays.primitive.chunks_exact(columns) {
            for ((differs, &met), &first) in primitive.iter_mut().zip(met).zip(&self.primitive) {
                *differs |= met ^ first;
            }
        }
        let (differs, pulse_length) = (&mut *primitive, model.pulse_length() as f32);
        for ((differs, &nearest), &furthest) in differs.iter_mut().zip(&*nearest).zip(&*furthest) {
            *differs = i32::from(*differs != 0) | i32::from(furthest - nearest > pulse_length);
        }
        // without a branch, which no processor would predict
        let mut found = 0;
        let mixed = &mut self.mixed.columns;
        mixed.resize(columns, 0);
        for (column, &differs) in (0..).zip(&*differs) {
            mixed[found] = column;
            found += differs as usize;
        }
        mixed.truncate(found);
    }
}
