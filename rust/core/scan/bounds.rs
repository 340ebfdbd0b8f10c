//! Which pixels a convex body may cover, and how near it may come: eight or sixteen bodies at once.
//!
//! Bounds are angles, not corner rays: rays of equal elevation form a cone, which no four planes bound.

use std::f32::consts::PI;

use super::view::View;
use crate::packed::Outline;
use crate::simd::{Lanes, Mask, Matrix, Vector, WIDEST, arctangent};

/// The part of a view that a body may be seen in.
pub(super) struct Bounds<L: Lanes> {
    /// The largest 1 / horizontal distance of any of its points [1/m].
    pub(super) near: L,
    /// From this column to that one, counted over the whole turn and possibly beyond its seam.
    pub(super) low: L,
    pub(super) high: L,
    /// From this row of the band to that one.
    pub(super) first: L,
    pub(super) last: L,
    pub(super) seen: L::Mask,
}

/// Nearer than anything: for what may touch the axis.
pub(super) const TOUCHING: f32 = 1e30;
/// What columns are widened by to either side, for rounding.
const COLUMN_SLACK: f32 = 0.004;

impl View<'_> {
    /// Bounds of bodies around `center` whose half axes are `axes`, in the frame of the view.
    ///
    /// In the frame that looks at the centre (u towards it along the horizon, v to the left, z up) the body lies in a box; so
    /// its azimuth is within atan(v / u) of the centre's, and its slope z / distance is largest at the nearest point if it
    /// is above the horizon and at the furthest if it is below.
    #[inline(always)]
    pub(super) fn bounds<L: Lanes>(&self, center: Vector<L>, axes: &Matrix<L>, outline: Outline) -> Bounds<L> {
        let (zero, splat) = (L::splat(0.0), L::splat);
        let Vector { x, y, z } = center;
        let ground = (x.mul_add(x, y * y)).sqrt();
        let inverse = splat(1.0) / ground.max(splat(1e-20));
        // Straight above or below, any direction will do.
        let away = ground.gt(splat(1e-12));
        let (cos, sin) = (L::select(away, x * inverse, splat(1.0)), L::select(away, y * inverse, zero));
        let u = reach(axes.apply(Vector::new(cos, sin, zero)), outline);
        let v = reach(axes.apply(Vector::new(-sin, cos, zero)), outline);
        let h = reach(Vector::new(axes.x.z, axes.y.z, axes.z.z), outline);
        let slack = self.slack(ground + z.abs() + u + v + h);
        let (u, v, h) = (u + slack, v + slack, h + slack);
        let nearest = ground - u;
        let apart = nearest.gt(splat(1e-6));
        let near = L::select(apart, splat(1.0) / nearest, splat(TOUCHING));
        let furthest = splat(1.0) / (ground + u).mul_add(ground + u, v * v).sqrt();
        let (top, bottom) = (z + h, z - h);
        let high_slope = top * L::select(top.gt(zero), near, furthest);
        let low_slope = bottom * L::select(bottom.gt(zero), furthest, near);
        let (first, last) = self.band.rows_between(low_slope, high_slope);
        let width =
            L::select(apart, arctangent(v, nearest), splat(PI)).mul_add(splat(self.band.density), splat(self.margin()));
        let middle = self.column(arctangent(sin, cos));
        let beyond = (z.abs() - h).max(zero);
        let distance = nearest.max(zero);
        let distance = distance.mul_add(distance, beyond * beyond);
        let reached = splat(self.max_range * self.max_range * 1.001).ge(distance);
        let (low, high) = (middle - width, middle + width);
        let seen = last.ge(first) & reached & self.shows(low, high);
        Bounds { near, low, high, first, last, seen }
    }

    /// Whether columns of this view lie between two of the whole turn, where [`View::stretches`] says which.
    #[inline(always)]
    pub(super) fn shows<L: Lanes>(&self, low: L, high: L) -> L::Mask {
        if self.width() as f32 >= self.band.turn {
            return high.ge(low);
        }
        let turn = L::splat(self.band.turn);
        let (start, end) = (L::splat(self.columns.start as f32), L::splat((self.columns.end - 1) as f32));
        let away = ((low - start) / turn).floor();
        let here = end.ge(low - away * turn);
        let next = (high + (L::splat(-1.0) - away) * turn).ge(start);
        here | next | (high - low).ge(turn)
    }

    /// By how much everything at such a distance is grown: rounding, and the motion of the sensor during the view.
    #[inline(always)]
    pub(super) fn slack<L: Lanes>(&self, distance: L) -> L {
        let (shift, twist) = self.motion.as_ref().map_or((0.0, 0.0), |motion| (motion.shift, motion.twist));
        distance.mul_add(L::splat(twist + 8.0 * f32::EPSILON), L::splat(shift))
    }

    /// By how much columns are widened to either side: for three arctangents that are off by 1e-5, rounding, and sweeps.
    pub(super) fn margin(&self) -> f32 {
        3e-5 * self.band.density + COLUMN_SLACK + self.band.spread
    }

    /// The column of an azimuth, counted from the middle of column 0.
    #[inline(always)]
    pub(super) fn column<L: Lanes>(&self, azimuth: L) -> L {
        (L::splat(self.band.start as f32) - azimuth).mul_add(L::splat(self.band.density), L::splat(-0.5))
    }
}

/// How far a body reaches along a direction, from its half axes projected on it.
#[inline(always)]
fn reach<L: Lanes>(Vector { x: a, y: b, z: c }: Vector<L>, outline: Outline) -> L {
    match outline {
        Outline::Box => a.abs() + b.abs() + c.abs(),
        Outline::Cylinder => a.mul_add(a, b * b).sqrt() + c.abs(),
        Outline::Ellipsoid => a.mul_add(a, b.mul_add(b, c * c)).sqrt(),
    }
}

/// The pixels that a body may cover, as plain numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    /// No ray meets it at a larger 1 / horizontal distance [1/m].
    pub(super) near: f32,
    pub(super) low: f32,
    pub(super) high: f32,
    pub(super) first: usize,
    pub(super) last: usize,
}

impl View<'_> {
    /// The first and last column of each stretch of an area in this view: two if it lies across the seam, and stretches
    /// that end before they begin if it misses all columns.
    #[inline(always)]
    pub(super) fn stretches(&self, area: &Area) -> [(usize, usize); 2] {
        const NONE: (usize, usize) = (1, 0);
        let turn = self.band.turn;
        if area.high - area.low >= turn {
            return [(0, self.width() - 1), NONE];
        }
        let (start, end) = (self.columns.start as f32, (self.columns.end - 1) as f32);
        // The turn in which the area begins in this view or behind it, and the one before.
        let away = ((area.low - start) / turn).floor();
        let mut stretches = [NONE; 2];
        for (stretch, shift) in stretches.iter_mut().zip([-away * turn, (-1.0 - away) * turn]) {
            let (from, to) = ((area.low + shift).ceil().max(start), (area.high + shift).floor().min(end));
            if from <= to {
                *stretch = ((from - start) as usize, (to - start) as usize);
            }
        }
        stretches
    }
}

/// Bounds as plain numbers.
pub(super) struct Listed {
    near: [f32; WIDEST],
    low: [f32; WIDEST],
    high: [f32; WIDEST],
    first: [f32; WIDEST],
    last: [f32; WIDEST],
    seen: u32,
}

impl<L: Lanes> Bounds<L> {
    /// The first `count` of them.
    #[inline(always)]
    pub(super) fn listed(&self, count: usize) -> Listed {
        let none = [0.0; WIDEST];
        let mut listed = Listed { near: none, low: none, high: none, first: none, last: none, seen: self.seen.bits() };
        if count < WIDEST {
            listed.seen &= (1 << count) - 1;
        }
        self.near.store(&mut listed.near, 0);
        self.low.store(&mut listed.low, 0);
        self.high.store(&mut listed.high, 0);
        self.first.store(&mut listed.first, 0);
        self.last.store(&mut listed.last, 0);
        listed
    }
}

impl Listed {
    /// Forgets some, one bit each.
    #[inline(always)]
    pub(super) fn drop(&mut self, bodies: u32) {
        self.seen &= !bodies;
    }

    /// Those that may be seen, one bit each.
    #[inline(always)]
    pub(super) fn bits(&self) -> u32 {
        self.seen
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.seen == 0
    }

    /// The number and the area of each body that may be seen.
    #[inline(always)]
    pub(super) fn seen(&self) -> impl Iterator<Item = (usize, Area)> {
        let mut left = self.seen;
        std::iter::from_fn(move || {
            let lane = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (lane < WIDEST).then(|| {
                let (first, last) = (self.first[lane] as usize, self.last[lane] as usize);
                let (near, low, high) = (self.near[lane] * 1.0001, self.low[lane], self.high[lane]);
                (lane, Area { near, low, high, first, last })
            })
        })
    }
}
