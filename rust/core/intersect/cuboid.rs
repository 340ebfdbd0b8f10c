//! Ray against box.

use glam::DVec3;

use super::{Hit, Ray, Upright, first, narrow, slab};
use crate::Bounds;

/// A box that may be turned about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    place: Upright,
    half: DVec3,
}

impl Cuboid {
    /// A box with these full extents around `center`.
    pub fn new(center: DVec3, size: DVec3, yaw: f64) -> Cuboid {
        let place = Upright::new(center, yaw);
        let half = size / 2.0 + place.slack(size / 2.0);
        Cuboid { place, half }
    }

    /// Where a ray enters the box, or leaves it if it starts inside: Kay and Kajiya, "Ray Tracing Complex Scenes", 1986.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let (origin, direction) = self.place.inward(ray);
        let x = slab(0, origin.x, direction.x, self.half.x)?;
        let y = slab(1, origin.y, direction.y, self.half.y)?;
        let z = slab(2, origin.z, direction.z, self.half.z)?;
        let (distance, normal) = first(narrow(narrow(x, y), z))?;
        Some(Hit { distance, normal: self.place.outward(normal) })
    }

    /// Its bounds.
    pub fn bounds(&self) -> Bounds {
        self.place.bounds_of_box(self.half)
    }
}
