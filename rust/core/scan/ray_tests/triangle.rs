//! Rays against a triangle.

use super::{RayTest, ShapeInView, Tolerance, UNBOUNDED};
use crate::simd::{Lanes, Vector};

/// A triangle. Its corners are relative to the view, the edge from the last to the first is the longest.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Triangle {
    pub(in crate::scan) corners: [[f32; 3]; 3],
    /// The largest coordinate from which its corners were computed [m].
    pub(in crate::scan) reach: f32,
    pub(in crate::scan) rounding: f32,
}

/// Rows: the normals of the three planes through the rays' start and an edge, and the plane of the triangle.
#[derive(Clone, Copy)]
pub(in crate::scan) struct TriangleTest<L> {
    pub(in crate::scan) rows: [Vector<L>; 4],
    pub(in crate::scan) edge_error: L,
    pub(in crate::scan) plane_error: L,
    /// The relative error of the distance of the plane.
    pub(in crate::scan) height_error: L,
}

impl ShapeInView for Triangle {
    type Test<L: Lanes> = TriangleTest<L>;

    #[inline(always)]
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> TriangleTest<L> {
        let [a, b, c] = self.corners;
        let corners = [Vector::splat(a) - start, Vector::splat(b) - start, Vector::splat(c) - start];
        TriangleTest::new(corners, L::splat(self.reach), self.rounding)
    }
}

/// A triangle whose plane is known more precisely than by f32 corners.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Facet {
    pub(in crate::scan) corners: [[f32; 3]; 3],
    /// The unit normal, and the plane's distance along it [m].
    pub(in crate::scan) normal: [f32; 3],
    pub(in crate::scan) height: f32,
    /// The distance of the furthest corner [m].
    pub(in crate::scan) reach: f32,
    /// The largest distance of a ray's start from the view's origin [m].
    pub(in crate::scan) shift: f32,
    pub(in crate::scan) rounding: f32,
}

impl ShapeInView for Facet {
    type Test<L: Lanes> = TriangleTest<L>;

    #[inline(always)]
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> TriangleTest<L> {
        let [a, b, c] = self.corners;
        let corners = [Vector::splat(a) - start, Vector::splat(b) - start, Vector::splat(c) - start];
        let normal = Vector::splat(self.normal);
        let height = L::splat(self.height) - normal.dot(start);
        let (zero, one, unbounded) = (L::splat(0.0), L::splat(1.0), L::splat(UNBOUNDED));
        // In the plane itself, the side is unknown: then these rays resolve nothing.
        let known = height.abs().gt(L::splat(1e-6 * self.reach));
        let inverse = L::select(known, one / height, zero);
        let ([x, y, z], longest) = edges(corners, one.copysign(height));
        // Close to the plane, the rounding of the start of a ray counts for more.
        let lost = (height.abs() + L::splat(3.0 * self.shift)) * inverse.abs() * L::splat(4.0 * self.rounding);
        TriangleTest {
            rows: [x, y, z, normal * inverse],
            edge_error: L::select(known, longest * L::splat(8.0 * self.rounding * self.reach), unbounded),
            plane_error: L::select(known, inverse.abs() * L::splat(4.0 * self.rounding), unbounded),
            height_error: lost,
        }
    }
}

/// The edge functions of a triangle, positive within it if it is seen from `side`, and the length of its longest edge.
///
/// Edges are computed as differences: the product of two far corners would cancel to a short edge.
#[inline(always)]
fn edges<L: Lanes>([a, b, c]: [Vector<L>; 3], side: L) -> ([Vector<L>; 3], L) {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let longest = ab.dot(ab).max(bc.dot(bc)).max(ca.dot(ca)).sqrt();
    ([a.cross(ab) * side, b.cross(bc) * side, c.cross(ca) * side], longest)
}

impl<L: Lanes> TriangleTest<L> {
    /// A triangle with these corners relative to the start of the rays, the edge from the last to the first the longest.
    #[inline(always)]
    pub(in crate::scan) fn new(corners: [Vector<L>; 3], reach: L, rounding: f32) -> TriangleTest<L> {
        let [a, b, c] = corners;
        // The two shorter edges: the difference of two long products is no more exact than they are.
        let (ab, bc) = (b - a, c - b);
        let normal = ab.cross(bc);
        let height = normal.dot(b);
        let size = (ab.dot(ab) * bc.dot(bc)).sqrt();
        // Edge-on, the visible side is unknown: then everything around it is unresolved.
        let known = height.abs().gt(size * reach * L::splat(8.0 * rounding));
        let (zero, one, unbounded) = (L::splat(0.0), L::splat(1.0), L::splat(UNBOUNDED));
        let inverse = L::select(known, one / height, zero);
        let ([x, y, z], longest) = edges(corners, one.copysign(height));
        let scale = size * inverse.abs() * L::splat(4.0 * rounding);
        TriangleTest {
            rows: [x, y, z, normal * inverse],
            edge_error: L::select(known, reach * longest * L::splat(8.0 * rounding), unbounded),
            plane_error: L::select(known, scale, unbounded),
            height_error: scale * reach,
        }
    }

    /// Whether the triangle with these corners certainly points away from all rays that start within `shift` of the
    /// test's.
    #[inline(always)]
    pub(in crate::scan) fn looks_away(&self, [a, b, c]: &[Vector<L>; 3], shift: f32) -> L::Mask {
        let normal = (*b - *a).cross(*c - *b);
        let known = L::splat(UNBOUNDED).gt(self.edge_error);
        known & normal.dot(*b).gt(normal.length() * L::splat(1.01 * shift))
    }

    /// The products of the rows with (x, y, slope).
    #[inline(always)]
    pub(in crate::scan) fn products(&self, x: L, y: L, slope: L) -> [L; 4] {
        let [a, b, c, d] = &self.rows;
        [
            a.z.mul_add(slope, a.x.mul_add(x, a.y * y)),
            b.z.mul_add(slope, b.x.mul_add(x, b.y * y)),
            c.z.mul_add(slope, c.x.mul_add(x, c.y * y)),
            d.z.mul_add(slope, d.x.mul_add(x, d.y * y)),
        ]
    }
}

impl<L: Lanes> RayTest<L> for TriangleTest<L> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn upper_bounds(&self, d: [L; 4]) -> (L, L) {
        (d[3].abs().mul_add(self.height_error, d[3] + self.plane_error), d[0].min(d[1]).min(d[2]) + self.edge_error)
    }

    #[inline(always)]
    fn resolved(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        let within = d[0].min(d[1]).min(d[2]).gt(self.edge_error);
        (d[3], within & tolerance.allowed_error(d[3]).ge(d[3].mul_add(self.height_error, self.plane_error)))
    }

    /// Each edge function is linear in the slope: it enters or leaves its error band around 0 at one slope.
    #[inline(always)]
    fn slopes(&self, along: &[L; 4], rise: &[L; 4]) -> Option<(L, L)> {
        let (mut low, mut high) = (L::splat(-UNBOUNDED), L::splat(UNBOUNDED));
        for edge in 0..3 {
            let slope = -((along[edge] + self.edge_error) / rise[edge]);
            low = L::select(rise[edge].gt(L::splat(0.0)), low.max(slope), low);
            high = L::select(L::splat(0.0).gt(rise[edge]), high.min(slope), high);
        }
        Some((low, high))
    }
}
