//! The pixels that a convex body may cover, and its least distance: eight or sixteen bodies at once.
//!
//! Bounds are angles, not corner rays: rays of equal elevation form a cone, which four planes cannot bound.

use std::f32::consts::PI;

use super::ray_tests::UNBOUNDED;
use super::view::View;
use crate::packed::Outline;
use crate::simd::{Lanes, Matrix, Vector, arctangent};

/// The part of a view in which a body may be visible.
pub(super) struct PixelBounds<L: Lanes> {
    /// The largest inverse depth, 1 / horizontal distance, of any of its points [1/m].
    pub(super) inverse_depth: L,
    /// The columns from `low` on, counted over the whole turn and possibly beyond its seam.
    pub(super) low: L,
    pub(super) high: L,
    /// The rows of the band from `first` on.
    pub(super) first: L,
    pub(super) last: L,
    /// Whether any pixel is left.
    pub(super) visible: L::Mask,
}

/// The widening of columns to either side, for rounding.
const COLUMN_SLACK: f32 = 0.004;

impl View<'_> {
    /// Bounds of bodies around `center` whose half axes are `axes`, in the frame of the view.
    ///
    /// In the frame that faces the centre (u towards it along the horizon, v to the left, z up) the body is in a box.
    /// So its azimuth is within atan(v / u) of the centre's, and its slope z / distance is largest at the nearest point
    /// if it is above the horizon and at the furthest if it is below.
    #[inline(always)]
    pub(super) fn bounds<L: Lanes>(&self, center: Vector<L>, axes: &Matrix<L>, outline: Outline) -> PixelBounds<L> {
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
        let inverse_depth = L::select(apart, splat(1.0) / nearest, splat(UNBOUNDED));
        let furthest = splat(1.0) / (ground + u).mul_add(ground + u, v * v).sqrt();
        let (top, bottom) = (z + h, z - h);
        let high_slope = top * L::select(top.gt(zero), inverse_depth, furthest);
        let low_slope = bottom * L::select(bottom.gt(zero), furthest, inverse_depth);
        let (first, last) = self.band.rows_between(low_slope, high_slope);
        let width = L::select(apart, arctangent(v, nearest), splat(PI))
            .mul_add(splat(self.band.columns_per_radian), splat(self.column_margin()));
        let middle = self.column(arctangent(sin, cos));
        let beyond = (z.abs() - h).max(zero);
        let distance = nearest.max(zero);
        let distance = distance.mul_add(distance, beyond * beyond);
        let reached = splat(self.max_range * self.max_range * 1.001).ge(distance);
        let (low, high) = (middle - width, middle + width);
        let visible = last.ge(first) & reached & self.has_columns(low, high);
        PixelBounds { inverse_depth, low, high, first, last, visible }
    }

    /// Whether columns of this view are between two of the whole turn; [`PixelBounds::rects`] gives these.
    #[inline(always)]
    pub(super) fn has_columns<L: Lanes>(&self, low: L, high: L) -> L::Mask {
        if self.width() as f32 >= self.band.columns_per_turn {
            return high.ge(low);
        }
        let turn = L::splat(self.band.columns_per_turn);
        let (start, end) = (L::splat(self.columns.start as f32), L::splat((self.columns.end - 1) as f32));
        let away = ((low - start) / turn).floor();
        let here = end.ge(low - away * turn);
        let next = (high + (L::splat(-1.0) - away) * turn).ge(start);
        here | next | (high - low).ge(turn)
    }

    /// The growth of everything at a distance: rounding, and the motion of the sensor during the view.
    #[inline(always)]
    pub(super) fn slack<L: Lanes>(&self, distance: L) -> L {
        let (shift, twist) = self.motion.as_ref().map_or((0.0, 0.0), |motion| (motion.shift, motion.twist));
        distance.mul_add(L::splat(twist + 8.0 * f32::EPSILON), L::splat(shift))
    }

    /// The widening of columns to either side: for three arctangents that are off by 1e-5, rounding, and phases.
    pub(super) fn column_margin(&self) -> f32 {
        3e-5 * self.band.columns_per_radian + COLUMN_SLACK + self.band.phase_reach
    }

    /// The column of an azimuth, counted from the middle of column 0.
    #[inline(always)]
    pub(super) fn column<L: Lanes>(&self, azimuth: L) -> L {
        (L::splat(self.band.azimuth_start as f32) - azimuth)
            .mul_add(L::splat(self.band.columns_per_radian), L::splat(-0.5))
    }
}

/// The extent of a body along a direction, from its half axes projected on it.
#[inline(always)]
fn reach<L: Lanes>(Vector { x: a, y: b, z: c }: Vector<L>, outline: Outline) -> L {
    match outline {
        Outline::Box => a.abs() + b.abs() + c.abs(),
        Outline::Cylinder => a.mul_add(a, b * b).sqrt() + c.abs(),
        Outline::Ellipsoid => a.mul_add(a, b.mul_add(b, c * c)).sqrt(),
    }
}
