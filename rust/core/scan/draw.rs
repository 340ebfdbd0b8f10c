//! Shapes onto pixels: the loop that everything else is there to keep short.

use super::bounds::Area;
use super::solids::{Shape, Solid, Tolerance};
use super::view::View;
use crate::packed::SWEEPS;
use crate::simd::{Lanes, Mask, Vector, WIDEST};

/// What is nearest so far at each pixel of a view, by rows.
///
/// In whatever order shapes are drawn, a pixel ends with the nearest one, or in doubt if rounding could have hidden another
/// winner.
#[derive(Default)]
pub(super) struct Canvas {
    /// 1 / horizontal distance; 0 where nothing is.
    pub(super) near: Vec<f32>,
    pub(super) id: Vec<u32>,
    pub(super) stride: usize,
}

/// The id of a pixel that f32 cannot decide.
pub(super) const DOUBT: u32 = u32::MAX;

/// Areas of more rows than this are worth a look at which of them a triangle crosses.
const TALL: usize = 6;

impl Canvas {
    /// Makes room for a view. What is left of the view before is 0 already: [`resolve`](super::resolve) clears what it reads.
    pub(super) fn fit(&mut self, view: &View) {
        // Rows a power of two apart would fall on one place of the cache; an odd number of its lines apart they do not.
        let lines = (view.width() + 2 * WIDEST).div_ceil(WIDEST) | 1;
        self.stride = lines * WIDEST;
        // One row more, so that a whole stride follows every pixel.
        let pixels = self.stride * (view.band.rows.len() + 1);
        if self.near.len() < pixels {
            self.near.resize(pixels, 0.0);
            self.id.resize(pixels, DOUBT);
        }
    }

    /// Whether on every pixel of an area something is drawn that surely hides what is bounded by it.
    #[inline(always)]
    pub(super) fn hides<L: Lanes>(&self, view: &View, area: &Area) -> bool {
        let nearest = L::splat(area.near);
        for (from, to) in view.stretches(area) {
            let rows = self.near[area.first * self.stride..].chunks_exact(self.stride);
            for row in rows.take(area.last + 1 - area.first) {
                for at in steps::<L>(from, to) {
                    let drawn = L::load(row, at);
                    if nearest.gt(drawn.neg_mul_add(view.tie(drawn), drawn)).any() {
                        return false;
                    }
                }
            }
        }
        true
    }
}

impl Canvas {
    /// Draws one pixel, as [`draw_columns`] does many: `nearest` is the most that the nearness may be.
    #[inline(always)]
    pub(super) fn offer(&mut self, pixel: usize, nearest: f32, settled: Option<f32>, id: u32, view: &View) {
        let drawn = self.near[pixel];
        let tie = 2.0 * drawn * (drawn * view.tolerance.absolute + Tolerance::RELATIVE);
        if nearest > drawn - tie {
            match settled.filter(|&nearness| nearness > drawn + tie) {
                Some(nearness) => (self.near[pixel], self.id[pixel]) = (nearness, id),
                None => (self.near[pixel], self.id[pixel]) = (nearest.max(drawn), DOUBT),
            }
        }
    }
}

impl View<'_> {
    /// The share that the nearness of another surface must differ by so that settled ranges tell which is nearer.
    #[inline(always)]
    pub(super) fn tie<L: Lanes>(&self, nearness: L) -> L {
        nearness.mul_add(L::splat(2.0 * self.tolerance.absolute), L::splat(2.0 * Tolerance::RELATIVE))
    }
}

/// The first columns of the vectors that cover a stretch.
#[inline(always)]
pub(super) fn steps<L: Lanes>(from: usize, to: usize) -> impl Iterator<Item = usize> {
    let count = (to + L::N - from.min(to + L::N)) / L::N;
    (0..count).map(move |step| from + step * L::N)
}

/// Draws a shape on the pixels of an area where it is nearest.
#[inline(always)]
pub(super) fn draw<L: Lanes>(shape: &impl Shape, id: u32, area: &Area, view: &View, canvas: &mut Canvas) {
    let Some(motion) = &view.motion else {
        let seen = shape.seen_from(Vector::splat([0.0; 3]));
        return draw_seen::<L, SWEEPS>(&seen, id, area, view, canvas);
    };
    for (from, to) in view.stretches(area) {
        for at in steps::<L>(from, to) {
            let columns = motion.columns::<L>(at);
            let seen = shape.seen_from(columns.start);
            let [a, b, c, d] = seen.rows();
            let up = columns.up;
            let rise = [a.dot(up), b.dot(up), c.dot(up), d.dot(up)];
            let mut along = [[L::splat(0.0); 4]; SWEEPS];
            for (sweep, along) in along.iter_mut().enumerate().take(view.band.count) {
                let h = view.headings::<L>(sweep, at);
                *along = [a.dot(h), b.dot(h), c.dot(h), d.dot(h)];
            }
            draw_columns(&seen, (&along, &rise), id, (at, area), view, canvas);
        }
    }
}

/// Draws a shape as a view sees it that stands still and has no more than `S` sweeps.
#[inline(always)]
pub(super) fn draw_seen<L: Lanes, const S: usize>(
    seen: &impl Solid<L>,
    id: u32,
    area: &Area,
    view: &View,
    canvas: &mut Canvas,
) {
    let [a, b, c, d] = seen.rows();
    let rise = [a.z, b.z, c.z, d.z];
    for (from, to) in view.stretches(area) {
        for at in steps::<L>(from, to) {
            let mut along = [[L::splat(0.0); 4]; S];
            for (sweep, along) in along.iter_mut().enumerate().take(view.band.count) {
                let Vector { x, y, .. } = view.headings::<L>(sweep, at);
                *along = [
                    a.x.mul_add(x, a.y * y),
                    b.x.mul_add(x, b.y * y),
                    c.x.mul_add(x, c.y * y),
                    d.x.mul_add(x, d.y * y),
                ];
            }
            draw_columns(seen, (&along, &rise), id, (at, area), view, canvas);
        }
    }
}

/// The largest products of any sweep.
#[inline(always)]
fn most<L: Lanes>(along: &[[L; 4]]) -> [L; 4] {
    let mut all = along[0];
    for [a, b, c, d] in &along[1..] {
        all = [all[0].max(*a), all[1].max(*b), all[2].max(*c), all[3].max(*d)];
    }
    all
}

/// Draws the rows of an area in the `L::N` columns from `at` on.
#[inline(always)]
fn draw_columns<L: Lanes, const S: usize>(
    seen: &impl Solid<L>,
    (along, rise): (&[[L; 4]; S], &[L; 4]),
    id: u32,
    (at, area): (usize, &Area),
    view: &View,
    canvas: &mut Canvas,
) {
    let (zero, bound, tolerance) = (L::splat(0.0), L::splat(area.near), view.tolerance);
    let (mut first, mut last) = (area.first, area.last);
    if last - first >= TALL
        && let Some((low, high)) = seen.slopes(&most(&along[..view.band.count.min(S)]), rise)
    {
        // A triangle fills half its area or less.
        let (from, to) = view.band.rows_between(low, high);
        let some = to.ge(from);
        if !some.any() {
            return;
        }
        let rows = L::splat(last as f32);
        first = first.max(L::select(some, from, rows).lowest() as usize);
        last = last.min((-L::select(some, -to, zero).lowest()) as usize);
        if last < first {
            return;
        }
    }
    let slopes = &view.band.slopes[first..=last];
    let begin = first * canvas.stride + at;
    let near = canvas.near[begin..].chunks_exact_mut(canvas.stride);
    let ids = canvas.id[begin..].chunks_exact_mut(canvas.stride);
    let sweeps = &view.band.sweeps[first..=last];
    for (((&slope, &sweep), near), ids) in slopes.iter().zip(sweeps).zip(near).zip(ids) {
        let (slope, along) = (L::splat(slope), &along[usize::from(sweep) % S]);
        let direction = [
            rise[0].mul_add(slope, along[0]),
            rise[1].mul_add(slope, along[1]),
            rise[2].mul_add(slope, along[2]),
            rise[3].mul_add(slope, along[3]),
        ];
        let (nearest, margin) = seen.at_most(direction);
        // What overflowed is in doubt.
        let known = nearest.ge(nearest) & margin.ge(margin);
        // And nothing is nearer than its bounds: what is drawn here changes no pixel that it is hidden at.
        let (nearest, margin) = (L::select(known, nearest.min(bound), bound), L::select(known, margin, zero));
        let drawn = L::load(near, 0);
        let tie = view.tie(drawn);
        let maybe = margin.ge(zero) & nearest.gt(drawn.neg_mul_add(tie, drawn));
        if maybe.any() {
            let (nearness, settled) = seen.settled(direction, tolerance);
            let surely = maybe & settled & nearness.gt(drawn.mul_add(tie, drawn));
            let nearness = L::select(surely, nearness, nearest.max(drawn));
            L::select(maybe, nearness, drawn).store(near, 0);
            L::put(maybe, DOUBT, ids, 0);
            L::put(surely, id, ids, 0);
        }
    }
}

/// Leaves all pixels of an area in doubt, unless something hides them: for what no shape test here can decide.
#[inline(always)]
pub(super) fn draw_doubt<L: Lanes>(area: &Area, view: &View, canvas: &mut Canvas) {
    let near = L::splat(area.near);
    for (from, to) in view.stretches(area) {
        for row in area.first..=area.last {
            for at in steps::<L>(from, to) {
                let pixel = row * canvas.stride + at;
                let drawn = L::load(&canvas.near, pixel);
                let maybe = near.gt(drawn.neg_mul_add(view.tie(drawn), drawn));
                L::select(maybe, near.max(drawn), drawn).store(&mut canvas.near, pixel);
                L::put(maybe, DOUBT, &mut canvas.id, pixel);
            }
        }
    }
}
