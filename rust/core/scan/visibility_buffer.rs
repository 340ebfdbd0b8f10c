//! Depth and id of what is nearest at each pixel of a view so far.

use super::pixel_rect::PixelRect;
use super::ray_tests::Tolerance;
use super::view::View;
use crate::simd::{Aligned, Lanes, Mask, WIDEST};

/// What is nearest so far at each pixel of a view, by rows.
///
/// In whatever order shapes are rasterized, a pixel ends with the nearest one, or unresolved if rounding decides which one
/// that is.
#[derive(Default)]
pub(super) struct VisibilityBuffer {
    /// Inverse depth, 1 / horizontal distance [1/m]; 0 where nothing is.
    pub(super) inverse_depth: Aligned<f32>,
    pub(super) id: Aligned<u32>,
    pub(super) stride: usize,
}

/// The id of a pixel at which f32 cannot tell what is nearest.
pub(super) const UNRESOLVED: u32 = u32::MAX;

impl VisibilityBuffer {
    /// Makes room for a view. What is left of the view before is 0 already: [`write_images`](super::write_images)
    /// clears what it reads.
    pub(super) fn fit(&mut self, view: &View) {
        // Rows a power of two apart would fall on one place of the cache; an odd number of its lines apart they do not.
        let lines = (view.width() + 2 * WIDEST).div_ceil(WIDEST) | 1;
        self.stride = lines * WIDEST;
        // One row more, so that a whole stride follows every pixel.
        let pixels = self.stride * (view.band.rows.len() + 1);
        if self.inverse_depth.len() < pixels {
            (self.inverse_depth, self.id) = (Aligned::new(0.0, pixels, 0), Aligned::new(UNRESOLVED, pixels, 2048));
        }
    }

    /// Whether what is stored surely occludes, on every pixel of a rectangle, what is bounded by it.
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

    /// Writes one pixel if it is nearest there: `nearest` is the most that its inverse depth may be, `resolved` is that
    /// depth where it is known.
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
    /// The share that the inverse depth of another surface must differ by so that resolved ranges tell which is nearer.
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

/// Which lanes of the vector from a column on lie in a span that ends with another: where vectors begin depends on how a
/// scan is cut into views, and nothing that is seen of it may.
#[inline(always)]
pub(super) fn lanes_within<L: Lanes>(at: usize, to: usize) -> L::Mask {
    const LANES: [f32; WIDEST] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];
    L::splat((to - at) as f32).ge(L::load(&LANES, 0))
}
