//! Depth and id of the nearest surface so far at each pixel of a view.

use super::pixel_rect::PixelRect;
use super::ray_tests::Tolerance;
use super::view::View;
use crate::simd::{Aligned, Lanes, Mask, WIDEST};

/// The nearest surface so far at each pixel of a view, by rows.
///
/// For any order of shapes, a pixel ends with the nearest one, or unresolved if rounding decides which one that is.
#[derive(Default)]
pub(super) struct VisibilityBuffer {
    /// Inverse depth, 1 / horizontal distance [1/m]; 0 without a surface.
    pub(super) inverse_depth: Aligned<f32>,
    pub(super) id: Aligned<u32>,
    pub(super) stride: usize,
}

/// The id of a pixel whose nearest surface f32 cannot decide.
pub(super) const UNRESOLVED: u32 = u32::MAX;

impl VisibilityBuffer {
    /// Makes room for a view. The buffer is 0 already: [`write_images`](super::write_images) clears what it reads.
    pub(super) fn fit(&mut self, view: &View) {
        // Rows a power of two apart would share one place of the cache; rows an odd number of its lines apart do not.
        let lines = (view.width() + 2 * WIDEST).div_ceil(WIDEST) | 1;
        self.stride = lines * WIDEST;
        // One row more, so that a whole stride follows every pixel.
        let pixels = self.stride * (view.band.rows.len() + 1);
        if self.inverse_depth.len() < pixels {
            (self.inverse_depth, self.id) = (Aligned::new(0.0, pixels, 0), Aligned::new(UNRESOLVED, pixels, 2048));
        }
    }

    /// Whether the stored surfaces certainly occlude everything in the bounds of a rectangle, on each of its pixels.
    #[inline(always)]
    pub(super) fn is_occluded<L: Lanes>(&self, view: &View, rect: &PixelRect) -> bool {
        let nearest = L::splat(rect.inverse_depth);
        for (from, to) in rect.spans() {
            let rows = self.inverse_depth[rect.first * self.stride..].chunks_exact(self.stride);
            for row in rows.take(rect.last + 1 - rect.first) {
                for at in steps::<L>(from, to) {
                    let stored = L::load(row, at);
                    if nearest.gt(stored.neg_mul_add(view.tie(stored), stored)).any() {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Writes one pixel if it is nearest there: `nearest` is the upper bound of its inverse depth, `resolved` is that
    /// depth if known.
    #[inline(always)]
    pub(super) fn write_nearest(&mut self, pixel: usize, nearest: f32, resolved: Option<f32>, id: u32, view: &View) {
        let stored = self.inverse_depth[pixel];
        let tie = 2.0 * stored * (stored * view.tolerance.absolute + Tolerance::RELATIVE);
        if nearest > stored - tie {
            match resolved.filter(|&inverse_depth| inverse_depth > stored + tie) {
                Some(inverse_depth) => (self.inverse_depth[pixel], self.id[pixel]) = (inverse_depth, id),
                None => (self.inverse_depth[pixel], self.id[pixel]) = (nearest.max(stored), UNRESOLVED),
            }
        }
    }
}

impl View<'_> {
    /// The relative difference of two inverse depths beyond which resolved ranges decide which is nearer.
    #[inline(always)]
    pub(super) fn tie<L: Lanes>(&self, inverse_depth: L) -> L {
        inverse_depth.mul_add(L::splat(2.0 * self.tolerance.absolute), L::splat(2.0 * Tolerance::RELATIVE))
    }
}

/// The first columns of the vectors that cover a span.
#[inline(always)]
pub(super) fn steps<L: Lanes>(from: usize, to: usize) -> impl Iterator<Item = usize> {
    let count = (to + L::N - from.min(to + L::N)) / L::N;
    (0..count).map(move |step| from + step * L::N)
}

/// The lanes of the vector from a column on in a span that ends with another. The start of vectors depends on the cut
/// of a scan into views, but the images must not.
#[inline(always)]
pub(super) fn lanes_within<L: Lanes>(at: usize, to: usize) -> L::Mask {
    const LANES: [f32; WIDEST] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];
    L::splat((to - at) as f32).ge(L::load(&LANES, 0))
}
