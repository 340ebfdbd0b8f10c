//! Media onto pixels: as `rasterize_shape`, with a free path for every ray.

use super::pixel_rect::PixelRect;
use super::ray_tests::{MediumTest, ShapeInView};
use super::view::View;
use super::visibility_buffer::{UNRESOLVED, VisibilityBuffer, lanes_within, steps};
use crate::medium::FreePaths;
use crate::packed::PHASES;
use crate::simd::{Lanes, Mask, Vector};

/// The properties of a medium.
#[derive(Clone, Copy)]
pub(super) struct Medium {
    pub(super) paths: FreePaths,
    /// The mean free path [m].
    pub(super) mean: f32,
}

/// The largest error of a free path after scaling, and of an inverse depth computed from it, as shares of them.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Rasterizes a medium: writes it to the pixels of a rectangle in which the first interaction of the ray with it is
/// nearest.
#[inline(always)]
pub(super) fn rasterize_medium<L: Lanes, S: ShapeInView>(
    shape: &S,
    medium: Medium,
    id: u32,
    rect: &PixelRect,
    view: &View,
    buffer: &mut VisibilityBuffer,
) where
    S::Test<L>: MediumTest<L>,
{
    let still = shape.test_from(Vector::splat([0.0; 3]));
    for (from, to) in rect.spans() {
        for at in steps::<L>(from, to) {
            let Some(motion) = &view.motion else {
                let up = Vector::splat([0.0, 0.0, 1.0]);
                rasterize_columns(&still, up, (medium, id), (at, to, rect), view, buffer);
                continue;
            };
            let columns = motion.columns::<L>(at);
            let test = shape.test_from(columns.start);
            rasterize_columns(&test, columns.up, (medium, id), (at, to, rect), view, buffer);
        }
    }
}

/// Rasterizes the rows of a rectangle in the `L::N` columns from `at` on, or those of them up to `to`.
#[inline(always)]
fn rasterize_columns<L: Lanes>(
    test: &impl MediumTest<L>,
    up: Vector<L>,
    (medium, id): (Medium, u32),
    (at, to, rect): (usize, usize, &PixelRect),
    view: &View,
    buffer: &mut VisibilityBuffer,
) {
    let (zero, one, bound) = (L::splat(0.0), L::splat(1.0), L::splat(rect.inverse_depth));
    let [a, b, c, _] = test.rows();
    let mut products = [[zero; 3]; PHASES];
    for (phase, along) in products.iter_mut().enumerate().take(view.band.phase_count) {
        let heading = view.headings::<L>(phase, at);
        *along = [a.dot(heading), b.dot(heading), c.dot(heading)];
    }
    let rise = [a.dot(up), b.dot(up), c.dot(up)];
    for row in rect.first..=rect.last {
        let (slope, along) = (L::splat(view.band.slopes[row]), &products[usize::from(view.band.phases[row]) % PHASES]);
        let direction = [
            rise[0].mul_add(slope, along[0]),
            rise[1].mul_add(slope, along[1]),
            rise[2].mul_add(slope, along[2]),
            zero,
        ];
        let pixel = row * buffer.stride + at;
        let stored = L::load(&buffer.inverse_depth, pixel);
        let tie = view.tie(stored);
        let behind = stored.neg_mul_add(tie, stored);
        let (enter, leave, margin) = test.widest_interval(direction);
        let missed = zero.gt(margin) | behind.ge(enter) | leave.gt(enter);
        if missed.all() {
            continue;
        }
        let path = free_paths::<L>(&medium, view, row, at);
        // Distances in lengths of the direction add up; an inverse depth is 1 over them.
        let shortest = path * L::splat(1.0 - ROUNDING);
        let nearest = one / (one / enter.max(zero) + shortest) * L::splat(1.0 + ROUNDING);
        // An overflow is unresolved.
        let known = nearest.ge(nearest) & margin.ge(margin) & leave.ge(leave);
        let (nearest, margin) = (L::select(known, nearest.min(bound), bound), L::select(known, margin, zero));
        let leave = L::select(known, leave, zero);
        let maybe = margin.ge(zero) & nearest.ge(leave) & nearest.gt(behind) & lanes_within::<L>(at, to);
        if !maybe.any() {
            continue;
        }
        let (enter, leave, passes) = test.narrowest_interval(direction);
        let longest = path * L::splat(1.0 + ROUNDING);
        let least = one / (one / enter.max(zero) + longest) * L::splat(1.0 - ROUNDING);
        let exact = view.tolerance.allowed_error(nearest).ge(nearest - least);
        let inverse_depth = (nearest + least) * L::splat(0.5);
        let surely = maybe & passes & least.gt(leave) & exact & inverse_depth.gt(stored.mul_add(tie, stored));
        let inverse_depth = L::select(surely, inverse_depth, nearest.max(stored));
        L::select(maybe, inverse_depth, stored).store(&mut buffer.inverse_depth, pixel);
        L::masked_store(maybe, UNRESOLVED, &mut buffer.id, pixel);
        L::masked_store(surely, id, &mut buffer.id, pixel);
    }
}

/// The free paths of rays in a medium, in lengths of their directions: those of a row of the view, from a column on.
#[inline(always)]
fn free_paths<L: Lanes>(medium: &Medium, view: &View, row: usize, at: usize) -> L {
    let paths = &medium.paths;
    let [a, b, leaves] = paths.ranks(view.band.row_keys[row], view.columns.start + at);
    let rank = L::load(a, 0) + L::load(b, 0) + L::load(leaves, 0) + L::splat(paths.start());
    rank.gather(paths.quantiles()) * L::splat(medium.mean / view.band.secants[row])
}
