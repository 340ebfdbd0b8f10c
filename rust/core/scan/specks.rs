//! Triangles that may cover a few rays: here the lanes are triangles, and not the rays of one.

use super::bounds::{Bounds, Listed};
use super::draw::Canvas;
use super::solids::{SeenTriangle, Solid};
use super::view::{Motion, View};
use crate::simd::{Lanes, Mask, Vector, WIDEST};

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
        let start = L::splat(view.columns.start as f32);
        // Into the turn that begins with this view; what reaches into the next one is drawn otherwise.
        let away = ((bounds.low - start) / turn).floor() * turn;
        let (from, to) = (-(away - bounds.low).floor(), (bounds.high - away).floor());
        let rays = (to - from + one) * (bounds.last - bounds.first + one);
        let few = L::splat(FEW * view.band.count as f32);
        let specks = (few.ge(rays) & (start + turn).gt(to + one)).bits() & listed.bits();
        match &view.motion {
            None => self.draw_still((from, to), bounds, specks, view, canvas),
            Some(motion) => self.draw_moving(motion, (from, to), bounds, specks, view, canvas),
        }
        specks
    }

    /// Each triangle takes its own next ray, along the row and then down: none waits for another.
    #[inline(always)]
    fn draw_still(&self, (from, to): (L, L), bounds: &Bounds<L>, specks: u32, view: &View, canvas: &mut Canvas) {
        let one = L::splat(1.0);
        let (mut column, mut row) = (from, bounds.first);
        loop {
            let left = bounds.last.ge(row).bits() & specks;
            if left == 0 {
                return;
            }
            let (here, at) = within(view, column, left);
            if here != 0 {
                let (Vector { x, y, .. }, slope) = (view.heading_of(row, at), row.gather(&view.band.slopes));
                let direction = self.seen.products(x, y, slope);
                self.draw_rays(&self.seen, direction, (row, at), (bounds.near, here), view, canvas);
            }
            let beyond = (column + one).gt(to);
            row = L::select(beyond, row + one, row);
            column = L::select(beyond, from, column + one);
        }
    }

    /// All triangles are drawn column by column: from each of them they look otherwise.
    #[inline(always)]
    fn draw_moving(
        &self,
        motion: &Motion,
        (from, to): (L, L),
        bounds: &Bounds<L>,
        specks: u32,
        view: &View,
        canvas: &mut Canvas,
    ) {
        let reach = L::splat(self.reach + 2.0 * motion.shift);
        let mut column = from;
        loop {
            let left = to.ge(column).bits() & specks;
            if left == 0 {
                return;
            }
            let (here, at) = within(view, column, left);
            column = column + L::splat(1.0);
            if here == 0 {
                continue;
            }
            let (start, [a, b, c]) = (Vector::gather(&motion.start, at), self.corners);
            let seen = SeenTriangle::new([a - start, b - start, c - start], reach, view.rounding);
            let up = Vector::gather(&motion.up, at);
            let mut row = bounds.first;
            loop {
                let here = bounds.last.ge(row).bits() & here;
                if here == 0 {
                    break;
                }
                let (heading, slope) = (view.heading_of(row, at), row.gather(&view.band.slopes));
                let direction = seen.products(
                    up.x.mul_add(slope, heading.x),
                    up.y.mul_add(slope, heading.y),
                    up.z.mul_add(slope, heading.z),
                );
                self.draw_rays(&seen, direction, (row, at), (bounds.near, here), view, canvas);
                row = row + L::splat(1.0);
            }
        }
    }

    /// Draws one ray of each triangle that has a bit; none is nearer than `near`.
    #[inline(always)]
    fn draw_rays(
        &self,
        seen: &SeenTriangle<L>,
        direction: [L; 4],
        (row, column): (L, L),
        (near, here): (L, u32),
        view: &View,
        canvas: &mut Canvas,
    ) {
        let (nearest, margin) = seen.at_most(direction);
        let hits = here & margin.ge(L::splat(0.0)).bits();
        if hits != 0 {
            let (nearness, settled) = seen.settled(direction, view.tolerance);
            let found = [nearest.min(near * L::splat(1.0001)), nearness, column, row];
            self.offer(found, (hits, settled.bits()), view, canvas);
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

/// Those of some columns of the whole turn that are in the view, and all of them counted from its first.
#[inline(always)]
fn within<L: Lanes>(view: &View, column: L, some: u32) -> (u32, L) {
    let (start, end) = (L::splat(view.columns.start as f32), L::splat((view.columns.end - 1) as f32));
    (some & (column.ge(start) & end.ge(column)).bits(), column - start)
}
