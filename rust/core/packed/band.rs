//! Sensor patterns as separable grids: a pattern as the scan kernel needs it, in f32.

use std::f64::consts::TAU;

use super::row_lookup::RowLookup;
use crate::SensorSpec;
use crate::medium::RowKey;
use crate::simd::{Lanes, WIDEST};

/// The beams of a pattern with the same origin and nearly the same direction: a grid of rows and columns.
///
/// Its rays are `heading(phase, column) + slope(row) * up`, at horizontal length 1, so linear functions of a direction
/// have one part for each column and one for each row. A pattern without tables per beam is one band. Rows may sample
/// the azimuth at different phases, less than a column apart, as the sub-rays of one beam do: they see the same bodies,
/// which are then bounded once.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    /// The rows of the image, highest first.
    pub(crate) rows: Vec<u32>,
    /// The start of the rays: forward, to the left and up, relative to their azimuth [m].
    pub(crate) origin: [f64; 3],
    /// The tangent of each row's elevation.
    pub(crate) slopes: Vec<f32>,
    /// The length of each row's rays.
    pub(crate) secants: Vec<f32>,
    /// The key of each row for media.
    pub(crate) row_keys: Vec<RowKey>,
    /// The phase of each row.
    pub(crate) phases: Vec<u8>,
    pub(crate) phase_lanes: Vec<f32>,
    /// The number of phases.
    pub(crate) phase_count: usize,
    /// Cosine and sine of each column's azimuth, phase by phase; padded so that any column begins a full vector.
    pub(crate) headings: [Vec<f32>; 2],
    /// The azimuth of the outer edge of column 0 [rad], of a ray between all phases.
    pub(crate) azimuth_start: f64,
    /// The largest distance of any phase from that, in columns.
    pub(crate) phase_reach: f32,
    pub(crate) columns_per_radian: f32,
    /// Columns in a turn, not a whole number for some patterns of less than a turn.
    pub(crate) columns_per_turn: f32,
    /// The length of the longest ray.
    pub(crate) longest_ray: f32,
    lookup: RowLookup,
}

/// The most phases of a band: a power of two, for quick remainders.
pub(crate) const PHASES: usize = 4;
/// Beams further apart are of different bands, in columns: bounds grow by as much.
const MOST_APART: f64 = 1.0;
/// The most columns of a pattern whose bands may have several phases.
const MOST_COLUMNS: usize = 1 << 20;

/// The properties shared by the beams of a band.
struct Shared {
    /// The azimuth offsets of the phases.
    offsets: Vec<f64>,
    origin: [f64; 3],
    /// The power of two below the length of a ray at horizontal length 1.
    magnitude: i32,
}

impl Shared {
    /// The phase for an offset, if there is one or room for one more.
    fn phase(&mut self, offset: f64, apart: f64) -> Option<usize> {
        let [forward, left, _] = self.origin;
        let known = self.offsets.iter().position(|&other| other == offset);
        // Beside the axis, rays of two azimuths start at two places.
        let joins = || {
            let near = self.offsets.iter().all(|&other| (other - offset).abs() <= apart);
            near && self.offsets.len() < PHASES && forward == 0.0 && left == 0.0
        };
        known.or_else(|| joins().then_some(self.offsets.len())).inspect(|&phase| {
            if phase == self.offsets.len() {
                self.offsets.push(offset);
            }
        })
    }

    /// The middle of the offsets, and the largest distance from it.
    fn middle(&self) -> (f64, f64) {
        let low = self.offsets.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.offsets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // A single one is itself, without rounding.
        (low + (high - low) / 2.0, (high - low) / 2.0)
    }
}

impl Band {
    /// The bands of a pattern: beams that nearly share an azimuth offset, and share an origin and the magnitude of
    /// their slope.
    pub(crate) fn from_spec(spec: &SensorSpec) -> Vec<Band> {
        let mut groups: Vec<(Shared, Vec<(usize, usize)>)> = Vec::new();
        // Places in the tables of all phases have to be whole numbers of f32, too.
        let apart = if spec.columns > MOST_COLUMNS { 0.0 } else { MOST_APART };
        let apart = apart * spec.column_width();
        for (row, elevation) in spec.elevations.iter().enumerate() {
            // Rounding grows with the longest ray of a band, so steep beams do not share one with flat ones.
            let magnitude = (1.0 / elevation.cos()).log2() as i32;
            let (offset, origin) = (spec.azimuth_offsets[row], spec.origins[row]);
            let joined = groups.iter_mut().find_map(|(shared, rows)| {
                let alike = shared.origin == origin && shared.magnitude == magnitude;
                alike.then(|| shared.phase(offset, apart)).flatten().map(|phase| rows.push((row, phase)))
            });
            if joined.is_none() {
                groups.push((Shared { offsets: vec![offset], origin, magnitude }, vec![(row, 0)]));
            }
        }
        groups.into_iter().map(|(shared, rows)| Band::new(spec, &shared, &rows)).collect()
    }

    fn new(spec: &SensorSpec, shared: &Shared, rows: &[(usize, usize)]) -> Band {
        let width = spec.column_width();
        let start = |offset: f64| (spec.azimuth_start % TAU + offset % TAU) % TAU;
        let azimuth = |offset: f64, column: usize| start(offset) - (column as f64 + 0.5) * width;
        let padded = padded(spec.columns);
        let headings = |f: fn(f64) -> f64| {
            let of = |&offset: &f64| (0..padded).map(move |w| f(azimuth(offset, w.min(spec.columns - 1))) as f32);
            shared.offsets.iter().flat_map(of).collect()
        };
        let (middle, reach) = shared.middle();
        let elevations = || rows.iter().map(|&(row, _)| spec.elevations[row]);
        let slopes: Vec<f32> = elevations().map(|e| e.tan() as f32).collect();
        let secants: Vec<f32> = elevations().map(|e| (1.0 / e.cos()) as f32).collect();
        Band {
            rows: rows.iter().map(|&(row, _)| row as u32).collect(),
            row_keys: rows.iter().map(|&(row, _)| spec.row_key(row)).collect(),
            phases: rows.iter().map(|&(_, phase)| phase as u8).collect(),
            phase_lanes: rows.iter().map(|&(_, phase)| phase as f32).collect(),
            phase_count: shared.offsets.len(),
            origin: shared.origin,
            lookup: RowLookup::new(&slopes),
            longest_ray: secants.iter().fold(1.0, |a, &b| a.max(b)),
            slopes,
            secants,
            headings: [headings(f64::cos), headings(f64::sin)],
            azimuth_start: start(middle),
            phase_reach: (reach / width) as f32 * 1.001,
            columns_per_radian: (1.0 / width) as f32,
            columns_per_turn: (TAU / width) as f32,
        }
    }

    /// Cosines and sines of the azimuths of a phase, column by column.
    #[inline(always)]
    pub(crate) fn headings(&self, phase: usize) -> [&[f32]; 2] {
        let [cos, sin] = &self.headings;
        let padded = cos.len() / self.phase_count;
        [&cos[phase * padded..][..padded], &sin[phase * padded..][..padded]]
    }

    /// The first and the last row with a slope between two; first > last if there is none.
    #[inline(always)]
    pub(crate) fn rows_between<L: Lanes>(&self, low: L, high: L) -> (L, L) {
        self.lookup.rows_between(low, high)
    }
}

/// The length of a table of columns: any of them begins a full vector.
pub(crate) fn padded(columns: usize) -> usize {
    columns.next_multiple_of(WIDEST) + WIDEST
}
