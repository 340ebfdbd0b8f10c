//! Rays against a box.

use super::slab::Slab;
use super::{MediumTest, RayTest, ShapeFrame, ShapeInView, Tolerance, three};
use crate::simd::{Lanes, Vector};

/// A box: Kay and Kajiya's slabs; `INSIDE` if rays start in it.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Cuboid<const INSIDE: bool>(pub(in crate::scan) ShapeFrame);

#[derive(Clone, Copy)]
pub(in crate::scan) struct CuboidTest<L, const INSIDE: bool> {
    rows: [Vector<L>; 4],
    slabs: [Slab<L>; 3],
}

impl<const INSIDE: bool> ShapeInView for Cuboid<INSIDE> {
    type Test<L: Lanes> = CuboidTest<L, INSIDE>;

    #[inline(always)]
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> CuboidTest<L, INSIDE> {
        let (axes, from) = self.0.axes_and_start(start);
        let slabs = [self.0.slab(0, from.x), self.0.slab(1, from.y), self.0.slab(2, from.z)];
        CuboidTest { rows: three(axes.x, axes.y, axes.z), slabs }
    }
}

impl<L: Lanes, const INSIDE: bool> CuboidTest<L, INSIDE> {
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

impl<L: Lanes, const INSIDE: bool> RayTest<L> for CuboidTest<L, INSIDE> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn upper_bounds(&self, d: [L; 4]) -> (L, L) {
        if INSIDE {
            return (self.leaves(&d, 1.0), L::splat(1.0));
        }
        let enter = self.enters(&d, 1.0);
        (enter, enter - self.leaves(&d, -1.0))
    }

    #[inline(always)]
    fn resolved(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        if INSIDE {
            let (least, most) = (self.leaves(&d, -1.0), self.leaves(&d, 1.0));
            return (most, tolerance.allowed_error(most).ge(most - least));
        }
        let (least, most) = (self.enters(&d, -1.0), self.enters(&d, 1.0));
        (most, least.gt(self.leaves(&d, 1.0)) & tolerance.allowed_error(most).ge(most - least))
    }
}

impl<L: Lanes, const INSIDE: bool> MediumTest<L> for CuboidTest<L, INSIDE> {
    #[inline(always)]
    fn widest_interval(&self, d: [L; 4]) -> (L, L, L) {
        let (enter, leave) = (self.enters(&d, 1.0), self.leaves(&d, -1.0));
        (enter, leave, enter - leave)
    }

    #[inline(always)]
    fn narrowest_interval(&self, d: [L; 4]) -> (L, L, L::Mask) {
        let (enter, leave) = (self.enters(&d, -1.0), self.leaves(&d, 1.0));
        (enter, leave, enter.gt(leave))
    }
}
