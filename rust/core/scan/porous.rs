//! Media onto pixels: as `draw`, with a free path for every ray.

use super::bounds::Area;
use super::draw::{Canvas, DOUBT, steps};
use super::solids::{Porous, Shape};
use super::view::View;
use crate::medium::{COUNT, Paths};
use crate::packed::SWEEPS;
use crate::simd::{Lanes, Mask, Vector};

/// What makes a body a medium.
#[derive(Clone, Copy)]
pub(super) struct Medium {
    pub(super) seed: u64,
    pub(super) body: u32,
    /// The mean free path [m].
    pub(super) mean: f32,
}

/// How far a free path may be off after it is scaled, and a nearness that was worked out from it, as shares of them.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Draws a medium on the pixels of an area where a ray comes to rest in it nearer than what is there.
#[inline(always)]
pub(super) fn draw_medium<L: Lanes, S: Shape>(
    shape: &S,
    medium: Medium,
    id: u32,
    area: &Area,
    view: &View,
    canvas: &mut Canvas,
) where
    S::Seen<L>: Porous<L>,
{
    let still = shape.seen_from(Vector::splat([0.0; 3]));
    for (from, to) in view.stretches(area) {
        for at in steps::<L>(from, to) {
            let Some(motion) = &view.motion else {
                let up = Vector::splat([0.0, 0.0, 1.0]);
                draw_columns(&still, up, (medium, id), (at, area), view, canvas);
                continue;
            };
            let columns = motion.columns::<L>(at);
            let seen = shape.seen_from(columns.start);
            draw_columns(&seen, columns.up, (medium, id), (at, area), view, canvas);
        }
    }
}

/// Draws the rows of an area in the `L::N` columns from `at` on.
#[inline(always)]
fn draw_columns<L: Lanes>(
    seen: &impl Porous<L>,
    up: Vector<L>,
    (medium, id): (Medium, u32),
    (at, area): (usize, &Area),
    view: &View,
    canvas: &mut Canvas,
) {
    let (zero, one, bound) = (L::splat(0.0), L::splat(1.0), L::splat(area.near));
    let [a, b, c, _] = seen.rows();
    let mut sweeps = [[zero; 3]; SWEEPS];
    for (sweep, along) in sweeps.iter_mut().enumerate().take(view.band.count) {
        let heading = view.headings::<L>(sweep, at);
        *along = [a.dot(heading), b.dot(heading), c.dot(heading)];
    }
    let rise = [a.dot(up), b.dot(up), c.dot(up)];
    for row in area.first..=area.last {
        let (slope, along) = (L::splat(view.band.slopes[row]), &sweeps[usize::from(view.band.sweeps[row]) % SWEEPS]);
        let direction = [
            rise[0].mul_add(slope, along[0]),
            rise[1].mul_add(slope, along[1]),
            rise[2].mul_add(slope, along[2]),
            zero,
        ];
        let pixel = row * canvas.stride + at;
        let drawn = L::load(&canvas.near, pixel);
        let tie = view.tie(drawn);
        let behind = drawn.neg_mul_add(tie, drawn);
        let (enter, leave, margin) = seen.at_most_through(direction);
        let missed = zero.gt(margin) | behind.ge(enter) | leave.gt(enter);
        if missed.all() {
            continue;
        }
        let path = free_paths::<L>(&medium, view, row, at);
        // Distances in lengths of the direction add up; a nearness is 1 over them.
        let shortest = path * L::splat(1.0 - ROUNDING);
        let nearest = one / (one / enter.max(zero) + shortest) * L::splat(1.0 + ROUNDING);
        // What overflowed is in doubt.
        let known = nearest.ge(nearest) & margin.ge(margin) & leave.ge(leave);
        let (nearest, margin) = (L::select(known, nearest.min(bound), bound), L::select(known, margin, zero));
        let leave = L::select(known, leave, zero);
        let maybe = margin.ge(zero) & nearest.ge(leave) & nearest.gt(behind);
        if !maybe.any() {
            continue;
        }
        let (enter, leave, passes) = seen.at_least_through(direction);
        let longest = path * L::splat(1.0 + ROUNDING);
        let least = one / (one / enter.max(zero) + longest) * L::splat(1.0 - ROUNDING);
        let exact = view.tolerance.of(nearest).ge(nearest - least);
        let nearness = (nearest + least) * L::splat(0.5);
        let surely = maybe & passes & least.gt(leave) & exact & nearness.gt(drawn.mul_add(tie, drawn));
        let nearness = L::select(surely, nearness, nearest.max(drawn));
        L::select(maybe, nearness, drawn).store(&mut canvas.near, pixel);
        L::put(maybe, DOUBT, &mut canvas.id, pixel);
        L::put(surely, id, &mut canvas.id, pixel);
    }
}

/// How far rays travel in a medium, in lengths of their directions: those of a row of the view, from a column on.
#[inline(always)]
fn free_paths<L: Lanes>(medium: &Medium, view: &View, row: usize, at: usize) -> L {
    let paths = Paths::new(medium.seed, medium.body, view.band.rows[row]);
    let [a, b] = paths.ranks(view.columns.start + at);
    let (rank, count) = (L::load(a, 0) + L::load(b, 0), L::splat(COUNT as f32));
    let rank = L::select(rank.ge(count), rank - count, rank);
    rank.gather(paths.quantiles()) * L::splat(medium.mean / view.band.secants[row])
}
