//! The inverse of a sensor pattern: the pixel of a point.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::SensorPattern;
use crate::sensor_spec::TURN_TOLERANCE;
use crate::threads::spread;

/// The pixels of a list of points; a point outside the pattern has row and column -1 and distance 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    /// The beam of each point.
    pub rows: Vec<i32>,
    /// The column of each point.
    pub columns: Vec<i32>,
    /// The distance of each point from the origin of its beam [m].
    pub distances: Vec<f32>,
}

/// The largest excess of a projected point over a range limit, as a share of the maximum range.
const ROUNDING: f64 = 1e-6;
/// Points in a thread's block.
const BLOCK: usize = 4096;

/// A beam that can be turned to a point, and their relation.
#[derive(Clone, Copy)]
struct Candidate {
    row: usize,
    /// The elevation of the point over the beam [rad].
    elevation_offset: f64,
    /// The azimuth at which the beam passes over or under the point [rad].
    azimuth: f64,
    /// The distance of the point from the origin of the beam [m].
    distance: f64,
}

impl SensorPattern {
    /// The pixel of each point: the beam with the nearest elevation, and the column whose cell the point is in.
    ///
    /// A point is outside if no beam can be turned to it, if it is beyond the azimuth span, not within the range
    /// limits, or not finite. It is also outside if it is further from the highest or lowest beam than half the spacing
    /// there (of the columns for a single beam).
    pub fn project(&self, points: &[[f64; 3]]) -> Projection {
        let count = points.len();
        let mut found = Projection { rows: vec![-1; count], columns: vec![-1; count], distances: vec![0.0; count] };
        let pixels = found.rows.chunks_mut(BLOCK).zip(found.columns.chunks_mut(BLOCK));
        let blocks = points.chunks(BLOCK).zip(pixels.zip(found.distances.chunks_mut(BLOCK))).collect();
        spread(0, blocks, |(points, ((rows, columns), distances)): (&[_], ((&mut [_], &mut [_]), &mut [_]))| {
            for (k, &point) in points.iter().enumerate() {
                if let Some(pixel) = self.pixel(DVec3::from(point)) {
                    (rows[k], columns[k], distances[k]) = pixel;
                }
            }
        });
        found
    }

    fn pixel(&self, point: DVec3) -> Option<(i32, i32, f32)> {
        if !point.is_finite() {
            return None;
        }
        let Candidate { row, azimuth, distance, .. } = self.nearest_beam(point)?;
        let column = self.column(row, azimuth)?;
        let (min, max) = (self.spec().min_range, self.spec().max_range);
        // A point at a range limit, in f32 coordinates, may be a rounding beyond it.
        let within = distance.clamp(min, max);
        if (distance - within).abs() > ROUNDING * max {
            return None;
        }
        Some((row as i32, column as i32, self.reported(within)?))
    }

    /// The beam nearest in elevation, each relative to its own origin; of two equally near the higher one.
    fn nearest_beam(&self, point: DVec3) -> Option<Candidate> {
        let elevations = &self.spec().elevations;
        let last = self.rows() - 1;
        let best = if self.one_origin {
            // The point has the same elevation for every beam.
            let beside = |met: Candidate| {
                let elevation = elevations[0] + met.elevation_offset;
                let below = elevations.partition_point(|&beam| beam >= elevation);
                (below.saturating_sub(1)..=below.min(last)).map(move |row| Candidate {
                    row,
                    elevation_offset: elevation - elevations[row],
                    ..met
                })
            };
            self.candidates(0, point).flat_map(beside).reduce(nearer)?
        } else {
            (0..=last).flat_map(|row| self.candidates(row, point)).reduce(nearer)?
        };
        let too_high = best.row == 0 && best.elevation_offset > self.spacing(0, 1) / 2.0;
        let too_low = best.row == last && -best.elevation_offset > self.spacing(last.saturating_sub(1), last) / 2.0;
        (!too_high && !too_low).then_some(best)
    }

    /// The points of a beam's turn at which it meets a point: seldom two, and none if it passes beside it at every
    /// azimuth.
    ///
    /// From above, the beam at azimuth a passes R(a) (forward + t, left) at the distance t. So it meets the point, r
    /// from the axis, if forward + t is a root of r^2 - left^2.
    fn candidates(&self, row: usize, point: DVec3) -> impl Iterator<Item = Candidate> {
        let [forward, left, up] = self.spec().origins[row];
        let (x, y, rise) = (point.x, point.y, point.z - up);
        let from_axis = point.truncate().length();
        let radius = if left == 0.0 { from_axis } else { ((from_axis - left) * (from_axis + left)).sqrt() };
        let elevation = self.spec().elevations[row];
        // The negative root is behind the axis: met only by a beam that starts there.
        [radius, -radius].into_iter().filter(move |&along| along >= forward).map(move |along| {
            let ground = along - forward;
            Candidate {
                row,
                elevation_offset: rise.atan2(ground) - elevation,
                azimuth: y.atan2(x) - left.atan2(along),
                distance: DVec2::new(ground, rise).length(),
            }
        })
    }

    /// The angle between two beams; that of two columns if there is no second beam.
    fn spacing(&self, upper: usize, lower: usize) -> f64 {
        match self.spec().elevations.get(upper..=lower) {
            Some(&[high, low]) => high - low,
            _ => self.spec().azimuth_span / self.columns() as f64,
        }
    }

    /// The column whose cell holds an azimuth, for one beam.
    fn column(&self, row: usize, azimuth: f64) -> Option<usize> {
        let spec = self.spec();
        let turned = (spec.azimuth_start + spec.azimuth_offsets[row] - azimuth).rem_euclid(TAU);
        let column = (turned / spec.azimuth_span * self.columns() as f64) as usize;
        if spec.azimuth_span > TAU - TURN_TOLERANCE {
            return Some(column.min(self.columns() - 1));
        }
        (column < self.columns()).then_some(column)
    }
}

/// The smaller of two deviations; the first if they are equal.
fn nearer(a: Candidate, b: Candidate) -> Candidate {
    if b.elevation_offset.abs() < a.elevation_offset.abs() { b } else { a }
}
