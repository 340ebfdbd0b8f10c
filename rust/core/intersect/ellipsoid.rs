//! Ray against ellipsoid.

use glam::DVec3;

use super::{Hit, Ray, Upright, first, unit_ball};
use crate::Bounds;

/// An ellipsoid that may be turned about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    place: Upright,
    radii: DVec3,
}

impl Ellipsoid {
    /// The ellipsoid in the box with these full extents around `center`.
    pub fn new(center: DVec3, size: DVec3, yaw: f64) -> Ellipsoid {
        let place = Upright::new(center, yaw);
        let radii = size / 2.0;
        Ellipsoid { place, radii }
    }

    /// Where a ray enters the ellipsoid, or leaves it if it starts inside.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let (origin, direction) = self.place.inward(ray);
        let (origin, direction) = (origin / self.radii, direction / self.radii);
        let (near, far) = unit_ball(origin, direction)?;
        let normal = |t: f64| (origin + direction * t) / self.radii;
        let (distance, normal) = first(((near, normal(near)), (far, normal(far))))?;
        Some(Hit { distance, normal: self.place.outward(normal).normalize_or_zero() })
    }

    /// Its bounds.
    pub fn bounds(&self) -> Bounds {
        self.place.bounds_of_ellipse(self.radii)
    }
}
