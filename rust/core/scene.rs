//! Scenes: shapes with a pose, a class and an instance, compiled for casting.

use glam::DVec3;

use crate::bvh::Bvh;
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Hit, Ray, Rectangle, Triangle};
use crate::{Bounds, Error, Result, TriangleMesh};

/// What a primitive looks like before it is scaled, turned and moved.
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

/// A shape scaled by `size`, turned by `yaw` about z and moved to `center`.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// The unit shape.
    pub shape: Shape,
    /// Its middle [m].
    pub center: [f64; 3],
    /// Full extents [m]; greater than 0, but 0 in z for a plane, and not all 0 for a mesh.
    pub size: [f64; 3],
    /// Its turn about z [rad].
    pub yaw: f64,
    /// Its class.
    pub label: u8,
    /// Its instance.
    pub instance: u32,
}

/// The closest surface along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// The distance and the normal.
    pub hit: Hit,
    /// The index of the primitive.
    pub primitive: usize,
    /// Its class.
    pub label: u8,
    /// Its instance.
    pub instance: u32,
}

/// Primitives compiled for casting.
///
/// Everything is kept relative to `origin`, the middle of the scene, so that a scene in map coordinates of a million metres
/// is as precise as one around 0.
pub struct Scene {
    origin: DVec3,
    surfaces: Vec<Surface>,
    /// The primitive of each surface; ascending, so that the lower surface is of the lower primitive.
    owners: Vec<u32>,
    /// Class and instance of each primitive.
    semantics: Vec<(u8, u32)>,
    bvh: Bvh,
}

/// What a ray can hit: a whole analytic shape, or one triangle of a mesh.
enum Surface {
    Cuboid(Cuboid),
    Ellipsoid(Ellipsoid),
    Cylinder(Cylinder),
    Rectangle(Rectangle),
    Triangle(Triangle),
}

/// Coordinates and extents beyond this [m] would overflow areas in f32.
const FURTHEST: f64 = 1e9;

impl Scene {
    /// A scene; it may be empty.
    ///
    /// # Errors
    /// [`Error::Center`], [`Error::Size`], [`Error::Yaw`] or [`Error::MeshReach`].
    pub fn new(primitives: Vec<Primitive>) -> Result<Scene> {
        for (index, primitive) in primitives.iter().enumerate() {
            primitive.check(index)?;
        }
        let bounds = primitives.iter().fold(Bounds::EMPTY, |all, p| all.union(p.bounds()));
        let origin = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        let (mut surfaces, mut owners) = (Vec::new(), Vec::new());
        for (index, primitive) in primitives.iter().enumerate() {
            primitive.compile(origin, &mut surfaces);
            owners.resize(surfaces.len(), index as u32);
        }
        let boxes: Vec<Bounds> = surfaces.iter().map(Surface::bounds).collect();
        Ok(Scene {
            origin,
            surfaces,
            owners,
            semantics: primitives.iter().map(|p| (p.label, p.instance)).collect(),
            bvh: Bvh::new(&boxes),
        })
    }

    /// The closest surface along a ray; of two whose distances are the same in f32, the one with the lower index.
    ///
    /// Origin and direction must be finite, and the direction not 0; it need not have the length 1.
    pub fn closest(&self, origin: DVec3, direction: DVec3) -> Option<SceneHit> {
        let ray = Ray::new(origin - self.origin, direction);
        let (surface, hit) = self.bvh.closest(&ray, |i| self.surfaces[i].intersect(&ray))?;
        Some(self.scene_hit(surface, hit))
    }

    /// The same by asking every surface: the definition that the hierarchy is tested against.
    #[cfg(test)]
    pub(crate) fn closest_of_all(&self, origin: DVec3, direction: DVec3) -> Option<SceneHit> {
        let ray = Ray::new(origin - self.origin, direction);
        let hits = self.surfaces.iter().enumerate();
        let (surface, hit) = hits
            .filter_map(|(i, surface)| Some((i, surface.intersect(&ray)?)))
            .min_by(|a, b| (a.1.distance as f32).total_cmp(&(b.1.distance as f32)))?;
        Some(self.scene_hit(surface, hit))
    }

    fn scene_hit(&self, surface: usize, hit: Hit) -> SceneHit {
        let primitive = self.owners[surface] as usize;
        let (label, instance) = self.semantics[primitive];
        SceneHit { hit, primitive, label, instance }
    }
}

impl Primitive {
    fn check(&self, primitive: usize) -> Result<()> {
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
        self.check_reach(primitive)
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

    /// Bounds of the primitive; exact only for what is not turned, which is enough to find a middle.
    fn bounds(&self) -> Bounds {
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

    /// Appends the surfaces of the primitive, relative to `origin`.
    fn compile(&self, origin: DVec3, surfaces: &mut Vec<Surface>) {
        let center = DVec3::from(self.center) - origin;
        let size = DVec3::from(self.size);
        match &self.shape {
            Shape::Box => surfaces.push(Surface::Cuboid(Cuboid::new(center, size, self.yaw))),
            Shape::Ellipsoid => {
                surfaces.push(Surface::Ellipsoid(Ellipsoid::new(center, size, self.yaw)));
            }
            Shape::Cylinder => {
                surfaces.push(Surface::Cylinder(Cylinder::new(center, size, self.yaw)));
            }
            Shape::Plane => {
                surfaces.push(Surface::Rectangle(Rectangle::new(center, size, self.yaw)));
            }
            Shape::Mesh(mesh) => surfaces.extend(triangles(mesh, center, size, self.yaw)),
        }
    }
}

/// The triangles of a placed mesh. A shared vertex gets the same bits in each of them, which watertightness rests on.
fn triangles(mesh: &TriangleMesh, center: DVec3, size: DVec3, yaw: f64) -> Vec<Surface> {
    let turn = glam::DVec2::from_angle(yaw);
    let place = |v: &[f64; 3]| {
        let v = DVec3::from(*v) * size;
        turn.rotate(v.truncate()).extend(v.z) + center
    };
    let vertices: Vec<DVec3> = mesh.vertices().iter().map(place).collect();
    let corners = |face: &[u32; 3]| face.map(|v| vertices[v as usize]);
    mesh.faces().iter().map(|face| Surface::Triangle(Triangle { corners: corners(face) })).collect()
}

impl Surface {
    fn intersect(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Surface::Cuboid(shape) => shape.intersect(ray),
            Surface::Ellipsoid(shape) => shape.intersect(ray),
            Surface::Cylinder(shape) => shape.intersect(ray),
            Surface::Rectangle(shape) => shape.intersect(ray),
            Surface::Triangle(shape) => shape.intersect(ray),
        }
    }

    fn bounds(&self) -> Bounds {
        match self {
            Surface::Cuboid(shape) => shape.bounds(),
            Surface::Ellipsoid(shape) => shape.bounds(),
            Surface::Cylinder(shape) => shape.bounds(),
            Surface::Rectangle(shape) => shape.bounds(),
            Surface::Triangle(shape) => shape.bounds(),
        }
    }
}
