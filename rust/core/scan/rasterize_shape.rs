//! Shapes onto pixels: the loop that all other code keeps short.

use super::pixel_rect::PixelRect;
use super::ray_tests::{RayTest, ShapeInView};
use super::view::View;
use super::visibility_buffer::{UNRESOLVED, VisibilityBuffer, lanes_within, steps};
use crate::packed::PHASES;
use crate::simd::{Lanes, Mask, Vector};

/// For rectangles of more rows than this, the rows that a triangle crosses are found first.
const TALL: usize = 6;

/// Rasterizes a shape: writes it to the pixels of a rectangle in which it is nearest.
#[inline(always)]
pub(super) fn rasterize_shape<L: Lanes>(
    shape: &impl ShapeInView,
    id: u32,
    rect: &PixelRect,
    view: &View,
    buffer: &mut VisibilityBuffer,
) {
    let Some(motion) = &view.motion else {
        let test = shape.test_from(Vector::splat([0.0; 3]));
        return rasterize_still::<L>(&test, id, rect, view, buffer);
    };
    for (from, to) in rect.spans() {
        for at in steps::<L>(from, to) {
            let columns = motion.columns::<L>(at);
            let test = shape.test_from(columns.start);
            let [a, b, c, d] = test.rows();
            let up = columns.up;
            let rise = [a.dot(up), b.dot(up), c.dot(up), d.dot(up)];
            let mut along = [[L::splat(0.0); 4]; PHASES];
            for (phase, along) in along.iter_mut().enumerate().take(view.band.phase_count) {
                let h = view.headings::<L>(phase, at);
                *along = [a.dot(h), b.dot(h), c.dot(h), d.dot(h)];
            }
            rasterize_columns(&test, (&along, &rise), id, (at, to, rect), view, buffer);
        }
    }
}

/// Rasterizes a shape in a static view.
#[inline(always)]
pub(super) fn rasterize_still<L: Lanes>(
    test: &impl RayTest<L>,
    id: u32,
    rect: &PixelRect,
    view: &View,
    buffer: &mut VisibilityBuffer,
) {
    // Most patterns have one phase, whose products then stay in registers.
    if view.band.phase_count == 1 {
        rasterize_phases::<L, 1>(test, id, rect, view, buffer);
    } else {
        rasterize_phases::<L, PHASES>(test, id, rect, view, buffer);
    }
}

/// The same for no more than `P` phases.
#[inline(always)]
fn rasterize_phases<L: Lanes, const P: usize>(
    test: &impl RayTest<L>,
    id: u32,
    rect: &PixelRect,
    view: &View,
    buffer: &mut VisibilityBuffer,
) {
    let [a, b, c, d] = test.rows();
    let rise = [a.z, b.z, c.z, d.z];
    for (from, to) in rect.spans() {
        for at in steps::<L>(from, to) {
            let mut along = [[L::splat(0.0); 4]; P];
            for (phase, along) in along.iter_mut().enumerate().take(view.band.phase_count) {
                let Vector { x, y, .. } = view.headings::<L>(phase, at);
                *along = [
                    a.x.mul_add(x, a.y * y),
                    b.x.mul_add(x, b.y * y),
                    c.x.mul_add(x, c.y * y),
                    d.x.mul_add(x, d.y * y),
                ];
            }
            rasterize_columns(test, (&along, &rise), id, (at, to, rect), view, buffer);
        }
    }
}

/// The largest products of any phase.
#[inline(always)]
fn largest<L: Lanes>(along: &[[L; 4]]) -> [L; 4] {
    let mut all = along[0];
    for [a, b, c, d] in &along[1..] {
        all = [all[0].max(*a), all[1].max(*b), all[2].max(*c), all[3].max(*d)];
    }
    all
}

/// Rasterizes the rows of a rectangle in the `L::N` columns from `at` on, or those of them up to `to`.
#[inline(always)]
fn rasterize_columns<L: Lanes, const P: usize>(
    test: &impl RayTest<L>,
    (along, rise): (&[[L; 4]; P], &[L; 4]),
    id: u32,
    (at, to, rect): (usize, usize, &PixelRect),
    view: &View,
    buffer: &mut VisibilityBuffer,
) {
    let (zero, bound, tolerance) = (L::splat(0.0), L::splat(rect.inverse_depth), view.tolerance);
    let (mut first, mut last) = (rect.first, rect.last);
    if last - first >= TALL
        && let Some((low, high)) = test.slopes(&largest(&along[..view.band.phase_count.min(P)]), rise)
    {
        // A triangle fills half its rectangle or less.
        let (from, to) = view.band.rows_between(low, high);
        let some = to.ge(from);
        if !some.any() {
            return;
        }
        let rows = L::splat(last as f32);
        first = first.max(L::select(some, from, rows).reduce_min() as usize);
        last = last.min((-L::select(some, -to, zero).reduce_min()) as usize);
        if last < first {
            return;
        }
    }
    let slopes = &view.band.slopes[first..=last];
    let begin = first * buffer.stride + at;
    let depths = buffer.inverse_depth[begin..].chunks_exact_mut(buffer.stride);
    let ids = buffer.id[begin..].chunks_exact_mut(buffer.stride);
    let phases = &view.band.phases[first..=last];
    for (((&slope, &phase), depths), ids) in slopes.iter().zip(phases).zip(depths).zip(ids) {
        let (slope, along) = (L::splat(slope), &along[usize::from(phase) % P]);
        let direction = [
            rise[0].mul_add(slope, along[0]),
            rise[1].mul_add(slope, along[1]),
            rise[2].mul_add(slope, along[2]),
            rise[3].mul_add(slope, along[3]),
        ];
        let (inverse_depth, resolved) = test.resolved(direction, tolerance);
        let (nearest, margin) = test.upper_bounds(direction);
        // An overflow is unresolved.
        let known = nearest.ordered(margin);
        // And nothing is nearer than its bounds: shapes rasterized here change no pixel in which they are occluded.
        let (nearest, margin) = (L::select(known, nearest.min(bound), bound), L::select(known, margin, zero));
        let stored = L::load(depths, 0);
        let tie = view.tie(stored);
        let maybe = margin.ge(zero) & nearest.gt(stored.neg_mul_add(tie, stored));
        let surely = maybe & resolved & inverse_depth.gt(stored.mul_add(tie, stored));
        let mut nearer = L::select(surely, inverse_depth, stored);
        // The only branch: whether a vector meets a shape at all is hard to predict.
        if surely.bits() != maybe.bits() {
            // An error without a bound reaches beyond the rectangle.
            let unresolved = maybe & lanes_within::<L>(at, to);
            nearer = L::select(unresolved, L::select(surely, inverse_depth, nearest.max(stored)), nearer);
            L::masked_store(unresolved, UNRESOLVED, ids, 0);
        }
        nearer.store(depths, 0);
        L::masked_store(surely, id, ids, 0);
    }
}

/// Leaves all pixels of a rectangle unresolved, unless they are occluded: for shapes that no test in f32 can decide.
#[inline(always)]
pub(super) fn rasterize_unresolved<L: Lanes>(rect: &PixelRect, view: &View, buffer: &mut VisibilityBuffer) {
    let nearest = L::splat(rect.inverse_depth);
    for (from, to) in rect.spans() {
        for row in rect.first..=rect.last {
            for at in steps::<L>(from, to) {
                let pixel = row * buffer.stride + at;
                let stored = L::load(&buffer.inverse_depth, pixel);
                let maybe = lanes_within::<L>(at, to) & nearest.gt(stored.neg_mul_add(view.tie(stored), stored));
                L::select(maybe, nearest.max(stored), stored).store(&mut buffer.inverse_depth, pixel);
                L::masked_store(maybe, UNRESOLVED, &mut buffer.id, pixel);
            }
        }
    }
}
