//! Ray against cylinder.

use glam::DVec3;

use super::{Ray, Span, first, narrow, slab, unit_ball};

/// A closed cylinder over an ellipse, with axis z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// The radii along x and y, and half of the height [m].
    pub half: DVec3,
}

impl Cylinder {
    /// The distance at which a ray enters the cylinder, or leaves it if it starts inside; side and caps.
    pub fn intersect(&self, ray: &Ray, slack: f64) -> Option<f64> {
        first(self.span(ray, slack)?)
    }

    /// The part of a line inside the cylinder; its end is before its start if the line passes by.
    pub fn span(&self, ray: &Ray, slack: f64) -> Option<Span> {
        let caps = slab(ray.origin.z, ray.direction.z, self.half.z, slack)?;
        Some(narrow(caps, self.side(ray, slack)?))
    }

    /// The part of a ray inside the endless cylinder.
    fn side(&self, ray: &Ray, slack: f64) -> Option<Span> {
        let radii = self.half.truncate();
        let (o, d) = (ray.origin.truncate() / radii, ray.direction.truncate() / radii);
        // A vertical ray, or one that rises more than 1e100 times as fast as it moves.
        if d.length_squared() < 1e-200 {
            return (o.length_squared() <= 1.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
        }
        unit_ball(o.extend(0.0), d.extend(0.0), slack / radii.min_element())
    }

    /// The outward unit normal at a point of the surface: of the cap or the side, the relatively nearest one.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let relative = point / self.half;
        let across = relative.truncate();
        if relative.z.abs() >= across.length() {
            return DVec3::Z * point.z.signum();
        }
        let radii = self.half.truncate();
        (across * (radii.min_element() / radii)).extend(0.0).normalize_or_zero()
    }
}
