//! Ray against ellipsoid.

use glam::DVec3;

use super::{Ray, Span, first, unit_ball};

/// An ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Its radii [m].
    pub radii: DVec3,
}

impl Ellipsoid {
    /// The distance at which a ray enters the ellipsoid, or leaves it if it starts inside.
    pub fn intersect(&self, ray: &Ray, slack: f64) -> Option<f64> {
        first(self.span(ray, slack)?)
    }

    /// The part of a line inside the ellipsoid.
    pub fn span(&self, ray: &Ray, slack: f64) -> Option<Span> {
        unit_ball(ray.origin / self.radii, ray.direction / self.radii, slack / self.radii.min_element())
    }

    /// The outward unit normal at a point of the surface: the gradient, scaled so that no radius is too small for it.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        (point / self.radii * (self.radii.min_element() / self.radii)).normalize_or_zero()
    }
}
