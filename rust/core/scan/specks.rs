//! Triangles that may cover a few rays: here the lanes are triangles, and not the rays of one.

use super::bounds::{Bounds, Listed};
use super::draw::Canvas;
use super::lanes::{Lanes, Mask, WIDEST};
use super::solids::{SeenTriangle, Solid};
use super::view::View;

/// Triangles that may cover more rays are drawn one by one.
const FEW: f32 = 4.0;

/// Draws those of the listed triangles that may cover a few rays, each with one of its rays at a time, and says which.
///
/// `numbers`, `first` and `step` make their ids.
#[inline(always)]
pub(super) fn draw_specks<L: Lanes>(
    seen: &SeenTriangle<L>,
    bounds: &Bounds<L>,
    listed: &Listed,
    (numbers, first, step): (&[u32], u32, u32),
    view: &View,
    canvas: &mut Canvas,
) -> u32 {
    let (one, turn) = (L::splat(1.0), L::splat(view.band.turn));
    let (start, end) = (L::splat(view.columns.start as f32), L::splat((view.columns.end - 1) as f32));
    // Into the turn that begins with this view; what reaches into the next one is drawn otherwise.
    let away = ((bounds.low - start) / turn).floor() * turn;
    let (from, to) = (-(away - bounds.low).floor(), (bounds.high - away).floor());
    let rays = (to - from + one) * (bounds.last - bounds.first + one);
    let specks = (L::splat(FEW).ge(rays) & (start + turn).gt(to + one)).bits() & listed.bits();
    if specks == 0 {
        return 0;
    }
    let (mut column, mut row) = (from, bounds.first);
    loop {
        let left = bounds.last.ge(row).bits() & specks;
        if left == 0 {
            return specks;
        }
        let here = left & (column.ge(start) & end.ge(column)).bits();
        if here != 0 {
            let [cos, sin] = &view.band.headings;
            let (x, y, slope) = (column.gather(cos), column.gather(sin), row.gather(&view.band.slopes));
            let direction = seen.products(x, y, slope);
            let (nearest, margin) = seen.at_most(direction);
            let nearest = nearest.min(bounds.near * L::splat(1.0001));
            let mut hits = here & margin.ge(L::splat(0.0)).bits();
            if hits != 0 {
                let (nearness, settled) = seen.settled(direction, view.tolerance);
                let mut plain = [[0.0; WIDEST]; 4];
                nearest.store(&mut plain[0], 0);
                nearness.store(&mut plain[1], 0);
                (column - start).store(&mut plain[2], 0);
                row.store(&mut plain[3], 0);
                let settled = settled.bits();
                while hits != 0 {
                    let lane = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    let pixel = plain[3][lane] as usize * canvas.stride + plain[2][lane] as usize;
                    let nearness = (settled >> lane & 1 == 1).then_some(plain[1][lane]);
                    canvas.offer(pixel, plain[0][lane], nearness, first + step * numbers[lane], view);
                }
            }
        }
        // The next ray of each: along the row, then down.
        let beyond = (column + one).gt(to);
        row = L::select(beyond, row + one, row);
        column = L::select(beyond, from, column + one);
    }
}
