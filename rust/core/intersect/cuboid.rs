//! Ray against box.

use glam::DVec3;

use super::{Ray, Span, first, narrow, slab};

/// A box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Half of its extents [m].
    pub half: DVec3,
}

impl Cuboid {
    /// The box with every face moved outwards.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Cuboid {
        Cuboid { half: self.half + margin }
    }

    /// The distance at which a ray enters the box, or leaves it if it starts inside.
    pub fn intersect(&self, ray: &Ray, slack: f64) -> Option<f64> {
        first(self.span(ray, slack)?)
    }

    /// The part of a line inside the box: Kay and Kajiya, "Ray Tracing Complex Scenes", 1986. Its end is before its
    /// start if the line passes by.
    pub fn span(&self, ray: &Ray, slack: f64) -> Option<Span> {
        let Ray { origin, direction } = ray;
        let x = slab(origin.x, direction.x, self.half.x, slack)?;
        let y = slab(origin.y, direction.y, self.half.y, slack)?;
        let z = slab(origin.z, direction.z, self.half.z, slack)?;
        Some(narrow(narrow(x, y), z))
    }

    /// The outward unit normal of the face with a point of the surface: the relatively nearest one.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let axis = (point / self.half).abs().max_position();
        DVec3::AXES[axis] * point[axis].signum()
    }
}
