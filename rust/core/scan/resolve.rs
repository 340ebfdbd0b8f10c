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
        let (limits, zero) = (Limits::new(view), L::splat(0.0));
        let whole = view.width() - view.width() % L::N;
        for (row, image) in images.iter_mut().enumerate() {
            let secant = L::splat(view.band.secants[row]);
            for at in (0..whole).step_by(L::N) {
                let pixel = row * self.stride + at;
                let depth = secant / L::load(&self.near, pixel);
                zero.store(&mut self.near, pixel);
                let id = self.id[pixel];
                if limits.surely_reported(depth) && id != DOUBT && L::all_equal(&self.id, pixel) {
                    // Most vectors lie within one body.
                    let body = body_of(id);
                    depth.store(image.depth, at);
                    image.fill(at, at + L::N, body, semantics[body]);
                } else if limits.surely_beyond(depth) {
                    zero.store(image.depth, at);
                    image.clear(at, at + L::N);
                } else {
                    let ids = &self.id[pixel..pixel + L::N];
                    scatter(depth, ids, &limits, (row, at), body_of, semantics, image, doubts);
                }
            }
            // The last vector that was drawn may have reached beyond the view.
            let pixel = row * self.stride + whole;
            let depth = secant / L::load(&self.near, pixel);
            zero.store(&mut self.near, pixel);
            zero.store(&mut self.near, pixel + L::N);
            let ids = &self.id[pixel..pixel + view.width() - whole];
            scatter(depth, ids, &limits, (row, whole), body_of, semantics, image, doubts);
        }
    }
}

/// Which distances are reported [m]; within a little of a limit, rounding may decide.
struct Limits {
    /// Between these, surely.
    nearest: f32,
    furthest: f32,
    /// Beyond this, surely not.
    beyond: f32,
}

impl Limits {
    fn new(view: &View) -> Limits {
        let (min, max) = (view.min_range, view.max_range);
        let slack = |distance: f32| 2e-3 + 1e-5 * distance;
        Limits { nearest: min + slack(min), furthest: max - slack(max), beyond: max + slack(max) }
    }

    #[inline(always)]
    fn surely_reported<L: Lanes>(&self, depth: L) -> bool {
        let within = depth.ge(L::splat(self.nearest)) & L::splat(self.furthest).ge(depth);
        within.bits() == u32::MAX >> (32 - L::N)
    }

    /// Where nothing is drawn, depth is infinite.
    #[inline(always)]
    fn surely_beyond<L: Lanes>(&self, depth: L) -> bool {
        !L::splat(self.beyond).ge(depth).any()
    }
}

/// Writes pixels that differ, one by one.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "the inner part of one loop")]
fn scatter<L: Lanes>(
    depths: L,
    ids: &[u32],
    limits: &Limits,
    (row, at): (usize, usize),
    body_of: impl Fn(u32) -> usize,
    semantics: &[(u8, u32)],
    image: &mut ImagesMut<'_>,
    doubts: &mut Doubts,
) {
    let mut plain = [0.0; WIDEST];
    depths.store(&mut plain, 0);
    for ((column, &id), depth) in (at..).zip(ids).zip(plain) {
        let doubtful = id == DOUBT || depth < limits.nearest || depth > limits.furthest;
        image.depth[column] = 0.0;
        image.clear(column, column + 1);
        if depth > limits.beyond {
            continue;
        }
        if doubtful {
            doubts.push((row, column));
        } else {
            let body = body_of(id);
            image.depth[column] = depth;
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
