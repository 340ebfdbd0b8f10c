//! Triangles that may cover a few rays: here the lanes are triangles, and not the rays of one.

use super::bounds::{Bounds, Listed};
use super::draw::Canvas;
use super::lanes::{Lanes, Mask, WIDEST};
use super::solids::{SeenTriangle, Solid};
use super::vector::Vector;
use super::view::View;

/// Triangles that may cover more rays of a sweep are drawn one by one.
const FEW: f32 = 4.0;

/// Triangles, one to a lane.
pub(super) struct Specks<'a, L> {
    /// As a ray of the view's origin sees them.
    pub(super) seen: SeenTriangle<L>,
    pub(super) corners: [Vector<L>; 3],
    /// No coordinate that their corners were computed from is larger than this [m].
    pub(super) reach: f32,
    /// Their ids are these numbers times `step`, counted on from `first`.
    pub(super) numbers: &'a [u32],
    pub(super) first: u32,
    pub(super) step: u32,
}

impl<L: Lanes> Specks<'_, L> {
    /// Draws those of the listed triangles that may cover a few rays, each with one of its rays at a time, and says which.
    #[inline(always)]
    pub(super) fn draw(&self, bounds: &Bounds<L>, listed: &Listed, view: &View, canvas: &mut Canvas) -> u32 {
        let (one, turn) = (L::splat(1.0), L::splat(view.band.turn));
        let (start, end) = (L::splat(view.columns.start as f32), L::splat((view.columns.end - 1) as f32));
        // Into the turn that begins with this view; what reaches into the next one is drawn otherwise.
        let away = ((bounds.low - start) / turn).floor() * turn;
        let (from, to) = (-(away - bounds.low).floor(), (bounds.high - away).floor());
        let rays = (to - from + one) * (bounds.last - bounds.first + one);
        let few = L::splat(FEW * view.band.count as f32);
        let specks = (few.ge(rays) & (start + turn).gt(to + one)).bits() & listed.bits();
        let mut column = from;
        loop {
            let left = to.ge(column).bits() & specks;
            if left == 0 {
                return specks;
            }
            let here = left & (column.ge(start) & end.ge(column)).bits();
            if here != 0 {
                self.draw_column(column - start, bounds, here, view, canvas);
            }
            column = column + one;
        }
    }

    /// Draws the rays of one column of the view each, of those triangles that have a bit.
    #[inline(always)]
    fn draw_column(&self, column: L, bounds: &Bounds<L>, here: u32, view: &View, canvas: &mut Canvas) {
        let (band, zero, one) = (view.band, L::splat(0.0), L::splat(1.0));
        let (seen, up) = match &view.motion {
            None => (self.seen, Vector::new(zero, zero, one)),
            Some(motion) => {
                let (start, [a, b, c]) = (Vector::gather(&motion.start, column), self.corners);
                let reach = L::splat(self.reach + 2.0 * motion.shift);
                let seen = SeenTriangle::new([a - start, b - start, c - start], reach, view.rounding);
                (seen, Vector::gather(&motion.up, column))
            }
        };
        let nearest_of_all = bounds.near * L::splat(1.0001);
        let mut row = bounds.first;
        loop {
            let left = bounds.last.ge(row).bits() & here;
            if left == 0 {
                return;
            }
            let (heading, slope) = (view.heading_of(row, column), row.gather(&band.slopes));
            let direction = seen.products(
                up.x.mul_add(slope, heading.x),
                up.y.mul_add(slope, heading.y),
                up.z.mul_add(slope, heading.z),
            );
            let (nearest, margin) = seen.at_most(direction);
            let hits = left & margin.ge(zero).bits();
            if hits != 0 {
                let (nearness, settled) = seen.settled(direction, view.tolerance);
                let found = [nearest.min(nearest_of_all), nearness, column, row];
                self.offer(found, (hits, settled.bits()), view, canvas);
            }
            row = row + one;
        }
    }

    /// Draws one pixel of each triangle that has a bit: the most that the nearness may be, the nearness, column and row.
    #[inline(always)]
    fn offer(&self, found: [L; 4], (mut hits, settled): (u32, u32), view: &View, canvas: &mut Canvas) {
        let mut plain = [[0.0; WIDEST]; 4];
        for (plain, found) in plain.iter_mut().zip(found) {
            found.store(plain, 0);
        }
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let pixel = plain[3][lane] as usize * canvas.stride + plain[2][lane] as usize;
            let nearness = (settled >> lane & 1 == 1).then_some(plain[1][lane]);
            canvas.offer(pixel, plain[0][lane], nearness, self.first + self.step * self.numbers[lane], view);
        }
    }
}
