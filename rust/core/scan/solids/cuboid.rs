//! Rays against a box.

use super::slab::Slab;
use super::{Local, Porous, Shape, Solid, Tolerance, three};
use crate::simd::{Lanes, Vector};

/// A box: Kay and Kajiya's slabs; `INSIDE` if rays start in it.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Cuboid<const INSIDE: bool>(pub(in crate::scan) Local);

#[derive(Clone, Copy)]
pub(in crate::scan) struct SeenCuboid<L, const INSIDE: bool> {
    rows: [Vector<L>; 4],
    slabs: [Slab<L>; 3],
}

impl<const INSIDE: bool> Shape for Cuboid<INSIDE> {
    type Seen<L: Lanes> = SeenCuboid<L, INSIDE>;

    #[inline(always)]
    fn seen_from<L: Lanes>(&self, start: Vector<L>) -> SeenCuboid<L, INSIDE> {
        let (axes, from) = self.0.place(start);
        let slabs = [self.0.slab(0, from.x), self.0.slab(1, from.y), self.0.slab(2, from.z)];
        SeenCuboid { rows: three(axes.x, axes.y, axes.z), slabs }
    }
}

impl<L: Lanes, const INSIDE: bool> SeenCuboid<L, INSIDE> {
    #[inline(always)]
    fn enters(&self, d: &[L; 4], sign: f32) -> L {
        let [x, y, z] = &self.slabs;
        x.enters(d[0], sign).min(y.enters(d[1], sign)).min(z.enters(d[2], sign))
    }

    #[inline(always)]
    fn leaves(&self, d: &[L; 4], sign: f32) -> L {
        let [x, y, z] = &self.slabs;
        x.leaves(d[0], sign).max(y.leaves(d[1], sign)).max(z.leaves(d[2], sign))
    }
}

impl<L: Lanes, const INSIDE: bool> Solid<L> for SeenCuboid<L, INSIDE> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn at_most(&self, d: [L; 4]) -> (L, L) {
        if INSIDE {
            return (self.leaves(&d, 1.0), L::splat(1.0));
        }
        let enter = self.enters(&d, 1.0);
        (enter, enter - self.leaves(&d, -1.0))
    }

    #[inline(always)]
    fn settled(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        if INSIDE {
            let (least, most) = (self.leaves(&d, -1.0), self.leaves(&d, 1.0));
            return (most, tolerance.of(most).ge(most - least));
        }
        let (least, most) = (self.enters(&d, -1.0), self.enters(&d, 1.0));
        (most, least.gt(self.leaves(&d, 1.0)) & tolerance.of(most).ge(most - least))
    }
}

impl<L: Lanes, const INSIDE: bool> Porous<L> for SeenCuboid<L, INSIDE> {
    #[inline(always)]
    fn at_most_through(&self, d: [L; 4]) -> (L, L, L) {
        let (enter, leave) = (self.enters(&d, 1.0), self.leaves(&d, -1.0));
        (enter, leave, enter - leave)
    }

    #[inline(always)]
    fn at_least_through(&self, d: [L; 4]) -> (L, L, L::Mask) {
        let (enter, leave) = (self.enters(&d, -1.0), self.leaves(&d, 1.0));
        (enter, leave, enter.gt(leave))
    }
}
