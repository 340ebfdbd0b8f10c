//! Sensor patterns: the map from (row, column) to a ray.

use glam::{DVec2, DVec3};

use crate::packed::Band;
use crate::{Error, Result, SensorSpec};

/// The map from (row, column) to a ray in the sensor frame: H beams by W columns.
///
/// Column w of beam h looks to the azimuth `azimuth_start - (w + 1/2) azimuth_span / W + azimuth_offsets[h]`: the middle of
/// a cell, clockwise seen from above. It starts at `origins[h]`, turned about z by that azimuth: the lasers turn with the
/// head.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPattern {
    spec: SensorSpec,
    /// (cos, sin) of the elevation of each beam.
    rises: Vec<DVec2>,
    /// (cos, sin) of the azimuth offset of each beam.
    turns: Vec<DVec2>,
    /// (cos, sin) of the azimuth of each column before its beam's offset.
    headings: Vec<DVec2>,
    /// Whether all beams start at the same place of the head.
    pub(crate) one_origin: bool,
    bands: Vec<Band>,
}

impl SensorPattern {
    /// A pattern from its description.
    ///
    /// # Errors
    /// [`Error::NoBeams`], [`Error::BeamTable`], [`Error::BeamNotFinite`], [`Error::BeamOrigin`],
    /// [`Error::ElevationLimit`], [`Error::ElevationOrder`], [`Error::Columns`], [`Error::AzimuthStart`], [`Error::AzimuthSpan`] or
    /// [`Error::RangeLimits`].
    pub fn new(spec: SensorSpec) -> Result<SensorPattern> {
        spec.check()?;
        let azimuth =
            |column: usize| spec.azimuth_start - (column as f64 + 0.5) * spec.azimuth_span / spec.columns as f64;
        let angles = |values: &[f64]| values.iter().map(|&a| DVec2::from_angle(a)).collect();
        Ok(SensorPattern {
            rises: angles(&spec.elevations),
            turns: angles(&spec.azimuth_offsets),
            headings: (0..spec.columns).map(|w| DVec2::from_angle(azimuth(w))).collect(),
            one_origin: spec.origins.iter().all(|origin| *origin == spec.origins[0]),
            bands: Band::from_spec(&spec),
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

    /// The parameters of the pattern.
    pub fn spec(&self) -> &SensorSpec {
        &self.spec
    }

    /// The pattern as grids.
    pub(crate) fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// Where a ray starts.
    pub fn origin(&self, row: usize, column: usize) -> DVec3 {
        let [forward, left, up] = self.spec.origins[row];
        let heading = self.heading(row, column);
        (heading * forward + heading.perp() * left).extend(up)
    }

    /// The unit direction of a ray.
    pub fn direction(&self, row: usize, column: usize) -> DVec3 {
        (self.heading(row, column) * self.rises[row].x).extend(self.rises[row].y)
    }

    /// (cos, sin) of the azimuth of a ray.
    fn heading(&self, row: usize, column: usize) -> DVec2 {
        self.turns[row].rotate(self.headings[column])
    }

    /// A distance as an image holds it, or `None` if it is not within the range limits (compared as f32).
    pub fn reported(&self, distance: f64) -> Option<f32> {
        let depth = distance as f32;
        let (min, max) = (self.spec.min_range as f32, self.spec.max_range as f32);
        (depth > 0.0 && depth >= min && depth <= max).then_some(depth)
    }

    /// The unit directions of all rays, row by row.
    pub fn directions(&self) -> Vec<[f64; 3]> {
        self.of_all_rays(|row, column| self.direction(row, column))
    }

    /// Where all rays start, row by row.
    pub fn origins(&self) -> Vec<[f64; 3]> {
        self.of_all_rays(|row, column| self.origin(row, column))
    }

    fn of_all_rays(&self, vector: impl Fn(usize, usize) -> DVec3) -> Vec<[f64; 3]> {
        let pixel = |i| vector(i / self.columns(), i % self.columns()).to_array();
        (0..self.rows() * self.columns()).map(pixel).collect()
    }

    /// The points at these distances along the rays, row by row; the beam's origin for distance 0.
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
            Ok((self.origin(row, column) + along).to_array())
        };
        depth.iter().enumerate().map(point).collect()
    }
}
