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
        let (width, whole) = (view.width(), view.width() - view.width() % L::N);
        let mut plain = [0.0; WIDEST];
        for (row, image) in images.iter_mut().enumerate() {
            let start = row * self.stride;
            // One more vector: the last that was rasterized may have reached beyond the view.
            let (depths, beyond) = self.inverse_depth[start..start + whole + 2 * L::N].split_at_mut(whole);
            let (ids, rest) = self.id[start..start + width].split_at(whole);
            let secant = L::splat(view.band.secants[row]);
            let mut left = ImageRow::from_images(image);
            for (inverse_depth, ids) in depths.chunks_exact_mut(L::N).zip(ids.chunks_exact(L::N)) {
                let mut to = left.first(L::N);
                let depth = secant / L::load(inverse_depth, 0);
                zero.store(inverse_depth, 0);
                if limits.surely_reported(depth) && ids.iter().fold(true, |all, &id| all & (id != UNRESOLVED)) {
                    depth.store(to.depth, 0);
                    if L::all_equal(ids, 0) {
                        // Most vectors lie within one body.
                        to.fill(owners.look_up(ids[0]));
                    } else {
                        to.fill_each(ids, owners);
                    }
                } else if limits.surely_beyond(depth) {
                    to.clear();
                } else {
                    depth.store(&mut plain, 0);
                    let at = width - left.depth.len() - L::N;
                    write_pixels(&plain, ids, &limits, (row, at), owners, to, unresolved);
                }
            }
            (secant / L::load(beyond, 0)).store(&mut plain, 0);
            zero.store(beyond, 0);
            zero.store(beyond, L::N);
            write_pixels(&plain, rest, &limits, (row, whole), owners, left, unresolved);
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
        (depth.ge(L::splat(self.nearest)) & L::splat(self.furthest).ge(depth)).all()
    }

    /// Where nothing was rasterized, depth is infinite.
    #[inline(always)]
    fn surely_beyond<L: Lanes>(&self, depth: L) -> bool {
        !L::splat(self.beyond).ge(depth).any()
    }
}

/// Writes pixels that differ, one by one. Not inlined: it would take the registers of the loop that it is in.
#[inline(never)]
fn write_pixels(
    depths: &[f32],
    ids: &[u32],
    limits: &Limits,
    (row, at): (usize, usize),
    owners: &Owners,
    mut to: ImageRow<'_>,
    unresolved: &mut Unresolved,
) {
    for ((column, &id), &depth) in (at..).zip(ids).zip(depths) {
        let mut pixel = to.first(1);
        let unknown = id == UNRESOLVED || depth < limits.nearest || depth > limits.furthest;
        if unknown || depth > limits.beyond {
            pixel.clear();
            // What is surely beyond the limit is no return, whatever it is.
            if depth <= limits.beyond {
                unresolved.push((row, column));
            }
        } else {
            pixel.depth[0] = depth;
            pixel.fill(owners.look_up(id));
        }
    }
}

/// Which body an id belongs to.
pub(super) struct Owners<'a> {
    /// What numbered the surfaces, if ids are numbers of surfaces and not of bodies.
    pub(super) surfaces: Option<&'a BodyTable>,
    /// Class and instance of each body.
    pub(super) semantics: &'a [(u8, u32)],
}

impl Owners<'_> {
    /// The body of an id, its class and its instance.
    #[inline(always)]
    fn look_up(&self, id: u32) -> (usize, u8, u32) {
        let body = self.surfaces.map_or(id as usize, |table| table.body_of(id));
        let (label, instance) = self.semantics[body];
        (body, label, instance)
    }
}

/// What is left to be written of one row of the images.
struct ImageRow<'a> {
    depth: &'a mut [f32],
    label: &'a mut [u8],
    instance: &'a mut [u32],
    primitive: Option<&'a mut [i32]>,
}

impl<'a> ImageRow<'a> {
    #[inline(always)]
    fn from_images(image: &'a mut ImagesMut<'_>) -> ImageRow<'a> {
        ImageRow {
            depth: image.depth,
            label: image.label,
            instance: image.instance,
            primitive: image.primitive.as_deref_mut(),
        }
    }

    /// Takes off the next columns.
    #[inline(always)]
    fn first(&mut self, count: usize) -> ImageRow<'a> {
        ImageRow {
            depth: first(&mut self.depth, count),
            label: first(&mut self.label, count),
            instance: first(&mut self.instance, count),
            primitive: self.primitive.as_mut().map(|left| first(left, count)),
        }
    }

    /// Writes that nothing is in these columns.
    #[inline(always)]
    fn clear(&mut self) {
        self.depth.fill(0.0);
        self.label.fill(0);
        self.instance.fill(0);
        if let Some(primitive) = &mut self.primitive {
            primitive.fill(-1);
        }
    }

    /// Writes which body is in each of these columns.
    #[inline(always)]
    fn fill_each(&mut self, ids: &[u32], owners: &Owners) {
        let (mut last, mut owner) = (ids[0], owners.look_up(ids[0]));
        for (k, &id) in ids.iter().enumerate() {
            if id != last {
                (last, owner) = (id, owners.look_up(id));
            }
            (self.label[k], self.instance[k]) = (owner.1, owner.2);
            if let Some(primitive) = &mut self.primitive {
                primitive[k] = owner.0 as i32;
            }
        }
    }

    /// Writes which body is in all of these columns.
    #[inline(always)]
    fn fill(&mut self, (body, label, instance): (usize, u8, u32)) {
        self.label.fill(label);
        self.instance.fill(instance);
        if let Some(primitive) = &mut self.primitive {
            primitive.fill(body as i32);
        }
    }
}

/// Takes off the first elements of a slice.
#[inline(always)]
fn first<'a, T>(left: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, rest) = std::mem::take(left).split_at_mut(count);
    *left = rest;
    first
}
