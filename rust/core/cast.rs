//! Casts of single rays.

use glam::DVec3;

use crate::image::Return;
use crate::threads::spread;
use crate::{Error, FreePathKey, ImagesMut, Result, Scene};

/// The hits of rays, one entry for each; a ray without hit has 0 in all of them and -1 in `primitive`.
#[derive(Clone, Debug, PartialEq)]
pub struct Hits {
    /// Distances [m].
    pub distance: Vec<f32>,
    /// Classes.
    pub label: Vec<u8>,
    /// Instances.
    pub instance: Vec<u32>,
    /// Indices of the primitives.
    pub primitive: Vec<i32>,
    /// Unit normals in the world, turned towards the origin of the ray.
    pub normal: Vec<[f32; 3]>,
}

/// The largest distance of a ray's start [m]; beyond, positions would be coarser than 0.1 micrometres.
const FURTHEST: f64 = 1e9;
/// Rays in a thread's block.
const BLOCK: usize = 1024;

/// The closest hit of each ray, not further than `max_range` [m] (compared as f32; it may be infinite).
///
/// Directions need not have the length 1. `seed` decides how far rays travel in media. `threads` 0 is the number of
/// cores.
///
/// # Errors
/// [`Error::RayCount`], [`Error::RayOrigin`], [`Error::RayDirection`] or [`Error::MaxRange`].
pub fn cast(
    scene: &Scene,
    origins: &[[f64; 3]],
    directions: &[[f64; 3]],
    max_range: f64,
    seed: u64,
    threads: usize,
) -> Result<Hits> {
    check(origins, directions, max_range)?;
    let rays = origins.len();
    let mut hits = Hits {
        distance: vec![0.0; rays],
        label: vec![0; rays],
        instance: vec![0; rays],
        primitive: vec![-1; rays],
        normal: vec![[0.0; 3]; rays],
    };
    let cast = |ray: usize, origin: &[f64; 3], direction: &[f64; 3]| {
        let (origin, direction) = (DVec3::from(*origin), unit(DVec3::from(*direction)));
        let hit = scene.closest(origin, direction, FreePathKey::of_ray(seed, ray))?;
        let depth = hit.distance as f32;
        let within = depth > 0.0 && depth <= max_range as f32;
        within.then(|| Return::new(scene, origin, direction, &hit, depth))
    };
    let rays = origins.chunks(BLOCK).zip(directions.chunks(BLOCK));
    let blocks = rays.zip(hits.blocks()).enumerate().collect();
    spread(threads, blocks, |(block, ((origins, directions), mut found)): (usize, ((&[_], &[_]), ImagesMut<'_>))| {
        for (ray, (origin, direction)) in origins.iter().zip(directions).enumerate() {
            found.set(ray, cast(block * BLOCK + ray, origin, direction).as_ref());
        }
    });
    Ok(hits)
}

impl Hits {
    fn blocks(&mut self) -> impl Iterator<Item = ImagesMut<'_>> {
        let columns = (self.distance.chunks_mut(BLOCK), self.label.chunks_mut(BLOCK), self.instance.chunks_mut(BLOCK));
        let last = self.primitive.chunks_mut(BLOCK).zip(self.normal.chunks_mut(BLOCK));
        columns.0.zip(columns.1).zip(columns.2).zip(last).map(|(((depth, label), instance), (primitive, normal))| {
            ImagesMut { depth, label, instance, primitive: Some(primitive), incidence: None, normal: Some(normal) }
        })
    }
}

/// A vector scaled to the length 1, at any length: its square may be too large or too small for f64.
fn unit(direction: DVec3) -> DVec3 {
    (direction / direction.abs().max_element()).normalize()
}

fn check(origins: &[[f64; 3]], directions: &[[f64; 3]], max_range: f64) -> Result<()> {
    if origins.len() != directions.len() {
        return Err(Error::RayCount { origins: origins.len(), directions: directions.len() });
    }
    let limit = FURTHEST;
    if let Some(ray) = origins.iter().position(|o| !o.iter().all(|x| x.abs() <= limit)) {
        let value = origins[ray];
        return Err(Error::RayOrigin { ray, value, limit });
    }
    if let Some(ray) = directions.iter().position(|d| !d.iter().all(|x| x.is_finite()) || *d == [0.0; 3]) {
        let value = directions[ray];
        return Err(Error::RayDirection { ray, value });
    }
    if max_range.is_nan() || max_range <= 0.0 {
        return Err(Error::MaxRange { value: max_range });
    }
    Ok(())
}
