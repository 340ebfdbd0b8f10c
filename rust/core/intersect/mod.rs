//! The ray-shape tests, each written once.
//!
//! Both sides of every surface are seen, and a ray that starts inside a body hits the far side. A distance is greater than
//! 0: a surface that a ray starts on is not hit there.

mod cuboid;
mod cylinder;
mod ellipsoid;
mod ray;
mod rectangle;
mod triangle;

use glam::{DVec2, DVec3};

use crate::Bounds;

pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use ellipsoid::Ellipsoid;
pub use ray::{Hit, Ray};
pub use rectangle::Rectangle;
pub use triangle::Triangle;

/// Where an upright shape stands: moved, and turned about z.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Upright {
    center: DVec3,
    /// (cos, sin) of the yaw.
    turn: DVec2,
}

impl Upright {
    fn new(center: DVec3, yaw: f64) -> Upright {
        let turn = DVec2::from_angle(yaw);
        Upright { center, turn }
    }

    /// A ray's origin and direction as the shape sees them.
    fn inward(&self, ray: &Ray) -> (DVec3, DVec3) {
        let inverse = DVec2::new(self.turn.x, -self.turn.y);
        let back = |v: DVec3| inverse.rotate(v.truncate()).extend(v.z);
        (back(ray.origin - self.center), back(ray.direction))
    }

    /// A vector of the shape as the scene sees it.
    fn outward(&self, vector: DVec3) -> DVec3 {
        self.turn.rotate(vector.truncate()).extend(vector.z)
    }

    /// Bounds of the box with these half extents.
    fn bounds_of_box(&self, half: DVec3) -> Bounds {
        let turn = self.turn.abs();
        let x = turn.x * half.x + turn.y * half.y;
        let y = turn.y * half.x + turn.x * half.y;
        Bounds::around(self.center, DVec3::new(x, y, half.z))
    }

    /// Bounds of a body with these half extents whose outline from above is an ellipse.
    fn bounds_of_ellipse(&self, half: DVec3) -> Bounds {
        let x = (self.turn * half.truncate()).length();
        let y = (self.turn.perp() * half.truncate()).length();
        Bounds::around(self.center, DVec3::new(x, y, half.z))
    }

    /// By how much flat faces are grown, so that faces which meet on paper leave no gap after rounding.
    fn slack(&self, half: DVec3) -> f64 {
        8.0 * f64::EPSILON * (self.center.abs() + half).element_sum()
    }
}

/// A crossing of a ray with the surface of a convex body: the distance, and the outward normal there.
type Crossing = (f64, DVec3);

/// The part of a ray inside the intersection of two convex bodies.
fn narrow(a: (Crossing, Crossing), b: (Crossing, Crossing)) -> (Crossing, Crossing) {
    let enter = if b.0.0 > a.0.0 { b.0 } else { a.0 };
    let exit = if b.1.0 < a.1.0 { b.1 } else { a.1 };
    (enter, exit)
}

/// The first crossing in front of the origin, given where the line enters and leaves a body.
fn first((enter, exit): (Crossing, Crossing)) -> Option<Crossing> {
    let passes = enter.0 <= exit.0;
    let ahead = if enter.0 > 0.0 { enter } else { exit };
    (passes && ahead.0 > 0.0).then_some(ahead)
}

/// The part of a ray between two parallel planes at `-half` and `half` of one axis; `None` if it runs beside them.
fn slab(axis: usize, origin: f64, direction: f64, half: f64) -> Option<(Crossing, Crossing)> {
    let normal = DVec3::AXES[axis] * direction.signum();
    if direction == 0.0 {
        let inside = origin.abs() <= half;
        return inside.then_some(((f64::NEG_INFINITY, -normal), (f64::INFINITY, normal)));
    }
    let (a, b) = ((-half - origin) / direction, (half - origin) / direction);
    Some(((a.min(b), -normal), (a.max(b), normal)))
}

/// The distances at which a line crosses the unit circle or the unit sphere; `None` if it passes by.
///
/// The discriminant is taken from the point of the line nearest to the centre, and the smaller root from the product of
/// both, so that neither cancels for a small body far away: Haines et al., "Precision Improvements for Ray/Sphere
/// Intersection", Ray Tracing Gems, 2019, chapter 7.
fn unit_ball(origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let a = direction.length_squared();
    let b = -origin.dot(direction);
    let discriminant = 1.0 - (origin + direction * (b / a)).length_squared();
    if discriminant.is_nan() || discriminant < 0.0 {
        return None;
    }
    let q = b + (a * discriminant).sqrt().copysign(b);
    let distance = origin.length();
    let c = (distance - 1.0) * (distance + 1.0);
    let (near, far) = (c / q, q / a);
    (q != 0.0).then(|| (near.min(far), near.max(far)))
}
