//! The pixels that triangles of a meshlet may cover: one to a lane.

use super::pixel_bounds::PixelBounds;
use super::rasterize_mesh::MeshletCenter;
use super::ray_tests::UNBOUNDED;
use super::view::View;
use crate::simd::{Lanes, Mask, Vector, arctangent, small_arctangent};

#[inline(always)]
fn smallest<L: Lanes>([a, b, c]: [L; 3]) -> L {
    a.min(b).min(c)
}

#[inline(always)]
fn largest<L: Lanes>([a, b, c]: [L; 3]) -> L {
    a.max(b).max(c)
}

/// Bounds of triangles relative to some heading.
struct TangentBounds<L: Lanes> {
    /// Tangents of the azimuths, to the left of the heading.
    left: L,
    right: L,
    first: L,
    last: L,
    /// Whether the triangle is ahead, within 45 degrees of the heading.
    simple: L::Mask,
}

impl View<'_> {
    /// Bounds of triangles close to the middle of their meshlet.
    #[inline(always)]
    pub(super) fn triangle_bounds<L: Lanes>(&self, corners: &[Vector<L>; 3], middle: &MeshletCenter) -> PixelBounds<L> {
        let splat = L::splat;
        let (inverse_depth, slack) = (splat(middle.inverse_depth), self.slack(splat(middle.reach)));
        let tangent_bounds = self.tangent_bounds(corners, (splat(middle.heading[0]), splat(middle.heading[1])), slack);
        let TangentBounds { first, last, simple, .. } = tangent_bounds;
        let (low, high) = self.columns_between(&tangent_bounds, splat(middle.column));
        // Far away most triangles are between two columns, or between two rows.
        let between = splat(self.band.columns_per_turn.fract()).gt(splat(0.0));
        let visible = last.ge(first) & (high.floor().ge(low) | between) & self.has_columns(low, high);
        if simple.all() {
            return PixelBounds { inverse_depth, low, high, first, last, visible };
        }
        // Close triangles to the side of that middle, or behind: each along its own heading.
        let [a, b, c] = corners;
        let (x, y) = (a.x + b.x + c.x, a.y + b.y + c.y);
        let inverse = splat(1.0) / x.mul_add(x, y * y).sqrt().max(splat(1e-20));
        let (cos, sin) = (x * inverse, y * inverse);
        let own = self.tangent_bounds(corners, (cos, sin), slack);
        let (own_low, own_high) = self.columns_between(&own, self.column(arctangent(sin, cos)));
        // And those around the sensor, by height and distance alone.
        let (far_first, far_last) = self.rows_around(corners, slack);
        let turn = splat(self.band.columns_per_turn);
        let first = L::select(simple, first, L::select(own.simple, own.first, far_first));
        let last = L::select(simple, last, L::select(own.simple, own.last, far_last));
        let low = L::select(simple, low, L::select(own.simple, own_low, -turn));
        let high = L::select(simple, high, L::select(own.simple, own_high, turn));
        let visible = last.ge(first) & (high.floor().ge(low) | between) & self.has_columns(low, high);
        PixelBounds { inverse_depth, low, high, first, last, visible }
    }

    /// In the frame along a heading a corner has the tangents v / u and z / u, so a triangle ahead is bounded by those
    /// of its corners. The slope of a point is its z / u times the cosine of its azimuth.
    #[inline(always)]
    fn tangent_bounds<L: Lanes>(&self, [a, b, c]: &[Vector<L>; 3], (cos, sin): (L, L), slack: L) -> TangentBounds<L> {
        let (zero, one, splat) = (L::splat(0.0), L::splat(1.0), L::splat);
        let ahead = [a.x.mul_add(cos, a.y * sin), b.x.mul_add(cos, b.y * sin), c.x.mul_add(cos, c.y * sin)];
        let aside = [a.y.mul_add(cos, -(a.x * sin)), b.y.mul_add(cos, -(b.x * sin)), c.y.mul_add(cos, -(c.x * sin))];
        let nearest = smallest(ahead) - slack;
        let inverse = [one / ahead[0], one / ahead[1], one / ahead[2]];
        let tangent = [aside[0] * inverse[0], aside[1] * inverse[1], aside[2] * inverse[2]];
        let grade = [a.z * inverse[0], b.z * inverse[1], c.z * inverse[2]];
        // The largest change of either by a point that is moved by the slack.
        let blur = slack / nearest;
        let (left, right) = (largest(tangent), smallest(tangent));
        let steepest = largest(grade).max(-smallest(grade));
        let (left, right) = (left + blur * (left.abs() + one), right - blur * (right.abs() + one));
        let rise = blur * (steepest + one);
        let (top, bottom) = (largest(grade) + rise, smallest(grade) - rise);
        // 1 - x^2 / 2 <= cos(atan(x)) <= 1 - x^2 / 2 + 3 x^4 / 8.
        let widest = left.abs().max(right.abs());
        let narrowest = right.max(-left).max(zero);
        let (wide, narrow) = (widest * widest, narrowest * narrowest);
        let low = wide.mul_add(splat(-0.5), one);
        let high = narrow.mul_add(narrow.mul_add(splat(0.375), splat(-0.5)), one);
        let top = top * L::select(top.gt(zero), high, low);
        let bottom = bottom * L::select(bottom.gt(zero), low, high);
        let (first, last) = self.band.rows_between(bottom, top);
        TangentBounds { left, right, first, last, simple: nearest.gt(splat(1e-6)) & one.ge(widest) }
    }

    /// The columns between two tangents, relative to the heading of a column.
    #[inline(always)]
    fn columns_between<L: Lanes>(&self, tangent_bounds: &TangentBounds<L>, column: L) -> (L, L) {
        let (density, margin) = (L::splat(self.band.columns_per_radian), L::splat(self.column_margin()));
        let low = small_arctangent(tangent_bounds.left).neg_mul_add(density, column) - margin;
        let high = small_arctangent(tangent_bounds.right).neg_mul_add(density, column) + margin;
        (low, high)
    }

    /// The rows of triangles at any place, by height and distance.
    #[inline(always)]
    fn rows_around<L: Lanes>(&self, [a, b, c]: &[Vector<L>; 3], slack: L) -> (L, L) {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let above = [a.z, b.z, c.z];
        let distance = [a.x.mul_add(a.x, a.y * a.y), b.x.mul_add(b.x, b.y * b.y), c.x.mul_add(c.x, c.y * c.y)];
        let furthest = one / (largest(distance).sqrt() + slack);
        let (ceiling, floor) = (largest(above) + slack, smallest(above) - slack);
        let top = ceiling * L::select(ceiling.gt(zero), L::splat(UNBOUNDED), furthest);
        let bottom = floor * L::select(floor.gt(zero), furthest, L::splat(UNBOUNDED));
        self.band.rows_between(bottom, top)
    }
}
