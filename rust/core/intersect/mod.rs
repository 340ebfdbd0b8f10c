//! The ray-shape tests, each written once, in the frame of the shape, without translation and rotation.
//!
//! Both sides of every surface count, and a ray that starts inside a body hits the far side. A distance is greater than
//! 0: a surface at the start of a ray is not hit there. `slack` is the largest shift of the start from it by rounding
//! [m]. Normals are computed only on request, for the point that was hit.

mod cuboid;
mod cylinder;
mod ellipsoid;
mod ray;
mod rectangle;
mod triangle;

use glam::DVec3;

pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use ellipsoid::Ellipsoid;
pub use ray::{Hit, Ray, ShearedRay};
pub use rectangle::Rectangle;
pub use triangle::Triangle;

/// The distances at which a line enters and leaves a convex body.
pub type Span = (f64, f64);

/// The part of a line inside the intersection of two convex bodies.
fn narrow(a: Span, b: Span) -> Span {
    (if b.0 > a.0 { b.0 } else { a.0 }, if b.1 < a.1 { b.1 } else { a.1 })
}

/// The first crossing in front of the origin, from the distances at which the line enters and leaves a body.
fn first((enter, exit): Span) -> Option<f64> {
    let ahead = if enter > 0.0 { enter } else { exit };
    (enter <= exit && ahead > 0.0).then_some(ahead)
}

/// The first interaction of a ray with a medium that fills convex bodies, from the distances at which it enters and
/// leaves them, in order, and its free path; `None` if it leaves the last one before.
pub(crate) fn first_interaction(spans: impl IntoIterator<Item = Span>, path: f64) -> Option<f64> {
    let mut left = path;
    for (enter, exit) in spans {
        let from = enter.max(0.0);
        if from + left < exit {
            return Some(from + left);
        }
        left -= (exit - from).max(0.0);
    }
    None
}

/// The part of a line between two parallel planes at `-half` and `half` of one axis; `None` if it passes beside them. A
/// line that starts on one of them, within `slack`, meets it at 0.
fn slab(origin: f64, direction: f64, half: f64, slack: f64) -> Option<Span> {
    let origin = if (origin.abs() - half).abs() <= slack { half.copysign(origin) } else { origin };
    if direction == 0.0 {
        return (origin.abs() <= half).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (a, b) = ((-half - origin) / direction, (half - origin) / direction);
    Some((a.min(b), a.max(b)))
}

/// A start further away from the unit ball than this is not on it, however thin the scaled body is.
const LARGEST_SLACK: f64 = 1e-6;

/// The distances at which a line crosses the unit circle or the unit sphere; `None` if it passes by. A line that starts
/// on it, within `slack`, crosses it at 0.
///
/// The discriminant is computed at the point of the line nearest to the centre, and the smaller root from the product
/// of both, so that neither cancels for a small body far away: Haines et al., "Precision Improvements for Ray/Sphere
/// Intersection", Ray Tracing Gems, 2019, chapter 7.
fn unit_ball(origin: DVec3, direction: DVec3, slack: f64) -> Option<Span> {
    let a = direction.length_squared();
    let b = -origin.dot(direction);
    let distance = origin.length();
    let slack = slack.min(LARGEST_SLACK);
    if (distance - 1.0).abs() <= slack {
        // For a line along the surface, rounding makes no second crossing either.
        let other = if b.abs() > slack * a.sqrt() { 2.0 * b / a } else { 0.0 };
        return Some((other.min(0.0), other.max(0.0)));
    }
    let discriminant = 1.0 - (origin + direction * (b / a)).length_squared();
    if discriminant.is_nan() || discriminant < 0.0 {
        return None;
    }
    let q = b + (a * discriminant).sqrt().copysign(b);
    let c = (distance - 1.0) * (distance + 1.0);
    let (near, far) = (c / q, q / a);
    (q != 0.0).then(|| (near.min(far), near.max(far)))
}
