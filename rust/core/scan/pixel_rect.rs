//! The pixels that a body may cover, as plain numbers.

use super::pixel_bounds::PixelBounds;
use super::view::View;
use crate::simd::{Lanes, Mask, WIDEST};

/// Rows and columns of a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRect {
    /// No ray meets the body at a larger inverse depth [1/m].
    pub(super) inverse_depth: f32,
    /// The middle column, counted over the whole turn and possibly beyond its seam.
    pub(super) middle: f32,
    /// From this column of the view to that one, and from its first to the third if the rectangle crosses the seam;
    /// spans that end before they begin miss all columns.
    columns: [i32; 3],
    /// From this row of the band to that one.
    pub(super) first: usize,
    pub(super) last: usize,
}

impl PixelRect {
    /// The first and last column of each part in the view; parts that miss it are left out.
    #[inline(always)]
    pub(super) fn spans(&self) -> impl Iterator<Item = (usize, usize)> {
        let [from, to, beyond] = self.columns;
        [(from, to), (0, beyond)]
            .into_iter()
            .filter_map(|(from, to)| (from <= to).then_some((from as usize, to as usize)))
    }
}

/// The rectangles of several bodies, one to a lane.
pub(super) struct PixelRects {
    inverse_depth: [f32; WIDEST],
    middle: [f32; WIDEST],
    columns: [[i32; WIDEST]; 3],
    rows: [[i32; WIDEST]; 2],
    /// Those that may be visible, one bit each.
    pub(super) visible: u32,
}

impl<L: Lanes> PixelBounds<L> {
    /// The first `count` of them as plain numbers.
    #[inline(always)]
    pub(super) fn rects(&self, count: usize, view: &View) -> PixelRects {
        let mut rects = PixelRects {
            inverse_depth: [0.0; WIDEST],
            middle: [0.0; WIDEST],
            columns: [[0; WIDEST]; 3],
            rows: [[0; WIDEST]; 2],
            visible: self.visible.bits(),
        };
        if count < WIDEST {
            rects.visible &= (1 << count) - 1;
        }
        (self.inverse_depth * L::splat(1.0001)).store(&mut rects.inverse_depth, 0);
        ((self.low + self.high) * L::splat(0.5)).store(&mut rects.middle, 0);
        let [from, to, beyond] = self.columns(view);
        from.whole().store(&mut rects.columns[0], 0);
        to.whole().store(&mut rects.columns[1], 0);
        beyond.whole().store(&mut rects.columns[2], 0);
        self.first.whole().store(&mut rects.rows[0], 0);
        self.last.whole().store(&mut rects.rows[1], 0);
        rects
    }

    /// The columns of [`PixelRect`].
    #[inline(always)]
    fn columns(&self, view: &View) -> [L; 3] {
        let (turn, zero, one) = (L::splat(view.band.columns_per_turn), L::splat(0.0), L::splat(1.0));
        let (start, end) = (L::splat(view.columns.start as f32), L::splat((view.columns.end - 1) as f32));
        // The turn in which the rectangle begins in this view or behind it, and the one before.
        let away = ((self.low - start) / turn).floor();
        let (here, before) = (away * turn, (away + one) * turn);
        let from = (-(here - self.low).floor()).max(start) - start;
        let to = (self.high - here).floor().min(end) - start;
        let beyond = (self.high - before).floor().min(end) - start;
        let whole = (self.high - self.low).ge(turn);
        [L::select(whole, zero, from), L::select(whole, end - start, to), L::select(whole, -one, beyond)]
    }
}

impl PixelRects {
    /// Removes some, one bit each.
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
                let rect = PixelRect {
                    inverse_depth: self.inverse_depth[lane],
                    middle: self.middle[lane],
                    columns: [self.columns[0][lane], self.columns[1][lane], self.columns[2][lane]],
                    first: self.rows[0][lane] as usize,
                    last: self.rows[1][lane] as usize,
                };
                (lane, rect)
            })
        })
    }
}
