//! Ray against triangle.

use glam::DVec3;

use super::ShearedRay;
use crate::Bounds;

/// A triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Its corners.
    pub corners: [DVec3; 3],
}

impl Triangle {
    /// The distance at which a ray meets the triangle, corners and edges included.
    ///
    /// Watertight: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. Rounding is
    /// monotone, so an edge function keeps its sign or becomes 0, and 0 counts as inside. Two triangles that share an
    /// edge compute exactly opposite values for it, because nothing here is fused. So no ray slips between them.
    pub fn intersect(&self, ray: &ShearedRay, slack: f64) -> Option<f64> {
        let [a, b, c] = self.corners.map(|corner| ray.shear(corner));
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        // Edge-on to the ray; the triangles beside it cover the ray.
        if determinant == 0.0 {
            return None;
        }
        let distance = (u * a.z + v * b.z + w * c.z) / determinant;
        (distance > 0.0 && !self.is_at(ray.origin, slack)).then_some(distance)
    }

    /// Whether a point is in the bounds and the plane of the triangle: to a ray from there it is edge-on, if visible at
    /// all.
    fn is_at(&self, point: DVec3, slack: f64) -> bool {
        self.bounds().grown(slack).contains(point) && (point - self.corners[0]).dot(self.normal()).abs() <= slack
    }

    /// The distance at which a ray crosses the triangle, and whether the corners are counter-clockwise from its start.
    ///
    /// As [`Triangle::intersect`], but a ray through an edge crosses exactly one of the triangles that share it, as if
    /// it were beside the edge by an infinitesimal distance: Edelsbrunner and Muecke, "Simulation of Simplicity", 1990.
    /// So the crossings of a closed mesh separate inside from outside.
    pub fn crossing(&self, ray: &ShearedRay) -> Option<(f64, bool)> {
        let [a, b, c] = self.corners.map(|corner| ray.shear(corner));
        let edges = [side(c, b), side(a, c), side(b, a)];
        let front = edges[0].1;
        if edges.iter().any(|edge| edge.1 != front) {
            return None;
        }
        let [u, v, w] = edges.map(|edge| edge.0);
        let distance = (u * a.z + v * b.z + w * c.z) / (u + v + w);
        (distance > 0.0).then_some((distance, front))
    }

    /// The unit normal on the side from which the corners run counter-clockwise; 0 if the triangle has no area.
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// The bounds of the corners.
    pub fn bounds(&self) -> Bounds {
        let [a, b, c] = self.corners;
        Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
    }
}

/// The edge function of two sheared corners, and whether it is positive for a ray that starts at (e, e^2) with an
/// infinitesimal e.
fn side(p: DVec3, q: DVec3) -> (f64, bool) {
    let area = p.x * q.y - p.y * q.x;
    let beside = if p.y == q.y { q.x - p.x } else { p.y - q.y };
    (area, if area == 0.0 { beside > 0.0 } else { area > 0.0 })
}
