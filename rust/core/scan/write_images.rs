//! A rasterized view as images.

use super::view::View;
use super::visibility_buffer::{UNRESOLVED, VisibilityBuffer};
use crate::ImagesMut;
use crate::packed::BodyTable;
use crate::simd::{Lanes, Mask, WIDEST};

/// The pixels that f32 could not resolve: row and column of the view.
pub(super) type Unresolved = Vec<(usize, usize)>;

impl VisibilityBuffer {
    /// Writes the images of a view, row by row, and leaves the buffer empty.
    ///
    /// Unresolved pixels are listed and left without return.
    #[inline(always)]
    pub(super) fn write_images<L: Lanes>(
        &mut self,
        view: &View,
        owners: &Owners,
        images: &mut [ImagesMut<'_>],
        unresolved: &mut Unresolved,
    ) {
        let (limits, zero) = (Limits::new(view), L::splat(0.0));
        for (row, image) in images.iter_mut().enumerate() {
            let start = row * self.stride;
            let (depths, ids) = (&mut self.inverse_depth[start..][..self.stride], &self.id[start..][..self.stride]);
            let secant = L::splat(view.band.secants[row]);
            let mut primitive = image.primitive.as_mut().map(|primitive| primitive.chunks_mut(L::N));
            let to =
                image.depth.chunks_mut(L::N).zip(image.label.chunks_mut(L::N)).zip(image.instance.chunks_mut(L::N));
            let from = depths.chunks_exact_mut(L::N).zip(ids.chunks_exact(L::N));
            let mut at = 0;
            for (((depth, label), instance), (inverse_depth, ids)) in to.zip(from) {
                let range = secant / L::load(inverse_depth, 0);
                zero.store(inverse_depth, 0);
                let (reported, unknown) = limits.reported(range, L::load(ids, 0));
                L::select(reported, range, zero).store_first(depth);
                let [labels, instances, bodies] = owners.look_up::<L>(ids, reported);
                labels.store_bytes(label);
                instances.store_first(instance);
                if let Some(primitive) = primitive.as_mut().and_then(Iterator::next) {
                    bodies.store_first(primitive);
                }
                let mut unknown = unknown & ((1 << depth.len()) - 1);
                while unknown != 0 {
                    unresolved.push((row, at + unknown.trailing_zeros() as usize));
                    unknown &= unknown - 1;
                }
                at += L::N;
            }
            // The last rasterized vector may have reached beyond the view.
            zero.store(depths, at);
        }
    }
}

/// The limits of reported distances [m]; close to a limit, rounding may decide.
struct Limits {
    /// Between these, certainly.
    nearest: f32,
    furthest: f32,
    /// Beyond this, certainly not.
    beyond: f32,
}

impl Limits {
    fn new(view: &View) -> Limits {
        let (min, max) = (view.min_range, view.max_range);
        let slack = |distance: f32| 2e-3 + 1e-5 * distance;
        Limits { nearest: min + slack(min), furthest: max - slack(max), beyond: max + slack(max) }
    }

    /// The reported depths, and others that may have to be reported, bit by bit.
    #[inline(always)]
    fn reported<L: Lanes>(&self, depth: L, ids: L) -> (L::Mask, u32) {
        let unresolved = ids.eq_bits(L::splat_bits(UNRESOLVED));
        let known = L::select(unresolved, L::splat(f32::NAN), depth);
        let reported = known.ge(L::splat(self.nearest)) & L::splat(self.furthest).ge(known);
        // Surfaces certainly beyond the limit are no return; without a surface, depth is infinite.
        let unknown = L::splat(self.beyond).ge(depth).bits() & !reported.bits();
        (reported, unknown)
    }
}

/// The body of each id.
pub(super) struct Owners<'a> {
    /// The table of surfaces, if ids are numbers of surfaces and not of bodies.
    pub(super) surfaces: Option<&'a BodyTable>,
    /// Class and instance of each body.
    pub(super) semantics: &'a [(u8, u32)],
}

impl Owners<'_> {
    /// Class, instance and body of each reported id; 0, 0 and -1 for the others.
    #[inline(always)]
    fn look_up<L: Lanes>(&self, ids: &[u32], reported: L::Mask) -> [L; 3] {
        let (bits, zero, none) = (reported.bits(), L::splat_bits(0), L::splat_bits(u32::MAX));
        if bits == 0 {
            return [zero, zero, none];
        }
        let all = L::load(ids, 0);
        let (first, last) = (ids[bits.trailing_zeros() as usize], ids[bits.ilog2() as usize]);
        let (is_first, is_last) = (all.eq_bits(L::splat_bits(first)), all.eq_bits(L::splat_bits(last)));
        let [labels, instances, bodies] = if bits & !(is_first | is_last).bits() == 0 {
            // Most vectors are within one body, few in more than two.
            let ([a, b, c], [d, e, f]) = (self.owner(first), self.owner(last));
            [
                L::select(is_first, L::splat_bits(a), L::splat_bits(d)),
                L::select(is_first, L::splat_bits(b), L::splat_bits(e)),
                L::select(is_first, L::splat_bits(c), L::splat_bits(f)),
            ]
        } else {
            let (mut known, mut owners) = ([0; WIDEST], [[0; WIDEST]; 3]);
            L::select(reported, all, L::splat_bits(first)).store(&mut known, 0);
            for (lane, &id) in known[..L::N].iter().enumerate() {
                [owners[0][lane], owners[1][lane], owners[2][lane]] = self.owner(id);
            }
            [L::load(&owners[0], 0), L::load(&owners[1], 0), L::load(&owners[2], 0)]
        };
        [L::select(reported, labels, zero), L::select(reported, instances, zero), L::select(reported, bodies, none)]
    }

    /// Class, instance and body of an id.
    #[inline(always)]
    fn owner(&self, id: u32) -> [u32; 3] {
        let body = self.surfaces.map_or(id as usize, |table| table.body_of(id));
        let (label, instance) = self.semantics[body];
        [u32::from(label), instance, body as u32]
    }
}
