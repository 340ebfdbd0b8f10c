//! Sensor patterns as grids that separate: what the scan kernel needs to know of a pattern, in f32.

use std::f64::consts::TAU;

use crate::SensorSpec;
use crate::simd::{Lanes, WIDEST};

/// The beams of a pattern that start at the same place and look nearly the same way: a grid of rows and columns.
///
/// Its rays are `heading(sweep, column) + slope(row) * up`, at horizontal length 1, so that what is linear in a direction is
/// one part a column and one part a row. A pattern without tables per beam is one band. Beams that look less than a column
/// apart, as the sub-rays of one beam do, are sweeps of one band: they see the same bodies, which are then bounded once.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    /// The rows of the image, highest first.
    pub(crate) rows: Vec<u32>,
    /// Where the rays start: forward, to the left and up, seen along their azimuth [m].
    pub(crate) origin: [f64; 3],
    /// The tangent of each row's elevation.
    pub(crate) slopes: Vec<f32>,
    /// The length of each row's rays.
    pub(crate) secants: Vec<f32>,
    /// The sweep of each row, and that as lanes take it.
    pub(crate) sweeps: Vec<u8>,
    pub(crate) places: Vec<f32>,
    /// How many sweeps there are.
    pub(crate) count: usize,
    /// Cosine and sine of each column's azimuth, sweep by sweep; padded so that any column begins a full vector.
    pub(crate) headings: [Vec<f32>; 2],
    /// The azimuth of the outer edge of column 0 [rad], of a ray between all sweeps.
    pub(crate) start: f64,
    /// How far any sweep is from that, in columns.
    pub(crate) spread: f32,
    /// Columns a radian.
    pub(crate) density: f32,
    /// Columns in a turn, which is no whole number for some patterns of less than a turn.
    pub(crate) turn: f32,
    /// The length of the longest ray.
    pub(crate) steepest: f32,
    lookup: RowLookup,
}

/// Which rows lie above or below a slope, by cells of equal height.
#[derive(Clone, Debug, PartialEq)]
struct RowLookup {
    lowest: f32,
    cells: f32,
    /// The first row that is not above the top of each cell.
    first: Vec<f32>,
    /// The last row that is not below the bottom of each cell.
    last: Vec<f32>,
}

/// The most sweeps of a band: a power of two, of which a remainder is quickly taken.
pub(crate) const SWEEPS: usize = 4;
/// Beams further apart are of different bands, in columns: bounds grow by as much.
const APART: f64 = 1.0;
/// The most columns of a pattern whose bands may have several sweeps.
const MOST: usize = 1 << 20;

/// What the beams of a band have in common.
struct Shared {
    /// The azimuths of the sweeps.
    offsets: Vec<f64>,
    origin: [f64; 3],
    /// The power of two below the length of a ray at horizontal length 1.
    magnitude: i32,
}

impl Shared {
    /// The sweep for such an offset, if there is one or may be one more.
    fn sweep(&mut self, offset: f64, apart: f64) -> Option<usize> {
        let [forward, left, _] = self.origin;
        let known = self.offsets.iter().position(|&other| other == offset);
        // Beside the axis, rays of two azimuths start at two places.
        let joins = || {
            let near = self.offsets.iter().all(|&other| (other - offset).abs() <= apart);
            near && self.offsets.len() < SWEEPS && forward == 0.0 && left == 0.0
        };
        known.or_else(|| joins().then_some(self.offsets.len())).inspect(|&sweep| {
            if sweep == self.offsets.len() {
                self.offsets.push(offset);
            }
        })
    }

    /// The middle of the offsets, and how far they are from it.
    fn middle(&self) -> (f64, f64) {
        let low = self.offsets.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.offsets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // A single one is itself, without rounding.
        (low + (high - low) / 2.0, (high - low) / 2.0)
    }
}

impl Band {
    /// The bands of a pattern: beams that nearly share an azimuth offset, and an origin and the magnitude of their slope.
    pub(crate) fn of(spec: &SensorSpec) -> Vec<Band> {
        let mut groups: Vec<(Shared, Vec<(usize, usize)>)> = Vec::new();
        // Places in the tables of all sweeps are whole numbers of f32, too.
        let apart = if spec.columns > MOST { 0.0 } else { APART };
        let apart = apart * spec.azimuth_span / spec.columns as f64;
        for (row, elevation) in spec.elevations.iter().enumerate() {
            // Rounding grows with the longest ray of a band, so steep beams do not share one with flat ones.
            let magnitude = (1.0 / elevation.cos()).log2() as i32;
            let (offset, origin) = (spec.azimuth_offsets[row], spec.origins[row]);
            let joined = groups.iter_mut().find_map(|(shared, rows)| {
                let alike = shared.origin == origin && shared.magnitude == magnitude;
                alike.then(|| shared.sweep(offset, apart)).flatten().map(|sweep| rows.push((row, sweep)))
            });
            if joined.is_none() {
                groups.push((Shared { offsets: vec![offset], origin, magnitude }, vec![(row, 0)]));
            }
        }
        groups.into_iter().map(|(shared, rows)| Band::new(spec, &shared, &rows)).collect()
    }

    fn new(spec: &SensorSpec, shared: &Shared, rows: &[(usize, usize)]) -> Band {
        let width = spec.azimuth_span / spec.columns as f64;
        let start = |offset: f64| (spec.azimuth_start % TAU + offset % TAU) % TAU;
        let azimuth = |offset: f64, column: usize| start(offset) - (column as f64 + 0.5) * width;
        let padded = padded(spec.columns);
        let headings = |f: fn(f64) -> f64| {
            let of = |&offset: &f64| (0..padded).map(move |w| f(azimuth(offset, w.min(spec.columns - 1))) as f32);
            shared.offsets.iter().flat_map(of).collect()
        };
        let (middle, spread) = shared.middle();
        let elevations = || rows.iter().map(|&(row, _)| spec.elevations[row]);
        let slopes: Vec<f32> = elevations().map(|e| e.tan() as f32).collect();
        let secants: Vec<f32> = elevations().map(|e| (1.0 / e.cos()) as f32).collect();
        Band {
            rows: rows.iter().map(|&(row, _)| row as u32).collect(),
            sweeps: rows.iter().map(|&(_, sweep)| sweep as u8).collect(),
            places: rows.iter().map(|&(_, sweep)| sweep as f32).collect(),
            count: shared.offsets.len(),
            origin: shared.origin,
            lookup: RowLookup::new(&slopes),
            steepest: secants.iter().fold(1.0, |a, &b| a.max(b)),
            slopes,
            secants,
            headings: [headings(f64::cos), headings(f64::sin)],
            start: start(middle),
            spread: (spread / width) as f32 * 1.001,
            density: (1.0 / width) as f32,
            turn: (TAU / width) as f32,
        }
    }

    /// Cosines and sines of a sweep's azimuths, column by column.
    #[inline(always)]
    pub(crate) fn headings(&self, sweep: usize) -> [&[f32]; 2] {
        let [cos, sin] = &self.headings;
        let padded = cos.len() / self.count;
        [&cos[sweep * padded..][..padded], &sin[sweep * padded..][..padded]]
    }

    /// The first and the last row whose slope lies between two; first > last if there is none.
    #[inline(always)]
    pub(crate) fn rows_between<L: Lanes>(&self, low: L, high: L) -> (L, L) {
        let RowLookup { lowest, cells, first, last } = &self.lookup;
        let top = L::splat((first.len() - 1) as f32);
        let (zero, lowest, cells) = (L::splat(0.0), L::splat(*lowest), L::splat(*cells));
        let high = ((high - lowest) * cells).max(zero).min(top);
        let low = ((low - lowest) * cells).max(zero).min(top);
        (high.gather(first), low.gather(last))
    }
}

/// How long a table of columns is: any of them begins a full vector.
pub(crate) fn padded(columns: usize) -> usize {
    columns.next_multiple_of(WIDEST) + WIDEST
}

impl RowLookup {
    /// At most so many cells: two tables of 16 KiB stay in the fastest cache.
    const MOST: f32 = 4096.0;

    fn new(slopes: &[f32]) -> RowLookup {
        let (high, low) = (slopes[0], slopes[slopes.len() - 1]);
        let closest = slopes.windows(2).map(|pair| pair[0] - pair[1]).fold(f32::INFINITY, f32::min);
        let span = (high - low).max(1e-3);
        // Some 32 cells between two rows, so that few slopes share a cell with a row.
        let count = (32.0 * span / closest.max(1e-6)).clamp(64.0, RowLookup::MOST);
        let height = span / count;
        // Two cells beyond the rows at either end tell what passes by.
        let lowest = low - 2.0 * height;
        let cells = count as usize + 4;
        // A slope may be rounded into the cell beside its own.
        let slack = 0.01 * height + 4.0 * f32::EPSILON * high.abs().max(low.abs());
        let bottom = |cell: usize| lowest + cell as f32 * height - slack;
        let top = |cell: usize| lowest + (cell + 1) as f32 * height + slack;
        let first = |cell: usize| if cell + 1 == cells { 0 } else { slopes.partition_point(|&s| s > top(cell)) };
        let last = |cell: usize| slopes.partition_point(|&s| s >= bottom(cell)) as f32 - 1.0;
        RowLookup {
            lowest,
            cells: 1.0 / height,
            first: (0..cells).map(|cell| first(cell) as f32).collect(),
            last: (0..cells).map(|cell| if cell == 0 { slopes.len() as f32 - 1.0 } else { last(cell) }).collect(),
        }
    }
}
