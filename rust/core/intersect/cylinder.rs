//! Ray against cylinder.

use glam::DVec3;

use super::{Crossing, Hit, Ray, Upright, first, narrow, slab, unit_ball};
use crate::Bounds;

/// A closed upright cylinder over an ellipse that may be turned about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    place: Upright,
    half: DVec3,
}

impl Cylinder {
    /// The cylinder in the box with these full extents around `center`.
    pub fn new(center: DVec3, size: DVec3, yaw: f64) -> Cylinder {
        let place = Upright::new(center, yaw);
        let half = size / 2.0;
        Cylinder { place, half }
    }

    /// Where a ray enters the cylinder, or leaves it if it starts inside; side and caps.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let (origin, direction) = self.place.inward(ray);
        let caps = slab(2, origin.z, direction.z, self.half.z)?;
        let side = self.side(origin, direction)?;
        let (distance, normal) = first(narrow(caps, side))?;
        Some(Hit { distance, normal: self.place.outward(normal).normalize_or_zero() })
    }

    /// The part of a ray inside the endless cylinder.
    fn side(&self, origin: DVec3, direction: DVec3) -> Option<(Crossing, Crossing)> {
        let radii = self.half.truncate();
        let (o, d) = (origin.truncate() / radii, direction.truncate() / radii);
        // A vertical ray, or one that rises more than 1e100 times as fast as it moves.
        if d.length_squared() < 1e-200 {
            let inside = o.length_squared() <= 1.0;
            return inside.then_some(((f64::NEG_INFINITY, DVec3::Z), (f64::INFINITY, DVec3::Z)));
        }
        let (near, far) = unit_ball(o.extend(0.0), d.extend(0.0))?;
        let normal = |t: f64| ((o + d * t) / radii).extend(0.0);
        Some(((near, normal(near)), (far, normal(far))))
    }

    /// Its bounds.
    pub fn bounds(&self) -> Bounds {
        self.place.bounds_of_ellipse(self.half)
    }
}
