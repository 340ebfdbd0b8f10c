//! Rays and their hits.

use glam::DVec3;

/// A half line. Distances along it are multiples of the length of `direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Its start; finite.
    pub origin: DVec3,
    /// Its direction; finite and not 0.
    pub direction: DVec3,
}

/// The hit of a ray on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The distance along the ray, greater than 0.
    pub distance: f64,
    /// The triangle of a mesh; 0 for every other body.
    pub part: u32,
}

/// A ray prepared for many triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearedRay {
    pub(super) origin: DVec3,
    /// The order of the axes in which the longest component of the direction is the third and handedness is kept.
    axes: [usize; 3],
    /// Shear and scale that turn the direction into (0, 0, 1) of those axes.
    shear: DVec3,
}

impl Ray {
    /// The point at a distance.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }

    /// The ray in the form for [`Triangle::intersect`](super::Triangle::intersect).
    pub fn sheared(&self) -> ShearedRay {
        let direction = self.direction;
        let longest = direction.abs().max_position();
        let (mut x, mut y) = ((longest + 1) % 3, (longest + 2) % 3);
        if direction[longest] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let scale = 1.0 / direction[longest];
        let shear = DVec3::new(direction[x] * scale, direction[y] * scale, scale);
        ShearedRay { origin: self.origin, axes: [x, y, longest], shear }
    }
}

impl ShearedRay {
    /// A point in the frame in which the ray starts at 0 along z: Woop, Benthin and Wald, "Watertight Ray/Triangle
    /// Intersection", JCGT 2(1), 2013. The same point gives the same bits for all of its triangles.
    pub(super) fn shear(&self, point: DVec3) -> DVec3 {
        let p = (point - self.origin).to_array();
        let [x, y, z] = self.axes.map(|axis| p[axis]);
        DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
    }
}
