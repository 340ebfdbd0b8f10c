//! Triangles that may cover only a few rays: here a lane is a triangle, not a ray.

use super::pixel_bounds::PixelBounds;
use super::pixel_rect::PixelRects;
use super::ray_tests::{RayTest, TriangleTest};
use super::view::{Motion, View};
use super::visibility_buffer::VisibilityBuffer;
use crate::simd::{Lanes, Mask, Vector, WIDEST};

/// Triangles that may cover more rays of a phase are not small.
const MOST_RAYS: f32 = 4.0;

/// Triangles, one to a lane.
pub(super) struct SmallTriangles<'a, L> {
    /// For rays from the view's origin.
    pub(super) test: TriangleTest<L>,
    pub(super) corners: [Vector<L>; 3],
    /// The largest coordinate from which their corners were computed [m].
    pub(super) reach: f32,
    /// Their ids are these numbers times `step`, plus `first`.
    pub(super) numbers: &'a [u32],
    pub(super) first: u32,
    pub(super) step: u32,
}

impl<L: Lanes> SmallTriangles<'_, L> {
    /// Rasterizes those of the triangles that are small, one ray of each at a time, and reports which.
    #[inline(always)]
    pub(super) fn rasterize(
        &self,
        bounds: &PixelBounds<L>,
        rects: &PixelRects,
        view: &View,
        buffer: &mut VisibilityBuffer,
    ) -> u32 {
        let (one, turn) = (L::splat(1.0), L::splat(view.band.columns_per_turn));
        let start = L::splat(view.columns.start as f32);
        // Into the turn that begins with this view; triangles that reach into the next one do not count as small.
        let away = ((bounds.low - start) / turn).floor() * turn;
        let (from, to) = (-(away - bounds.low).floor(), (bounds.high - away).floor());
        let rays = (to - from + one) * (bounds.last - bounds.first + one);
        let most = L::splat(MOST_RAYS * view.band.phase_count as f32);
        let small = (most.ge(rays) & (start + turn).gt(to + one)).bits() & rects.visible;
        match &view.motion {
            None => self.rasterize_still((from, to), bounds, small, view, buffer),
            Some(motion) => self.rasterize_moving(motion, (from, to), bounds, small, view, buffer),
        }
        small
    }

    /// Each triangle takes its own next ray, along the row and then down: none waits for another.
    #[inline(always)]
    fn rasterize_still(
        &self,
        (from, to): (L, L),
        bounds: &PixelBounds<L>,
        small: u32,
        view: &View,
        buffer: &mut VisibilityBuffer,
    ) {
        let one = L::splat(1.0);
        let (mut column, mut row) = (from, bounds.first);
        loop {
            let left = bounds.last.ge(row).bits() & small;
            if left == 0 {
                return;
            }
            let (here, at) = in_view(view, column, left);
            if here != 0 {
                let (Vector { x, y, .. }, slope) = (view.heading_at(row, at), row.gather(&view.band.slopes));
                let direction = self.test.products(x, y, slope);
                self.rasterize_rays(&self.test, direction, (row, at), (bounds.inverse_depth, here), view, buffer);
            }
            let beyond = (column + one).gt(to);
            row = L::select(beyond, row + one, row);
            column = L::select(beyond, from, column + one);
        }
    }

    /// All triangles go column by column: each column has its own tests.
    #[inline(always)]
    fn rasterize_moving(
        &self,
        motion: &Motion,
        (from, to): (L, L),
        bounds: &PixelBounds<L>,
        small: u32,
        view: &View,
        buffer: &mut VisibilityBuffer,
    ) {
        let reach = L::splat(self.reach + 2.0 * motion.shift);
        let mut column = from;
        loop {
            let left = to.ge(column).bits() & small;
            if left == 0 {
                return;
            }
            let (here, at) = in_view(view, column, left);
            column = column + L::splat(1.0);
            if here == 0 {
                continue;
            }
            let (start, [a, b, c]) = (Vector::gather(&motion.start, at), self.corners);
            let test = TriangleTest::new([a - start, b - start, c - start], reach, view.rounding);
            let up = Vector::gather(&motion.up, at);
            let mut row = bounds.first;
            loop {
                let here = bounds.last.ge(row).bits() & here;
                if here == 0 {
                    break;
                }
                let (heading, slope) = (view.heading_at(row, at), row.gather(&view.band.slopes));
                let direction = test.products(
                    up.x.mul_add(slope, heading.x),
                    up.y.mul_add(slope, heading.y),
                    up.z.mul_add(slope, heading.z),
                );
                self.rasterize_rays(&test, direction, (row, at), (bounds.inverse_depth, here), view, buffer);
                row = row + L::splat(1.0);
            }
        }
    }

    /// Rasterizes one ray of each triangle with a bit; no inverse depth is larger than `bound`.
    #[inline(always)]
    fn rasterize_rays(
        &self,
        test: &TriangleTest<L>,
        direction: [L; 4],
        (row, column): (L, L),
        (bound, here): (L, u32),
        view: &View,
        buffer: &mut VisibilityBuffer,
    ) {
        let (nearest, margin) = test.upper_bounds(direction);
        let hits = here & margin.ge(L::splat(0.0)).bits();
        if hits != 0 {
            let (inverse_depth, resolved) = test.resolved(direction, view.tolerance);
            let found = [nearest.min(bound * L::splat(1.0001)), inverse_depth, column, row];
            self.write_nearest(found, (hits, resolved.bits()), view, buffer);
        }
    }

    /// Writes one pixel of each triangle with a bit: the upper bound of the inverse depth, that depth, column and row.
    #[inline(always)]
    fn write_nearest(
        &self,
        found: [L; 4],
        (mut hits, resolved): (u32, u32),
        view: &View,
        buffer: &mut VisibilityBuffer,
    ) {
        let mut plain = [[0.0; WIDEST]; 4];
        for (plain, found) in plain.iter_mut().zip(found) {
            found.store(plain, 0);
        }
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let pixel = plain[3][lane] as usize * buffer.stride + plain[2][lane] as usize;
            let inverse_depth = (resolved >> lane & 1 == 1).then_some(plain[1][lane]);
            buffer.write_nearest(
                pixel,
                plain[0][lane],
                inverse_depth,
                self.first + self.step * self.numbers[lane],
                view,
            );
        }
    }
}

/// Those of some columns of the whole turn that are in the view, and all of them counted from its first.
#[inline(always)]
fn in_view<L: Lanes>(view: &View, column: L, some: u32) -> (u32, L) {
    let (start, end) = (L::splat(view.columns.start as f32), L::splat((view.columns.end - 1) as f32));
    (some & (column.ge(start) & end.ge(column)).bits(), column - start)
}
