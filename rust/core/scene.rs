//! Scenes: bodies with a class and an instance, compiled for casting.

use std::sync::OnceLock;

use glam::DVec3;

use crate::body::Body;
use crate::bvh::Bvh;
use crate::intersect::{Hit, Ray};
use crate::packed::BodyTable;
use crate::{Bounds, Error, FreePathKey, Pose, Primitive, Result};

/// The closest surface along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// The distance along the ray, in lengths of its direction; greater than 0.
    pub distance: f64,
    /// The index of the primitive.
    pub primitive: usize,
    /// The triangle of a mesh; 0 for every other shape.
    pub part: u32,
    /// The class of the primitive.
    pub label: u8,
    /// Its instance.
    pub instance: u32,
}

/// Primitives compiled for casting.
///
/// A scene has two levels: a hierarchy over bodies, each in its own frame, and within a mesh a hierarchy over its
/// triangles. Moving a body leaves the lower level unchanged.
///
/// Everything is relative to `origin`, the middle of the scene, so that a scene in map coordinates of a million metres
/// is as precise as one around 0.
pub struct Scene {
    origin: DVec3,
    /// One for each primitive.
    bodies: Vec<Body>,
    /// The middle of each primitive in the world, without the rounding of `origin`.
    centers: Vec<DVec3>,
    /// The original bounds of each in the world: they decide the origin of a scene.
    made: Vec<Bounds>,
    /// Class and instance of each primitive.
    semantics: Vec<(u8, u32)>,
    /// The key of the free paths within each primitive, if it is a medium.
    media: Vec<u32>,
    bvh: Bvh,
    body_table: BodyTable,
    /// The normals of all surfaces, made when a scan first needs them.
    normals: OnceLock<[Vec<f32>; 3]>,
}

impl Scene {
    /// A scene; it may be empty.
    ///
    /// # Errors
    /// [`Error::Center`], [`Error::Size`], [`Error::Yaw`], [`Error::Extinction`], [`Error::PlaneMedium`],
    /// [`Error::OpenMedium`] or [`Error::MeshReach`].
    pub fn new(primitives: Vec<Primitive>) -> Result<Scene> {
        for (index, primitive) in primitives.iter().enumerate() {
            primitive.check(index)?;
        }
        let made: Vec<Bounds> = primitives.iter().map(Primitive::bounds).collect();
        let origin = middle(&made);
        let centers = primitives.iter().map(|p| DVec3::from(p.center)).collect();
        let semantics = primitives.iter().map(|p| (p.label, p.instance)).collect();
        let bodies: Vec<Body> = primitives.into_iter().map(|p| p.body(origin)).collect();
        let media = (0..bodies.len() as u32).collect();
        Ok(Scene::of(origin, bodies, centers, made, semantics, media))
    }

    fn of(
        origin: DVec3,
        bodies: Vec<Body>,
        centers: Vec<DVec3>,
        made: Vec<Bounds>,
        semantics: Vec<(u8, u32)>,
        media: Vec<u32>,
    ) -> Scene {
        let bvh = Bvh::new(&boxes(&bodies));
        let body_table = BodyTable::new(bodies.iter().map(|body| (body.obb(), body.surfaces())));
        Scene { origin, bodies, centers, made, semantics, media, bvh, body_table, normals: OnceLock::new() }
    }

    /// One scene of some primitives of others, in that order, as if compiled from them: meshes are shared, and bodies
    /// of scenes with the same origin too. `origin` is by default the middle of all original places.
    ///
    /// # Errors
    /// [`Error::MovedIndex`] on an index that its scene does not have.
    pub fn joined(parts: &[(&Scene, &[u32])], origin: Option<DVec3>) -> Result<Scene> {
        for &(scene, primitives) in parts {
            let count = scene.bodies.len();
            if let Some(entry) = primitives.iter().position(|&primitive| primitive as usize >= count) {
                return Err(Error::MovedIndex { entry, primitive: primitives[entry], count });
            }
        }
        let all = || parts.iter().flat_map(|&(scene, some)| some.iter().map(move |&i| (scene, i as usize)));
        let made: Vec<Bounds> = all().map(|(scene, i)| scene.made[i]).collect();
        let origin = origin.unwrap_or_else(|| middle(&made));
        let body = |(scene, i): (&Scene, usize)| {
            let body = &scene.bodies[i];
            if scene.origin == origin {
                return body.clone();
            }
            let pose = Pose { translation: scene.centers[i] - origin, ..body.pose };
            Body::new(body.solid.clone(), pose, body.extinction)
        };
        let bodies = all().map(body).collect();
        let centers = all().map(|(scene, i)| scene.centers[i]).collect();
        let semantics = all().map(|(scene, i)| scene.semantics[i]).collect();
        let media = all().map(|(scene, i)| scene.media[i]).collect();
        Ok(Scene::of(origin, bodies, centers, made, semantics, media))
    }

    /// The scene with a number for each primitive in place of its index. The free paths of rays in a medium are a pure
    /// function of it: a medium that keeps its number keeps them when other primitives come and go.
    ///
    /// # Errors
    /// [`Error::PrimitiveTable`] if there is not one for each primitive.
    pub fn with_media(self, media: Vec<u32>) -> Result<Scene> {
        let (entries, primitives) = (media.len(), self.bodies.len());
        if entries != primitives {
            return Err(Error::PrimitiveTable { table: "media", entries, primitives });
        }
        Ok(Scene { media, ..self })
    }

    /// The same scene with some primitives moved: `world_from_primitive` is the new pose of the frame of each, its
    /// middle and axes. Meshes are shared with this scene; only the hierarchy over the bodies is made again.
    ///
    /// # Errors
    /// [`Error::MovedCount`], [`Error::MovedIndex`] or [`Error::MovedTwice`].
    pub fn moved(&self, primitives: &[u32], world_from_primitive: &[Pose]) -> Result<Scene> {
        self.check_moved(primitives, world_from_primitive.len())?;
        let (mut bodies, mut centers) = (self.bodies.clone(), self.centers.clone());
        for (&primitive, pose) in primitives.iter().zip(world_from_primitive) {
            let body = &mut bodies[primitive as usize];
            centers[primitive as usize] = pose.translation;
            // Restores the digits lost in float32 texts.
            let pose = Pose { translation: pose.translation - self.origin, ..pose.orthonormal() };
            *body = Body::new(body.solid.clone(), pose, body.extinction);
        }
        let (made, semantics, media) = (self.made.clone(), self.semantics.clone(), self.media.clone());
        Ok(Scene::of(self.origin, bodies, centers, made, semantics, media))
    }

    fn check_moved(&self, primitives: &[u32], poses: usize) -> Result<()> {
        if primitives.len() != poses {
            return Err(Error::MovedCount { primitives: primitives.len(), poses });
        }
        let mut entries = vec![None; self.bodies.len()];
        for (entry, &primitive) in primitives.iter().enumerate() {
            let count = self.bodies.len();
            let before = entries.get_mut(primitive as usize).ok_or(Error::MovedIndex { entry, primitive, count })?;
            if let Some(first) = before.replace(entry) {
                return Err(Error::MovedTwice { entry, first, primitive });
            }
        }
        Ok(())
    }

    /// The closest surface along a ray; of two whose distances are the same in f32, the one with the lower index, and
    /// within a mesh the lower triangle. `key` decides its free paths in media.
    ///
    /// Origin and direction must be finite, and the direction not 0; it need not have the length 1.
    pub fn closest(&self, origin: DVec3, direction: DVec3, key: FreePathKey) -> Option<SceneHit> {
        let ray = Ray { origin: origin - self.origin, direction };
        let meet = |body: usize, limit| self.bodies[body].intersect(&ray, limit, || self.free_path(body, key));
        let (primitive, hit) = self.bvh.closest(&ray, f32::INFINITY, meet)?;
        Some(self.scene_hit(primitive, hit))
    }

    /// The same by a test of every surface: the definition against which the hierarchies are tested.
    #[cfg(test)]
    pub(crate) fn closest_of_all(&self, origin: DVec3, direction: DVec3, key: FreePathKey) -> Option<SceneHit> {
        let ray = Ray { origin: origin - self.origin, direction };
        let hits = self.bodies.iter().enumerate();
        let (primitive, hit) = hits
            .filter_map(|(i, body)| Some((i, body.intersect_all(&ray, || self.free_path(i, key))?)))
            .min_by(|a, b| (a.1.distance as f32).total_cmp(&(b.1.distance as f32)))?;
        Some(self.scene_hit(primitive, hit))
    }

    fn free_path(&self, medium: usize, key: FreePathKey) -> f32 {
        let body = &self.bodies[medium];
        key.path(self.media[medium], body.extinction.unwrap_or(1.0), body.pose.translation)
    }

    fn scene_hit(&self, primitive: usize, hit: Hit) -> SceneHit {
        let (label, instance) = self.semantics[primitive];
        SceneHit { distance: hit.distance, primitive, part: hit.part, label, instance }
    }

    /// Whether a primitive is a medium: a hit in it has no surface.
    pub fn is_medium(&self, primitive: usize) -> bool {
        self.bodies[primitive].extinction.is_some()
    }

    /// The unit normal of a primitive at a point of its surface; it may point to either side, and is 0 if the surface
    /// has none. `part` is the triangle of a mesh, as in [`SceneHit`].
    pub fn normal(&self, primitive: usize, part: u32, point: DVec3) -> DVec3 {
        self.bodies[primitive].normal(point - self.origin, part)
    }

    /// The point of the world to which the poses of the bodies are relative.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The bodies, one for each primitive.
    pub(crate) fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The bodies as columns of numbers.
    pub(crate) fn body_table(&self) -> &BodyTable {
        &self.body_table
    }

    /// The unit normal of each surface in the frame of the scene, to either side, as columns that vectors gather. It is
    /// NaN in a medium and infinite on a curved surface; one more entry, 0, is for no surface.
    pub(crate) fn normals(&self) -> &[Vec<f32>; 3] {
        self.normals.get_or_init(|| {
            let mut columns = [(); 3].map(|()| Vec::new());
            self.bodies.iter().for_each(|body| body.push_normals(&mut columns));
            columns.iter_mut().for_each(|column| column.push(0.0));
            columns
        })
    }

    /// The keys of the free paths within each primitive.
    pub(crate) fn media(&self) -> &[u32] {
        &self.media
    }

    /// Class and instance of each primitive.
    pub(crate) fn semantics(&self) -> &[(u8, u32)] {
        &self.semantics
    }
}

fn middle(made: &[Bounds]) -> DVec3 {
    let bounds = made.iter().fold(Bounds::EMPTY, |all, &next| all.union(next));
    if bounds.is_empty() { DVec3::ZERO } else { bounds.center() }
}

fn boxes(bodies: &[Body]) -> Vec<Bounds> {
    bodies.iter().map(Body::bounds).collect()
}
