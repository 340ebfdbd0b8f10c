//! Texture: how much more or less surfaces send back from place to place, and how much higher they are there, fields that
//! are anchored in the world.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use glam::{DVec2, DVec3};

use super::elementary::{cos_sin, whole_part};
use crate::{Error, Pose, Result, SensorPattern};

/// Cells a metre, and shares of the standard deviation: asphalt is as patchy in recordings
/// (docs/explanation/sensor-model.md).
const OCTAVES: [(f32, f32); 4] = [(10.0, 0.22), (2.5, 0.30), (0.7, 0.44), (0.2, 0.82)];
/// The shares of the deviation of heights, an estimate: waves of 0.3 to 4 m. Longer ones are those of the layout.
const HEIGHTS: [f32; 4] = [0.15, 0.45, 0.88, 0.0];
/// The period of the cells' numbers [m]: this many are exact enough in 32 bits.
const PERIOD: f64 = 4096.0;
/// Added to every coordinate [m], so that the seam between two periods is away from layouts.
const OFFSET: f64 = PERIOD / 2.0 + 0.37;
/// Added afterwards [m]: no beam reaches below 0 from there.
const REACH: f64 = 1024.0;
/// A uniform number of 0 to 2^16 has this deviation.
const DEVIATION: f32 = 65536.0 / 3.464_101_6;

/// Where the beams of a sweep end.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// The rays of all sub-rays, of which the middle one stands for each beam.
    pub rays: &'a SensorPattern,
    /// world_from_sensor of all columns, or of each.
    pub poses: &'a [Pose],
}

/// The places [m] of the pulses of a row, each coordinate over 0 and within some [`PERIOD`]s.
pub(crate) type Points = [Vec<f32>; 3];

impl Places<'_> {
    pub(super) fn check(&self, rays: usize, columns: usize) -> Result<()> {
        let (found, poses) = ([self.rays.rows(), self.rays.columns()], self.poses.len());
        if found != [rays, columns] {
            return Err(Error::ImageShape { rows: rays, columns, beams: found[0], pattern_columns: found[1] });
        }
        if poses == 1 || poses == columns { Ok(()) } else { Err(Error::PoseCount { poses, columns }) }
    }

    /// The pose of the head in each column: its place, and its axes ahead, to the left and up, coordinate by
    /// coordinate.
    pub(super) fn heads(&self) -> [Points; 4] {
        let (spec, mut heads) = (self.rays.spec(), <[Points; 4]>::default());
        for column in 0..spec.columns {
            let pose = &self.poses[column % self.poses.len()];
            let turned = spec.azimuth_start - (column as f64 + 0.5) * spec.azimuth_span / spec.columns as f64;
            let ahead = DVec2::from_angle(turned);
            let from = pose.translation + DVec3::splat(OFFSET);
            let from = from - (from / PERIOD).floor() * PERIOD + DVec3::splat(REACH);
            let axes = [ahead.extend(0.0), ahead.perp().extend(0.0), DVec3::Z].map(|axis| pose.vector(axis));
            for (head, vector) in heads.iter_mut().zip([from, axes[0], axes[1], axes[2]]) {
                head.iter_mut().zip(vector.to_array()).for_each(|(all, value)| all.push(value as f32));
            }
        }
        heads
    }

    /// The places at these ranges along the beam of row `ray` of all sub-rays.
    #[inline(always)]
    pub(super) fn along(&self, [from, ahead, left, up]: &[Points; 4], ray: usize, depth: &[f32], points: &mut Points) {
        let spec = self.rays.spec();
        let (turn, rise) = (DVec2::from_angle(spec.azimuth_offsets[ray]), DVec2::from_angle(spec.elevations[ray]));
        let [start_ahead, start_left, start_up] = spec.origins[ray];
        let start = turn.rotate(DVec2::new(start_ahead, start_left)).extend(start_up).as_vec3();
        let along = (turn * rise.x).extend(rise.y).as_vec3();
        for axis in 0..3 {
            points[axis].clear();
            let axes = ahead[axis].iter().zip(&left[axis]).zip(&up[axis]);
            points[axis].extend(depth.iter().zip(&from[axis]).zip(axes).map(
                |((&depth, &from), ((&ahead, &left), &up))| {
                    let reach = start + along * depth;
                    from + (reach.x * ahead + reach.y * left + reach.z * up)
                },
            ));
        }
    }
}

/// Writes both fields at each place: nearly normal numbers of variance 1, alike at close places. High places are often
/// the brighter ones, as tussocks are over soil: one set of numbers serves for both.
#[inline(always)]
pub(crate) fn texture([x, y, z]: &Points, field: &mut [f32], heights: &mut [f32]) {
    field.fill(0.0);
    heights.fill(0.0);
    for (seed, ((cells, share), height)) in (1_u32..).zip(OCTAVES.into_iter().zip(HEIGHTS)) {
        let fields = field.iter_mut().zip(heights.iter_mut());
        for ((((field, heights), &x), &y), &z) in fields.zip(x).zip(y).zip(z) {
            let number = octave([x * cells, y * cells, z * cells], seed);
            *field += share / DEVIATION * number;
            *heights += height / DEVIATION * number;
        }
    }
}

/// The blend of the numbers of the eight corners of a cell, whose variance is the same everywhere.
#[inline(always)]
fn octave(at: [f32; 3], seed: u32) -> f32 {
    const FACTORS: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];
    let (mut keys, mut weights) = ([[0_u32; 2]; 3], [[0.0_f32; 2]; 3]);
    for axis in 0..3 {
        let cell = whole_part(at[axis]);
        let (cosine, sine) = cos_sin((at[axis] - cell.cast_signed() as f32 - 0.5) * FRAC_PI_2);
        keys[axis] = [cell.wrapping_mul(FACTORS[axis]), cell.wrapping_add(1).wrapping_mul(FACTORS[axis])];
        weights[axis] = [(cosine - sine) * FRAC_1_SQRT_2, (cosine + sine) * FRAC_1_SQRT_2];
    }
    let mut sum = 0.0;
    for corner in 0..8 {
        let (i, j, k) = (corner & 1, corner >> 1 & 1, corner >> 2);
        let mut bits = (keys[0][i] ^ keys[1][j] ^ keys[2][k]).wrapping_add(seed.wrapping_mul(0x27d4_eb2f));
        bits = (bits ^ bits >> 15).wrapping_mul(0x2c1b_3c6d);
        bits = (bits ^ bits >> 13).wrapping_mul(0x297a_2d39);
        let number = (bits >> 16).cast_signed() as f32 - 32767.5;
        sum += weights[0][i] * weights[1][j] * weights[2][k] * number;
    }
    sum
}
