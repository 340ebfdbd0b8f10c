//! Sensor patterns: the map from (row, column) to a ray, and its inverse.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::{Error, Result};

/// What a pattern is made from; row 0 is the highest beam.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorSpec {
    /// The elevation of each beam [rad], strictly decreasing, between -pi/2 and pi/2.
    pub elevations: Vec<f64>,
    /// What each beam adds to the azimuth of its column [rad].
    pub azimuth_offsets: Vec<f64>,
    /// The height that each beam starts from [m].
    pub origin_heights: Vec<f64>,
    /// Rays of each beam.
    pub columns: usize,
    /// The azimuth of the outer edge of column 0 [rad].
    pub azimuth_start: f64,
    /// The azimuth that all columns cover together [rad], greater than 0 and at most 2 pi.
    pub azimuth_span: f64,
    /// Surfaces nearer than this are not reported [m].
    pub min_range: f64,
    /// Surfaces further than this are not reported [m].
    pub max_range: f64,
}

/// How far beyond a range limit a projected point may lie, as a share of the maximum range.
const ROUNDING: f64 = 1e-6;

/// The map from (row, column) to a ray in the sensor frame: H beams by W columns.
///
/// Beam h starts at (0, 0, `origin_heights[h]`), and its column w looks to the azimuth
/// `azimuth_start - (w + 1/2) azimuth_span / W + azimuth_offsets[h]`: the middle of a cell, clockwise seen from above.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPattern {
    spec: SensorSpec,
    /// (cos, sin) of the elevation of each beam.
    rises: Vec<DVec2>,
    /// (cos, sin) of the azimuth offset of each beam.
    turns: Vec<DVec2>,
    /// (cos, sin) of the azimuth of each column before its beam's offset.
    headings: Vec<DVec2>,
    /// The height of all beams, if it is the same.
    common_height: Option<f64>,
}

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

/// Rays beyond this do not fit in memory as images.
const MOST_RAYS: usize = 1 << 28;
/// A span within this of a turn is a whole turn [rad].
const TURN_TOLERANCE: f64 = 1e-9;

impl SensorPattern {
    /// A pattern from its description.
    ///
    /// # Errors
    /// [`Error::NoBeams`], [`Error::BeamTable`], [`Error::BeamNotFinite`], [`Error::ElevationLimit`],
    /// [`Error::ElevationOrder`], [`Error::Columns`], [`Error::AzimuthStart`], [`Error::AzimuthSpan`] or
    /// [`Error::RangeLimits`].
    pub fn new(spec: SensorSpec) -> Result<SensorPattern> {
        spec.check_tables()?;
        spec.check_elevations()?;
        spec.check_limits()?;
        let azimuth =
            |column: usize| spec.azimuth_start - (column as f64 + 0.5) * spec.azimuth_span / spec.columns as f64;
        let angles = |values: &[f64]| values.iter().map(|&a| DVec2::from_angle(a)).collect();
        let first = spec.origin_heights[0];
        let level = spec.origin_heights.iter().all(|&height| height == first);
        Ok(SensorPattern {
            rises: angles(&spec.elevations),
            turns: angles(&spec.azimuth_offsets),
            headings: (0..spec.columns).map(|w| DVec2::from_angle(azimuth(w))).collect(),
            common_height: level.then_some(first),
            spec,
        })
    }

    /// Beams.
    pub fn rows(&self) -> usize {
        self.spec.elevations.len()
    }

    /// Rays of each beam.
    pub fn columns(&self) -> usize {
        self.spec.columns
    }

    /// What the pattern was made from.
    pub fn spec(&self) -> &SensorSpec {
        &self.spec
    }

    /// Where a beam starts.
    pub fn origin(&self, row: usize) -> DVec3 {
        DVec3::new(0.0, 0.0, self.spec.origin_heights[row])
    }

    /// The unit direction of a ray.
    pub fn direction(&self, row: usize, column: usize) -> DVec3 {
        let heading = self.turns[row].rotate(self.headings[column]);
        (heading * self.rises[row].x).extend(self.rises[row].y)
    }

    /// A distance as an image holds it, or `None` if it is not within the range limits (compared as f32).
    pub fn reported(&self, distance: f64) -> Option<f32> {
        let depth = distance as f32;
        let (min, max) = (self.spec.min_range as f32, self.spec.max_range as f32);
        (depth > 0.0 && depth >= min && depth <= max).then_some(depth)
    }

    /// The unit directions of all rays, row by row.
    pub fn directions(&self) -> Vec<[f64; 3]> {
        let pixel = |i| self.direction(i / self.columns(), i % self.columns()).to_array();
        (0..self.rows() * self.columns()).map(pixel).collect()
    }

    /// The points at these distances along the rays, row by row; the beam's origin where the distance is 0.
    ///
    /// # Errors
    /// [`Error::ImageShape`] or [`Error::Depth`].
    pub fn points(&self, depth: &[f32], shape: [usize; 2]) -> Result<Vec<[f64; 3]>> {
        let columns = self.columns();
        if shape != [self.rows(), columns] || depth.len() != self.rows() * columns {
            return Err(Error::ImageShape {
                rows: shape[0],
                columns: shape[1],
                beams: self.rows(),
                pattern_columns: columns,
            });
        }
        let point = |(i, &value): (usize, &f32)| {
            let (row, column) = (i / columns, i % columns);
            if !(0.0..=f32::MAX).contains(&value) {
                return Err(Error::Depth { row, column, value });
            }
            let along = self.direction(row, column) * f64::from(value);
            Ok((self.origin(row) + along).to_array())
        };
        depth.iter().enumerate().map(point).collect()
    }

    /// The pixel of each point: the beam whose elevation is nearest, the column whose cell it lies in.
    ///
    /// A point is outside if it is beyond the azimuth span, further from the highest or lowest beam than half the spacing
    /// there (of the columns, if there is one beam only), not within the range limits or not finite.
    pub fn project(&self, points: &[[f64; 3]]) -> Projection {
        let pixels = points.par_iter().map(|&p| self.pixel(DVec3::from(p)));
        let (rows, (columns, distances)) = pixels
            .map(|pixel| pixel.unwrap_or((-1, -1, 0.0)))
            .map(|(row, column, distance)| (row, (column, distance)))
            .unzip();
        Projection { rows, columns, distances }
    }

    fn pixel(&self, point: DVec3) -> Option<(i32, i32, f32)> {
        if !point.is_finite() {
            return None;
        }
        let row = self.row(point)?;
        let column = self.column(row, point)?;
        let length = (point - self.origin(row)).length();
        // A point of a range limit, in f32 coordinates, may lie a rounding beyond it.
        let within = length.clamp(self.spec.min_range, self.spec.max_range);
        if (length - within).abs() > ROUNDING * self.spec.max_range {
            return None;
        }
        Some((row as i32, column as i32, self.reported(within)?))
    }

    /// The beam nearest in elevation, each seen from its own origin; of two equally near the higher one.
    fn row(&self, point: DVec3) -> Option<usize> {
        let ground = point.truncate().length();
        let elevations = &self.spec.elevations;
        let above = |height: f64, row: usize| (point.z - height).atan2(ground) - elevations[row];
        let (row, off) = if let Some(height) = self.common_height {
            let elevation = above(height, 0) + elevations[0];
            let below = elevations.partition_point(|&beam| beam >= elevation);
            let nearest =
                (below.saturating_sub(1)..=below.min(self.rows() - 1)).map(|row| (row, elevation - elevations[row]));
            nearest.reduce(nearer)?
        } else {
            let all = self.spec.origin_heights.iter().enumerate();
            all.map(|(row, &height)| (row, above(height, row))).reduce(nearer)?
        };
        let too_high = row == 0 && off > self.spacing(0, 1) / 2.0;
        let too_low = row + 1 == self.rows() && -off > self.spacing(row.saturating_sub(1), row) / 2.0;
        (!too_high && !too_low).then_some(row)
    }

    /// The angle between two beams; that of two columns if there is no second beam.
    fn spacing(&self, upper: usize, lower: usize) -> f64 {
        match self.spec.elevations.get(upper..=lower) {
            Some(&[high, low]) => high - low,
            _ => self.spec.azimuth_span / self.columns() as f64,
        }
    }

    /// The column whose cell holds the azimuth of a point, for one beam.
    fn column(&self, row: usize, point: DVec3) -> Option<usize> {
        let outer = self.spec.azimuth_start + self.spec.azimuth_offsets[row];
        let turned = (outer - point.y.atan2(point.x)).rem_euclid(TAU);
        let column = (turned / self.spec.azimuth_span * self.columns() as f64) as usize;
        if self.spec.azimuth_span > TAU - TURN_TOLERANCE {
            return Some(column.min(self.columns() - 1));
        }
        (column < self.columns()).then_some(column)
    }
}

/// The smaller of two deviations; the first if they are equal.
fn nearer(a: (usize, f64), b: (usize, f64)) -> (usize, f64) {
    if b.1.abs() < a.1.abs() { b } else { a }
}

impl SensorSpec {
    fn check_tables(&self) -> Result<()> {
        let beams = self.elevations.len();
        if beams == 0 {
            return Err(Error::NoBeams);
        }
        let tables = [
            ("elevations", &self.elevations),
            ("azimuth_offsets", &self.azimuth_offsets),
            ("origin_heights", &self.origin_heights),
        ];
        for (table, values) in tables {
            let entries = values.len();
            if entries != beams {
                return Err(Error::BeamTable { table, entries, beams });
            }
            if let Some(beam) = values.iter().position(|x| !x.is_finite()) {
                let value = values[beam];
                return Err(Error::BeamNotFinite { table, beam, value });
            }
        }
        Ok(())
    }

    fn check_elevations(&self) -> Result<()> {
        for (beam, &value) in self.elevations.iter().enumerate() {
            if value.abs() >= FRAC_PI_2 {
                return Err(Error::ElevationLimit { beam, value });
            }
        }
        for (beam, pair) in self.elevations.windows(2).enumerate() {
            let (previous, value) = (pair[0], pair[1]);
            if value >= previous {
                let beam = beam + 1;
                return Err(Error::ElevationOrder { beam, value, previous });
            }
        }
        Ok(())
    }

    fn check_limits(&self) -> Result<()> {
        let limit = MOST_RAYS / self.elevations.len();
        if !(1..=limit).contains(&self.columns) {
            let columns = i64::try_from(self.columns).unwrap_or(i64::MAX);
            return Err(Error::Columns { columns, limit });
        }
        if !self.azimuth_start.is_finite() {
            return Err(Error::AzimuthStart { value: self.azimuth_start });
        }
        if !(self.azimuth_span > 0.0 && self.azimuth_span <= TAU + TURN_TOLERANCE) {
            return Err(Error::AzimuthSpan { value: self.azimuth_span });
        }
        let (min, max) = (self.min_range, self.max_range);
        if !(0.0 <= min && min < max && max.is_finite()) {
            return Err(Error::RangeLimits { min, max });
        }
        Ok(())
    }
}
