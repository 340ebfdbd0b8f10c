//! The parameters of sensor patterns, checked.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::medium::RowKey;
use crate::{Error, Result};

/// The parameters of a pattern; row 0 is the highest beam.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorSpec {
    /// The elevation of each beam [rad], strictly decreasing, between -pi/2 and pi/2.
    pub elevations: Vec<f64>,
    /// The offset of each beam from the azimuth of its column [rad].
    pub azimuth_offsets: Vec<f64>,
    /// Where each beam starts [m]: forward, to the left and up, seen along its own azimuth.
    pub origins: Vec<[f64; 3]>,
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

/// Rays beyond this do not fit in memory as images.
const MOST_RAYS: usize = 1 << 28;
/// Whole numbers up to this are exact in f32, in which the scan kernel counts columns.
const MOST_COLUMNS: usize = 1 << 23;
/// No beam starts, and none reaches, further than this from the sensor [m].
const FURTHEST: f64 = 1e9;
/// A span within this of a turn is a whole turn [rad].
pub(crate) const TURN_TOLERANCE: f64 = 1e-9;

impl SensorSpec {
    /// The distance of columns [rad].
    pub(crate) fn column_width(&self) -> f64 {
        self.azimuth_span / self.columns as f64
    }

    /// The key of a row for media.
    pub(crate) fn row_key(&self, row: usize) -> RowKey {
        RowKey::new(row, self.elevations[row], self.azimuth_offsets[row], self.column_width())
    }

    /// Checks every number.
    pub(crate) fn check(&self) -> Result<()> {
        self.check_tables()?;
        self.check_elevations()?;
        self.check_limits()
    }

    fn check_tables(&self) -> Result<()> {
        let beams = self.elevations.len();
        if beams == 0 {
            return Err(Error::NoBeams);
        }
        let lengths = [("azimuth_offsets", self.azimuth_offsets.len()), ("origins", self.origins.len())];
        if let Some((table, entries)) = lengths.into_iter().find(|&(_, entries)| entries != beams) {
            return Err(Error::BeamTable { table, entries, beams });
        }
        for (table, values) in [("elevations", &self.elevations), ("azimuth_offsets", &self.azimuth_offsets)] {
            if let Some(beam) = values.iter().position(|x| !x.is_finite()) {
                let value = values[beam];
                return Err(Error::BeamNotFinite { table, beam, value });
            }
        }
        let limit = FURTHEST;
        match self.origins.iter().position(|origin| !origin.iter().all(|x| x.abs() <= limit)) {
            Some(beam) => Err(Error::BeamOrigin { beam, value: self.origins[beam], limit }),
            None => Ok(()),
        }
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
        let limit = MOST_COLUMNS.min(MOST_RAYS / self.elevations.len());
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
        if !(0.0 <= min && min < max && max <= FURTHEST) {
            return Err(Error::RangeLimits { min, max });
        }
        Ok(())
    }
}
