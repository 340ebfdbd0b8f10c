//! A hierarchy over boxes: the closest hit of any ray.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH, builder::build_bvh2};
use obvhs::ray::RayHit;

use crate::Bounds;
use crate::intersect::{Hit, Ray};

/// A binary hierarchy (crate `obvhs`) in f32; the tests of what is in its boxes stay in f64.
///
/// Invariant: no hit is lost to f32. A ray is followed from where it enters the bounds of everything, so its origin, the
/// box corners and their differences are at most one diagonal long, and each is off by at most half a unit in the last
/// place of that; a box test makes fewer than 8 such errors, which is what the boxes are grown by.
pub(crate) struct Bvh {
    tree: Bvh2,
    bounds: Bounds,
}

/// The closest entry so far. Distances are compared as the f32 that the images hold; of equal ones the lower entry wins.
struct Closest {
    hit: Hit,
    depth: f32,
    entry: usize,
}

impl Bvh {
    /// A hierarchy over boxes that are finite and lie around the origin.
    pub(crate) fn new(boxes: &[Bounds]) -> Bvh {
        let tight = boxes.iter().fold(Bounds::EMPTY, |all, &next| all.union(next));
        let margin = 8.0 * f64::from(f32::EPSILON) * tight.diagonal();
        let padded: Vec<Aabb> = boxes.iter().map(|b| outward(b.grown(margin))).collect();
        let mut spent = Duration::ZERO;
        // Tests in f64 cost about as much as the two box tests that save one; the default expects f32 triangles.
        let settings = BvhBuildParams { collapse_traversal_cost: 1.0, ..BvhBuildParams::medium_build() };
        let mut tree = build_bvh2(&padded, settings, &mut spent);
        if !tree.nodes.is_empty() {
            tree.max_depth = (tree.depth(0) + 1).max(DEFAULT_MAX_STACK_DEPTH);
        }
        let bounds = tight.grown(margin);
        Bvh { tree, bounds }
    }

    /// The closest of the hits that `intersect` finds with the entries along a ray, and its entry.
    pub(crate) fn closest(&self, ray: &Ray, intersect: impl Fn(usize) -> Option<Hit>) -> Option<(usize, Hit)> {
        let (enter, exit) = self.bounds.crossing(ray.origin, ray.direction)?;
        if exit < 0.0 || self.bounds.is_empty() {
            return None;
        }
        let start = enter.max(0.0);
        let walk = obvhs::ray::Ray::new_inf(Vec3A::from(ray.at(start).as_vec3()), Vec3A::from(ray.direction.as_vec3()));
        let mut best: Option<Closest> = None;
        let mut limit = f32::INFINITY;
        self.tree.ray_traverse(walk, &mut RayHit::none(), |_, leaf| {
            let entry = self.tree.primitive_indices[leaf] as usize;
            if let Some(hit) = intersect(entry) {
                let depth = hit.distance as f32;
                if best.as_ref().is_none_or(|b| (depth, entry) < (b.depth, b.entry)) {
                    // Boxes that begin within the same f32 may hold a tie.
                    limit = ((f64::from(depth.next_up()) - start) as f32).next_up();
                    best = Some(Closest { hit, depth, entry });
                }
            }
            limit
        });
        best.map(|b| (b.entry, b.hit))
    }
}

/// The smallest f32 box around an f64 one.
fn outward(bounds: Bounds) -> Aabb {
    let (min, max) = (bounds.min.as_vec3(), bounds.max.as_vec3());
    Aabb::new(Vec3A::from(min.map(f32::next_down)), Vec3A::from(max.map(f32::next_up)))
}
