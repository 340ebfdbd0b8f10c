//! Ray against rectangle.

use glam::{DVec2, DVec3};

use super::Ray;

/// A rectangle in the plane z = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Half of its extents [m].
    pub half: DVec2,
}

impl Rectangle {
    /// The rectangle with every edge moved outwards.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Rectangle {
        Rectangle { half: self.half + margin }
    }

    /// The distance at which a ray crosses the rectangle, edges included. A ray that starts in its plane misses it.
    pub fn intersect(&self, ray: &Ray, slack: f64) -> Option<f64> {
        let distance = -ray.origin.z / ray.direction.z;
        let point = ray.at(distance).abs();
        (distance > 0.0 && ray.origin.z.abs() > slack && point.x <= self.half.x && point.y <= self.half.y)
            .then_some(distance)
    }

    /// Its unit normal.
    pub fn normal(&self) -> DVec3 {
        DVec3::Z
    }
}
