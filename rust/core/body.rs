//! Bodies: a solid in its own frame, and the pose of that frame in the scene.

use std::sync::{Arc, OnceLock};

use glam::{DMat3, DVec3, Vec3};

use crate::bvh::Bvh;
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Hit, Ray, Rectangle, Span, Triangle, first_interaction};
use crate::packed::{Meshlets, Obb, Outline};
use crate::{Bounds, Pose, TriangleMesh};

/// The solid of a body, in its own frame.
#[derive(Clone)]
pub(crate) enum Solid {
    Cuboid(Cuboid),
    Ellipsoid(Ellipsoid),
    Cylinder(Cylinder),
    Rectangle(Rectangle),
    /// Shared with the scenes from which this one was moved.
    Mesh(Arc<MeshBody>),
}

/// A scaled mesh. The parts that few scans need are made on first use.
pub(crate) struct MeshBody {
    /// Positions in the frame of the body [m]. Each is stored once; watertightness relies on that.
    pub(crate) vertices: Vec<DVec3>,
    /// The vertex numbers of each triangle.
    pub(crate) faces: Vec<[u32; 3]>,
    bvh: OnceLock<Bvh>,
    normals: OnceLock<Vec<[f32; 3]>>,
    /// The triangles as the scan kernel reads them.
    pub(crate) meshlets: Meshlets,
    /// Whether rays from outside certainly meet a face towards them before one away from them.
    pub(crate) outward: bool,
    /// The box around them in the frame of the body.
    pub(crate) bounds: Bounds,
}

/// A solid at its pose.
#[derive(Clone)]
pub(crate) struct Body {
    /// In the frame of the scene. Rigid, so that distances along a ray stay the same.
    pub(crate) pose: Pose,
    pub(crate) solid: Solid,
    /// The extinction of a medium [1/m].
    pub(crate) extinction: Option<f64>,
    /// The largest shift of a surface point by rounding [m]. Flat faces are grown by it, so that adjacent faces leave
    /// no gap.
    slack: f64,
    bounds: Bounds,
}

impl MeshBody {
    /// A mesh scaled by `size` along its axes.
    pub(crate) fn new(mesh: TriangleMesh, size: DVec3) -> MeshBody {
        let outward = mesh.is_proven_outward();
        let (vertices, faces) = mesh.into_parts();
        let vertices: Vec<DVec3> = vertices.into_iter().map(|v| DVec3::from(v) * size).collect();
        let around = |all: Bounds, &face: &[u32; 3]| all.union(triangle(&vertices, face).bounds());
        let bounds = faces.iter().fold(Bounds::EMPTY, around);
        let (bvh, normals) = (OnceLock::new(), OnceLock::new());
        MeshBody { bvh, normals, meshlets: Meshlets::new(&vertices, &faces), outward, vertices, faces, bounds }
    }

    /// The hierarchy over the triangles.
    fn bvh(&self) -> &Bvh {
        let bounds = |&face: &[u32; 3]| triangle(&self.vertices, face).bounds();
        self.bvh.get_or_init(|| Bvh::new(&self.faces.iter().map(bounds).collect::<Vec<_>>()))
    }

    /// The unit normal of each triangle, to either side; 0 if it has no area.
    pub(crate) fn normals(&self) -> &[[f32; 3]] {
        let normal = |&face: &[u32; 3]| triangle(&self.vertices, face).normal().as_vec3().to_array();
        self.normals.get_or_init(|| self.faces.iter().map(normal).collect())
    }

    pub(crate) fn triangle(&self, part: u32) -> Triangle {
        triangle(&self.vertices, self.faces[part as usize])
    }

    fn intersect(&self, ray: &Ray, limit: f32, slack: f64) -> Option<Hit> {
        let sheared = ray.sheared();
        let hit = |face: usize, _| {
            let part = face as u32;
            Some(Hit { distance: self.triangle(part).intersect(&sheared, slack)?, part })
        };
        Some(self.bvh().closest(ray, limit, hit)?.1)
    }

    /// The parts of a ray inside a closed mesh, in order: those around which its surface winds. Triangles may have
    /// either orientation.
    fn spans(&self, ray: &Ray) -> Vec<Span> {
        let sheared = ray.sheared();
        let crossing = |&face: &usize| self.triangle(face as u32).crossing(&sheared);
        let mut crossings: Vec<(f64, bool)> = self.bvh().along(ray).iter().filter_map(crossing).collect();
        crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let turn = |front: bool| if front { 1 } else { -1 };
        // The winding number is 0 far away.
        let mut winding = -crossings.iter().map(|&(_, front)| turn(front)).sum::<i32>();
        let mut from = 0.0;
        let mut spans = Vec::new();
        for (distance, front) in crossings {
            if winding != 0 {
                spans.push((from, distance));
            }
            winding += turn(front);
            from = distance;
        }
        spans
    }
}

fn triangle(vertices: &[DVec3], face: [u32; 3]) -> Triangle {
    Triangle { corners: face.map(|v| vertices[v as usize]) }
}

impl Solid {
    /// The bounds of the solid at a pose.
    fn bounds(&self, pose: &Pose) -> Bounds {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = pose.rotation;
        let half = match self {
            Solid::Cuboid(Cuboid { half }) => pose.rotation.abs() * *half,
            Solid::Ellipsoid(Ellipsoid { radii }) => root_of_squares(&[x * radii.x, y * radii.y, z * radii.z]),
            Solid::Cylinder(Cylinder { half }) => root_of_squares(&[x * half.x, y * half.y]) + z.abs() * half.z,
            Solid::Rectangle(Rectangle { half }) => pose.rotation.abs() * half.extend(0.0),
            Solid::Mesh(mesh) => {
                let corners = mesh.vertices.iter().map(|&v| pose.point(v));
                return corners.fold(Bounds::EMPTY, |all, v| all.union(Bounds { min: v, max: v }));
            }
        };
        Bounds::around(pose.translation, half)
    }

    /// The largest shift of a surface point at a pose by rounding.
    fn slack(&self, pose: &Pose) -> f64 {
        let half = match self {
            Solid::Cuboid(shape) => shape.half,
            Solid::Rectangle(shape) => shape.half.extend(0.0),
            Solid::Ellipsoid(shape) => shape.radii,
            Solid::Cylinder(shape) => shape.half,
            Solid::Mesh(mesh) => mesh.bounds.min.abs().max(mesh.bounds.max.abs()),
        };
        8.0 * f64::EPSILON * (pose.translation.abs() + half).element_sum()
    }
}

/// The lengths of vectors along each axis, at right angles to each other.
fn root_of_squares(vectors: &[DVec3]) -> DVec3 {
    vectors.iter().fold(DVec3::ZERO, |sum, &v| sum + v * v).map(f64::sqrt)
}

impl Body {
    pub(crate) fn new(solid: Solid, pose: Pose, extinction: Option<f64>) -> Body {
        let slack = solid.slack(&pose);
        // A rotated cube reaches sqrt(3) times as far as an upright one.
        let bounds = solid.bounds(&pose).grown(2.0 * slack);
        Body { pose, solid, extinction, slack, bounds }
    }

    /// The box around it, relative to the origin of the scene, in the axes of the body; and how the body fills it.
    pub(crate) fn obb(&self) -> Obb {
        let (center, half, outline) = match &self.solid {
            Solid::Cuboid(shape) => (DVec3::ZERO, shape.half, Outline::Box),
            Solid::Rectangle(shape) => (DVec3::ZERO, shape.half.extend(0.0), Outline::Box),
            Solid::Ellipsoid(shape) => (DVec3::ZERO, shape.radii, Outline::Ellipsoid),
            Solid::Cylinder(shape) => (DVec3::ZERO, shape.half, Outline::Cylinder),
            Solid::Mesh(mesh) => (mesh.bounds.center(), (mesh.bounds.max - mesh.bounds.min) / 2.0, Outline::Box),
        };
        let half_axes = [0, 1, 2].map(|k| self.pose.rotation.col(k) * half[k]);
        Obb { center: self.pose.point(center), half_axes, outline }
    }

    /// The number of surfaces: a mesh has one for each triangle.
    pub(crate) fn surfaces(&self) -> usize {
        if let Solid::Mesh(mesh) = &self.solid { mesh.faces.len() } else { 1 }
    }

    /// Adds the normals of its surfaces to those of [`Scene::normals`](crate::Scene).
    pub(crate) fn push_normals(&self, columns: &mut [Vec<f32>; 3]) {
        let mut push = |normal: Vec3| columns.iter_mut().zip(normal.to_array()).for_each(|(to, x)| to.push(x));
        match &self.solid {
            _ if self.extinction.is_some() => (0..self.surfaces()).for_each(|_| push(Vec3::NAN)),
            Solid::Mesh(mesh) => {
                let turned = |&normal| (self.pose.rotation * Vec3::from(normal).as_dvec3()).as_vec3();
                mesh.normals().iter().map(turned).for_each(push);
            }
            Solid::Rectangle(shape) => push((self.pose.rotation * shape.normal()).as_vec3()),
            Solid::Cuboid(_) | Solid::Ellipsoid(_) | Solid::Cylinder(_) => push(Vec3::INFINITY),
        }
    }

    /// The bounds relative to the origin of the scene.
    pub(crate) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The closest hit of a ray of the scene whose distance, as f32, is at most `limit`; it may be a further one
    /// instead. For media, `path` gives the free path of the ray, in mean free paths.
    pub(crate) fn intersect(&self, ray: &Ray, limit: f32, path: impl FnOnce() -> f32) -> Option<Hit> {
        let (ray, slack) = (self.inverse_ray(ray), self.slack);
        if let Some(extinction) = self.extinction {
            return self.first_interaction(&ray, f64::from(path()) / (extinction * ray.direction.length()));
        }
        let distance = match &self.solid {
            Solid::Cuboid(shape) => shape.grown(slack).intersect(&ray, 2.0 * slack),
            Solid::Ellipsoid(shape) => shape.intersect(&ray, slack),
            Solid::Cylinder(shape) => shape.intersect(&ray, slack),
            Solid::Rectangle(shape) => shape.grown(slack).intersect(&ray, slack),
            Solid::Mesh(mesh) => return mesh.intersect(&ray, limit, slack),
        };
        Some(Hit { distance: distance?, part: 0 })
    }

    /// A ray of the scene in the frame of the body.
    fn inverse_ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.pose.inverse_point(ray.origin), direction: self.pose.inverse_vector(ray.direction) }
    }

    /// The first interaction of a ray of the body with its medium, given the free path in lengths of the ray's
    /// direction.
    fn first_interaction(&self, ray: &Ray, path: f64) -> Option<Hit> {
        let slack = self.slack;
        let distance = match &self.solid {
            Solid::Cuboid(shape) => first_interaction(shape.grown(slack).span(ray, 2.0 * slack), path),
            Solid::Ellipsoid(shape) => first_interaction(shape.span(ray, slack), path),
            Solid::Cylinder(shape) => first_interaction(shape.span(ray, slack), path),
            Solid::Mesh(mesh) => first_interaction(mesh.spans(ray), path),
            // Checked not to be a medium.
            Solid::Rectangle(_) => None,
        };
        Some(Hit { distance: distance?, part: 0 })
    }

    /// The closest hit by a test of every triangle: the definition against which the hierarchy is tested.
    #[cfg(test)]
    pub(crate) fn intersect_all(&self, ray: &Ray, path: impl FnOnce() -> f32) -> Option<Hit> {
        let (Solid::Mesh(mesh), None) = (&self.solid, self.extinction) else {
            return self.intersect(ray, f32::INFINITY, path);
        };
        let sheared = self.inverse_ray(ray).sheared();
        let hits = (0..mesh.faces.len() as u32)
            .filter_map(|part| Some(Hit { distance: mesh.triangle(part).intersect(&sheared, self.slack)?, part }));
        hits.min_by(|a, b| (a.distance as f32).total_cmp(&(b.distance as f32)))
    }

    /// The unit normal at a point of the surface, both relative to the origin of the scene; outward for closed shapes,
    /// to either side for a rectangle or a triangle. 0 if the surface has none.
    pub(crate) fn normal(&self, point: DVec3, part: u32) -> DVec3 {
        let point = self.pose.inverse_point(point);
        let normal = match &self.solid {
            Solid::Cuboid(shape) => shape.normal(point),
            Solid::Ellipsoid(shape) => shape.normal(point),
            Solid::Cylinder(shape) => shape.normal(point),
            Solid::Rectangle(shape) => shape.normal(),
            Solid::Mesh(mesh) => mesh.triangle(part).normal(),
        };
        self.pose.rotation * normal
    }
}
