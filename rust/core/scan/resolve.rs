//! A painted view as images.

use super::draw::{Canvas, DOUBT};
use super::lanes::{Lanes, Mask, WIDEST};
use super::view::View;
use crate::ImagesMut;

/// The pixels that f32 could not decide: row and column of the view.
pub(super) type Doubts = Vec<(usize, usize)>;

impl Canvas {
    /// Writes the images of a view, row by row, and leaves the canvas empty.
    ///
    /// `body_of` says which body an id belongs to, `semantics` the class and instance of each body. Pixels in doubt are listed
    /// and left without return.
    #[inline(always)]
    pub(super) fn resolve<L: Lanes>(
        &mut self,
        view: &View,
        body_of: impl Fn(u32) -> usize + Copy,
        semantics: &[(u8, u32)],
        images: &mut [ImagesMut<'_>],
        doubts: &mut Doubts,
    ) {
        for (row, image) in images.iter_mut().enumerate() {
            let secant = L::splat(view.band.secants[row]);
            for at in (0..view.width()).step_by(L::N) {
                let pixel = row * self.stride + at;
                let depth = secant / L::load(&self.near, pixel);
                L::splat(0.0).store(&mut self.near, pixel);
                let seen = InRange::new(depth, view);
                let count = L::N.min(view.width() - at);
                write_depth(depth, &seen, &mut image.depth[at..at + count]);
                if seen.reachable == 0 {
                    image.clear(at, at + count);
                } else if seen.surely::<L>()
                    && count == L::N
                    && L::all_equal(&self.id, pixel)
                    && self.id[pixel] != DOUBT
                {
                    // Most vectors lie within one body.
                    let body = body_of(self.id[pixel]);
                    image.fill(at, at + count, body, semantics[body]);
                } else {
                    let ids = &self.id[pixel..pixel + count];
                    scatter(&seen, ids, (row, at), body_of, semantics, image, doubts);
                }
            }
            // The last vector that was drawn may have reached beyond the view.
            L::splat(0.0).store(&mut self.near, row * self.stride + view.width());
        }
    }
}

/// Which of some distances are within the range limits, one bit each.
struct InRange {
    reported: u32,
    /// So close to a limit that rounding may decide.
    doubtful: u32,
    /// Not surely beyond the upper one.
    reachable: u32,
}

impl InRange {
    #[inline(always)]
    fn new<L: Lanes>(depth: L, view: &View) -> InRange {
        let (min, max) = (L::splat(view.min_range), L::splat(view.max_range));
        let close = depth.mul_add(L::splat(1e-5), L::splat(2e-3));
        InRange {
            reported: (depth.ge(min) & max.ge(depth)).bits(),
            doubtful: (close.ge((depth - max).abs()) | close.ge((depth - min).abs())).bits(),
            reachable: (max + close).ge(depth).bits(),
        }
    }

    /// Whether all are reported, beyond doubt.
    #[inline(always)]
    fn surely<L: Lanes>(&self) -> bool {
        self.reported.count_ones() as usize == L::N && self.doubtful == 0
    }
}

/// Writes what is reported of some distances, and 0 else.
#[inline(always)]
fn write_depth<L: Lanes>(depth: L, seen: &InRange, to: &mut [f32]) {
    if to.len() == L::N && seen.surely::<L>() {
        return depth.store(to, 0);
    }
    let mut depths = [0.0; WIDEST];
    depth.store(&mut depths, 0);
    for (lane, (to, depth)) in to.iter_mut().zip(depths).enumerate() {
        *to = if seen.reported >> lane & 1 == 1 { depth } else { 0.0 };
    }
}

/// Writes pixels that differ, one by one.
#[inline(always)]
fn scatter(
    seen: &InRange,
    ids: &[u32],
    (row, at): (usize, usize),
    body_of: impl Fn(u32) -> usize,
    semantics: &[(u8, u32)],
    image: &mut ImagesMut<'_>,
    doubts: &mut Doubts,
) {
    for (lane, &id) in ids.iter().enumerate() {
        let (column, is) = (at + lane, |bits: u32| bits >> lane & 1 == 1);
        image.clear(column, column + 1);
        if is(seen.reachable) && (id == DOUBT || is(seen.doubtful)) {
            image.depth[column] = 0.0;
            doubts.push((row, column));
        } else if is(seen.reported) {
            let body = body_of(id);
            image.fill(column, column + 1, body, semantics[body]);
        }
    }
}

impl ImagesMut<'_> {
    /// Writes that nothing is in some columns of a row, but for the depth.
    #[inline(always)]
    fn clear(&mut self, from: usize, to: usize) {
        self.label[from..to].fill(0);
        self.instance[from..to].fill(0);
        if let Some(primitive) = &mut self.primitive {
            primitive[from..to].fill(-1);
        }
    }

    /// Writes which body is in some columns of a row.
    #[inline(always)]
    fn fill(&mut self, from: usize, to: usize, body: usize, (label, instance): (u8, u32)) {
        self.label[from..to].fill(label);
        self.instance[from..to].fill(instance);
        if let Some(primitive) = &mut self.primitive {
            primitive[from..to].fill(body as i32);
        }
    }
}
