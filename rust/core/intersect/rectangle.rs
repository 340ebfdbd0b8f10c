//! Ray against rectangle.

use glam::DVec3;

use super::{Hit, Ray, Upright};
use crate::Bounds;

/// A level rectangle that may be turned about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    place: Upright,
    half: DVec3,
}

impl Rectangle {
    /// A rectangle with the full extents `size.x` and `size.y` around `center`; `size.z` is not looked at.
    pub fn new(center: DVec3, size: DVec3, yaw: f64) -> Rectangle {
        let place = Upright::new(center, yaw);
        let flat = DVec3::new(size.x, size.y, 0.0) / 2.0;
        let slack = place.slack(flat);
        let half = flat + DVec3::new(slack, slack, 0.0);
        Rectangle { place, half }
    }

    /// Where a ray crosses the rectangle, edges included. A ray in its plane does not see it.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let (origin, direction) = self.place.inward(ray);
        let distance = -origin.z / direction.z;
        let point = (origin + direction * distance).abs();
        (distance > 0.0 && point.x <= self.half.x && point.y <= self.half.y)
            .then_some(Hit { distance, normal: DVec3::Z })
    }

    /// Its bounds.
    pub fn bounds(&self) -> Bounds {
        self.place.bounds_of_box(self.half)
    }
}
