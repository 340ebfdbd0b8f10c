//! Sensor patterns as grids that separate: what the scan kernel needs to know of a pattern, in f32.

use std::f64::consts::TAU;

use super::lanes::{Lanes, WIDEST};
use crate::SensorSpec;

/// The beams of a pattern that start at the same place and look the same way: a grid of rows and columns.
///
/// Its rays are `heading(column) + slope(row) * up`, at horizontal length 1, so that what is linear in a direction is one
/// part a column and one part a row. A pattern without tables per beam is one band.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    /// The rows of the image, highest first.
    pub(super) rows: Vec<u32>,
    /// Where the rays start: forward, to the left and up, seen along their azimuth [m].
    pub(super) origin: [f64; 3],
    /// The tangent of each row's elevation.
    pub(super) slopes: Vec<f32>,
    /// The length of each row's rays.
    pub(super) secants: Vec<f32>,
    /// Cosine and sine of each column's azimuth; padded so that any column begins a full vector.
    pub(super) headings: [Vec<f32>; 2],
    /// The azimuth of the outer edge of column 0 [rad].
    pub(super) start: f64,
    /// Columns a radian.
    pub(super) density: f32,
    /// Columns in a turn, which is no whole number for some patterns of less than a turn.
    pub(super) turn: f32,
    /// The length of the longest ray.
    pub(super) steepest: f32,
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

/// What the beams of a band have in common.
#[derive(PartialEq)]
struct Shared {
    offset: f64,
    origin: [f64; 3],
    /// The power of two below the length of a ray at horizontal length 1.
    magnitude: i32,
}

impl Band {
    /// The bands of a pattern: beams that share an azimuth offset, an origin and the magnitude of their slope.
    pub(crate) fn of(spec: &SensorSpec) -> Vec<Band> {
        let mut groups: Vec<(Shared, Vec<usize>)> = Vec::new();
        for (row, elevation) in spec.elevations.iter().enumerate() {
            // Rounding grows with the longest ray of a band, so steep beams do not share one with flat ones.
            let magnitude = (1.0 / elevation.cos()).log2() as i32;
            let shared = Shared { offset: spec.azimuth_offsets[row], origin: spec.origins[row], magnitude };
            match groups.iter_mut().find(|(other, _)| *other == shared) {
                Some((_, rows)) => rows.push(row),
                None => groups.push((shared, vec![row])),
            }
        }
        groups.into_iter().map(|(shared, rows)| Band::new(spec, &shared, &rows)).collect()
    }

    fn new(spec: &SensorSpec, &Shared { offset, origin, .. }: &Shared, rows: &[usize]) -> Band {
        let width = spec.azimuth_span / spec.columns as f64;
        let start = (spec.azimuth_start % TAU + offset % TAU) % TAU;
        let azimuth = |column: usize| start - (column as f64 + 0.5) * width;
        let padded = spec.columns.next_multiple_of(WIDEST) + WIDEST;
        let headings = |f: fn(f64) -> f64| (0..padded).map(|w| f(azimuth(w.min(spec.columns - 1))) as f32).collect();
        let elevations = || rows.iter().map(|&row| spec.elevations[row]);
        let slopes: Vec<f32> = elevations().map(|e| e.tan() as f32).collect();
        let secants: Vec<f32> = elevations().map(|e| (1.0 / e.cos()) as f32).collect();
        Band {
            rows: rows.iter().map(|&row| row as u32).collect(),
            origin,
            lookup: RowLookup::new(&slopes),
            steepest: secants.iter().fold(1.0, |a, &b| a.max(b)),
            slopes,
            secants,
            headings: [headings(f64::cos), headings(f64::sin)],
            start,
            density: (1.0 / width) as f32,
            turn: (TAU / width) as f32,
        }
    }

    /// The first and the last row whose slope lies between two; first > last if there is none.
    #[inline(always)]
    pub(super) fn rows_between<L: Lanes>(&self, low: L, high: L) -> (L, L) {
        let RowLookup { lowest, cells, first, last } = &self.lookup;
        let top = L::splat((first.len() - 1) as f32);
        let (zero, lowest, cells) = (L::splat(0.0), L::splat(*lowest), L::splat(*cells));
        let high = ((high - lowest) * cells).max(zero).min(top);
        let low = ((low - lowest) * cells).max(zero).min(top);
        (high.gather(first), low.gather(last))
    }
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
