//! Look-up of the rows between two slopes.

use crate::simd::Lanes;

/// The rows above and below a slope, by cells of equal height.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RowLookup {
    lowest: f32,
    cells_per_slope: f32,
    /// The first row that is not above the top of each cell.
    first: Vec<f32>,
    /// The last row that is not below the bottom of each cell.
    last: Vec<f32>,
}

impl RowLookup {
    /// The most cells: two tables of 16 KiB stay in the fastest cache.
    const MOST_CELLS: f32 = 4096.0;

    pub(super) fn new(slopes: &[f32]) -> RowLookup {
        let (high, low) = (slopes[0], slopes[slopes.len() - 1]);
        let closest = slopes.windows(2).map(|pair| pair[0] - pair[1]).fold(f32::INFINITY, f32::min);
        let span = (high - low).max(1e-3);
        // Some 32 cells between two rows, so that few slopes share a cell with a row.
        let count = (32.0 * span / closest.max(1e-6)).clamp(64.0, RowLookup::MOST_CELLS);
        let height = span / count;
        // Two cells beyond the rows at either end catch slopes that pass by.
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
            cells_per_slope: 1.0 / height,
            first: (0..cells).map(|cell| first(cell) as f32).collect(),
            last: (0..cells).map(|cell| if cell == 0 { slopes.len() as f32 - 1.0 } else { last(cell) }).collect(),
        }
    }

    /// The first and the last row with a slope between two; first > last if there is none.
    #[inline(always)]
    pub(super) fn rows_between<L: Lanes>(&self, low: L, high: L) -> (L, L) {
        let RowLookup { lowest, cells_per_slope, first, last } = self;
        let top = L::splat((first.len() - 1) as f32);
        let (zero, lowest, cells) = (L::splat(0.0), L::splat(*lowest), L::splat(*cells_per_slope));
        let high = ((high - lowest) * cells).max(zero).min(top);
        let low = ((low - lowest) * cells).max(zero).min(top);
        (high.gather(first), low.gather(last))
    }
}
