//! A hierarchy over boxes: the closest hit of any ray.

use std::cell::RefCell;
use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH, builder::build_bvh2};
use obvhs::ray::RayHit;

use crate::Bounds;
use crate::intersect::{Hit, Ray};

/// A binary hierarchy (crate `obvhs`) in f32; the tests of the entries in its boxes stay in f64.
///
/// Invariant: no hit is lost to f32. Everything is relative to the middle of all boxes, and a ray is followed from its
/// entry into their bounds. So its origin, the box corners and their differences are at most one diagonal long, and
/// each is off by at most half a unit in the last place of that. A box test makes fewer than 8 such errors; the boxes
/// are grown by those.
pub(crate) struct Bvh {
    tree: Bvh2,
    middle: DVec3,
    /// Of all boxes, grown, relative to the middle.
    bounds: Bounds,
}

/// The closest entry so far. Distances are compared as the f32 of the images; of equal ones the lower entry wins.
struct Closest {
    hit: Hit,
    depth: f32,
    entry: usize,
}

impl Bvh {
    /// A hierarchy over finite boxes.
    pub(crate) fn new(boxes: &[Bounds]) -> Bvh {
        let tight = boxes.iter().fold(Bounds::EMPTY, |all, &next| all.union(next));
        let middle = if tight.is_empty() { DVec3::ZERO } else { tight.center() };
        let margin = 8.0 * f64::from(f32::EPSILON) * tight.diagonal();
        let padded: Vec<Aabb> = boxes.iter().map(|b| outward(b.moved(-middle).grown(margin))).collect();
        let mut spent = Duration::ZERO;
        // Tests in f64 cost about as much as the two box tests that save one; the default expects f32 triangles.
        let settings = BvhBuildParams { collapse_traversal_cost: 1.0, ..BvhBuildParams::medium_build() };
        let mut tree = build_bvh2(&padded, settings, &mut spent);
        if !tree.nodes.is_empty() {
            tree.max_depth = (tree.depth(0) + 1).max(DEFAULT_MAX_STACK_DEPTH);
        }
        let bounds = tight.moved(-middle).grown(margin);
        Bvh { tree, middle, bounds }
    }

    /// The closest of the hits that `intersect` finds with the entries along a ray, and its entry.
    ///
    /// Hits whose distance, as f32, is greater than `limit` may be left out; `intersect` gets the current limit.
    pub(crate) fn closest(
        &self,
        ray: &Ray,
        limit: f32,
        intersect: impl Fn(usize, f32) -> Option<Hit>,
    ) -> Option<(usize, Hit)> {
        let ray = Ray { origin: ray.origin - self.middle, ..*ray };
        let (enter, exit) = self.bounds.crossing(ray.origin, ray.direction)?;
        if exit < 0.0 || enter as f32 > limit.next_up() || self.bounds.is_empty() {
            return None;
        }
        let start = enter.max(0.0);
        // Boxes that begin within the same f32 may hold a tie.
        let from_start = |depth: f32| ((f64::from(depth.next_up()) - start) as f32).next_up();
        let (origin, direction) = (Vec3A::from(ray.at(start).as_vec3()), Vec3A::from(ray.direction.as_vec3()));
        let walk = obvhs::ray::Ray::new(origin, direction, 0.0, from_start(limit));
        let mut best: Option<Closest> = None;
        let mut limit = limit;
        self.tree.ray_traverse(walk, &mut RayHit::none(), |_, leaf| {
            let entry = self.tree.primitive_indices[leaf] as usize;
            if let Some(hit) = intersect(entry, limit) {
                let depth = hit.distance as f32;
                if best.as_ref().is_none_or(|b| (depth, entry) < (b.depth, b.entry)) {
                    limit = limit.min(depth);
                    best = Some(Closest { hit, depth, entry });
                }
            }
            from_start(limit)
        });
        best.map(|b| (b.entry, b.hit))
    }
}

impl Bvh {
    /// The entries with boxes on a ray.
    pub(crate) fn along(&self, ray: &Ray) -> Vec<usize> {
        let met = RefCell::new(Vec::new());
        self.closest(ray, f32::INFINITY, |entry, _| {
            met.borrow_mut().push(entry);
            None
        });
        met.into_inner()
    }
}

/// The smallest f32 box around an f64 one.
fn outward(bounds: Bounds) -> Aabb {
    let (min, max) = (bounds.min.as_vec3(), bounds.max.as_vec3());
    Aabb::new(Vec3A::from(min.map(f32::next_down)), Vec3A::from(max.map(f32::next_up)))
}
