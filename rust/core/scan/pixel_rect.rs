//! The pixels that a body may cover, as plain numbers.

use super::view::View;
use crate::simd::WIDEST;

/// Rows and columns of a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRect {
    /// No ray meets the body at a larger inverse depth [1/m].
    pub(super) inverse_depth: f32,
    /// From this column to that one, counted over the whole turn and possibly beyond its seam.
    pub(super) low: f32,
    pub(super) high: f32,
    /// From this row of the band to that one.
    pub(super) first: usize,
    pub(super) last: usize,
}

impl View<'_> {
    /// The first and last column of each part of a rectangle in this view: two if it lies across the seam, and spans that
    /// end before they begin if it misses all columns.
    #[inline(always)]
    pub(super) fn column_spans(&self, rect: &PixelRect) -> [(usize, usize); 2] {
        const NONE: (usize, usize) = (1, 0);
        let turn = self.band.columns_per_turn;
        if rect.high - rect.low >= turn {
            return [(0, self.width() - 1), NONE];
        }
        let (start, end) = (self.columns.start as f32, (self.columns.end - 1) as f32);
        // The turn in which the rectangle begins in this view or behind it, and the one before.
        let away = ((rect.low - start) / turn).floor();
        let mut spans = [NONE; 2];
        for (span, shift) in spans.iter_mut().zip([-away * turn, (-1.0 - away) * turn]) {
            let (from, to) = ((rect.low + shift).ceil().max(start), (rect.high + shift).floor().min(end));
            if from <= to {
                *span = ((from - start) as usize, (to - start) as usize);
            }
        }
        spans
    }
}

/// The rectangles of several bodies, one to a lane.
pub(super) struct PixelRects {
    pub(super) inverse_depth: [f32; WIDEST],
    pub(super) low: [f32; WIDEST],
    pub(super) high: [f32; WIDEST],
    pub(super) first: [f32; WIDEST],
    pub(super) last: [f32; WIDEST],
    /// Those that may be visible, one bit each.
    pub(super) visible: u32,
}

impl PixelRects {
    /// Leaves some out, one bit each.
    #[inline(always)]
    pub(super) fn remove(&mut self, bodies: u32) {
        self.visible &= !bodies;
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.visible == 0
    }

    /// The lane and the rectangle of each body that may be visible.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, PixelRect)> {
        let mut left = self.visible;
        std::iter::from_fn(move || {
            let lane = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (lane < WIDEST).then(|| {
                let (first, last) = (self.first[lane] as usize, self.last[lane] as usize);
                let (inverse_depth, low, high) = (self.inverse_depth[lane] * 1.0001, self.low[lane], self.high[lane]);
                (lane, PixelRect { inverse_depth, low, high, first, last })
            })
        })
    }
}
