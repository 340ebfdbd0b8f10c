//! Primitives: the parts of a scene.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::body::{Body, MeshBody, Solid};
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Rectangle};
use crate::{Bounds, Error, Pose, Result, TriangleMesh};

/// The shape of a primitive before it is scaled, rotated and moved.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// The box [-1/2, 1/2]^3.
    Box,
    /// The ball in that box.
    Ellipsoid,
    /// The closed cylinder in that box, with axis z.
    Cylinder,
    /// The square z = 0 of that box.
    Plane,
    /// Triangles in that box.
    Mesh(TriangleMesh),
}

/// A shape scaled by `size`, rotated by `yaw` about z and moved to `center`.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// The unit shape.
    pub shape: Shape,
    /// Its middle [m].
    pub center: [f64; 3],
    /// Full extents [m]; greater than 0, but 0 in z for a plane, and not all 0 for a mesh.
    pub size: [f64; 3],
    /// Its rotation about z [rad].
    pub yaw: f64,
    /// Its class.
    pub label: u8,
    /// Its instance.
    pub instance: u32,
    /// `None` if it is solid; else it is a medium: rays travel 1 / extinction [m] in it on average, and may leave it.
    pub extinction: Option<f64>,
}

/// Coordinates and extents beyond this [m] would overflow areas in f32.
const FURTHEST: f64 = 1e9;

impl Primitive {
    /// Checks everything except the mesh itself; `primitive` is its index, for the message.
    pub(crate) fn check(&self, primitive: usize) -> Result<()> {
        let limit = FURTHEST;
        if !self.center.iter().all(|x| x.abs() <= limit) {
            let value = self.center;
            return Err(Error::Center { primitive, value, limit });
        }
        let positive = self.size.map(|x| x > 0.0);
        let (fits, rule) = match self.shape {
            Shape::Plane => (positive == [true, true, false], "a plane has x > 0, y > 0 and z = 0"),
            Shape::Mesh(_) => (positive.contains(&true), "extents of a mesh are >= 0 and not all 0"),
            _ => (positive == [true; 3], "every extent must be > 0"),
        };
        if !fits || !self.size.iter().all(|x| (0.0..=limit).contains(x)) {
            let value = self.size;
            return Err(Error::Size { primitive, value, rule, limit });
        }
        if !self.yaw.is_finite() {
            let value = self.yaw;
            return Err(Error::Yaw { primitive, value });
        }
        self.check_medium(primitive)?;
        self.check_reach(primitive)
    }

    fn check_medium(&self, primitive: usize) -> Result<()> {
        let Some(value) = self.extinction else {
            return Ok(());
        };
        if !(value > 0.0 && value.is_finite()) {
            return Err(Error::Extinction { primitive, value });
        }
        match &self.shape {
            Shape::Plane => Err(Error::PlaneMedium { primitive }),
            Shape::Mesh(mesh) => match mesh.open_edge() {
                Some([from, to]) => Err(Error::OpenMedium { primitive, from, to }),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    fn check_reach(&self, primitive: usize) -> Result<()> {
        let Shape::Mesh(mesh) = &self.shape else {
            return Ok(());
        };
        let limit = FURTHEST;
        let size = DVec3::from(self.size);
        let scaled = mesh.vertices().iter().map(|&v| (DVec3::from(v) * size).to_array());
        match scaled.enumerate().find(|(_, v)| !v.iter().all(|x| x.abs() <= limit)) {
            Some((vertex, value)) => Err(Error::MeshReach { primitive, vertex, value, limit }),
            None => Ok(()),
        }
    }

    /// Bounds of the primitive; exact only without rotation, which is enough to find a middle.
    pub(crate) fn bounds(&self) -> Bounds {
        let center = DVec3::from(self.center);
        match &self.shape {
            Shape::Mesh(mesh) => {
                let size = DVec3::from(self.size);
                let corners = mesh.vertices().iter().map(|&v| DVec3::from(v) * size);
                let reach = corners.fold(DVec3::ZERO, |all, v| all.max(v.abs()));
                Bounds::around(center, reach)
            }
            _ => Bounds::around(center, DVec3::from(self.size) / 2.0),
        }
    }

    /// The body, relative to the origin of the scene.
    pub(crate) fn body(self, origin: DVec3) -> Body {
        let size = DVec3::from(self.size);
        let half = size / 2.0;
        let solid = match self.shape {
            Shape::Box => Solid::Cuboid(Cuboid { half }),
            Shape::Ellipsoid => Solid::Ellipsoid(Ellipsoid { radii: half }),
            Shape::Cylinder => Solid::Cylinder(Cylinder { half }),
            Shape::Plane => Solid::Rectangle(Rectangle { half: half.truncate() }),
            Shape::Mesh(mesh) => Solid::Mesh(Arc::new(MeshBody::new(mesh, size))),
        };
        let rotation = DMat3::from_rotation_z(self.yaw);
        Body::new(solid, Pose { rotation, translation: DVec3::from(self.center) - origin }, self.extinction)
    }
}
