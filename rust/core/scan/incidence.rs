//! Incidence and normals of the rasterized surfaces in a view.
//!
//! Flat surfaces, the most common, have one normal each, which vectors of pixels gather from a table of the scene. On
//! curved ones the hit point is computed again in f64, because a range in f32 may be nearer to another face of a thin
//! body. Rays are those of the view, off from those of the pattern by a rounding in f32.

use glam::{DVec3, Vec3};

use super::view::View;
use crate::body::{Body, Solid};
use crate::intersect::{Cuboid, Ray};
use crate::packed::padded;
use crate::simd::{Lanes, Mask, Vector};
use crate::{ImagesMut, Scene};

/// Writes incidence and normals, row by row.
pub(super) struct IncidenceWriter<'a> {
    scene: &'a Scene,
    view: &'a View<'a>,
    /// The headings of rays, phase by phase, and their ups, in the frame of the scene.
    headings: Vec<[Vec<f32>; 3]>,
    ups: [Vec<f32>; 3],
    /// Cosines of incidence in the current row.
    cosines: Vec<f32>,
    /// The columns with curved surfaces.
    curved: Vec<usize>,
}

impl<'a> IncidenceWriter<'a> {
    pub(super) fn new(scene: &'a Scene, view: &'a View<'a>) -> IncidenceWriter<'a> {
        let padded = padded(view.width());
        let headings =
            (0..view.band.phase_count).map(|phase| turned(view, |column| view.ray(phase, column).1)).collect();
        let ups = turned(view, |column| view.ray(0, column).2);
        IncidenceWriter { scene, view, headings, ups, cosines: vec![0.0; padded], curved: Vec::new() }
    }

    /// Writes a row of the view; `ids` are numbers of surfaces for pixels with a return, padded to a full vector.
    #[inline(always)]
    pub(super) fn write<L: Lanes>(&mut self, row: usize, ids: &[u32], image: &mut ImagesMut<'_>) {
        let rays = Rays::new(self.view, row);
        if let Some(incidence) = &mut image.incidence {
            self.find_cosines::<L>(&rays, ids);
            for ((to, &cosine), &depth) in incidence.iter_mut().zip(&self.cosines).zip(&*image.depth) {
                *to = if depth > 0.0 { cosine } else { 0.0 };
            }
            for &column in &self.curved {
                if image.depth.get(column).is_some_and(|&depth| depth > 0.0) {
                    let (_, cosine) = rays.meet(self.scene, ids[column], column, image.depth[column]);
                    incidence[column] = cosine.abs().min(1.0) as f32;
                }
            }
        }
        if let Some(normal) = &mut image.normal {
            for (column, (to, &depth)) in normal.iter_mut().zip(&*image.depth).enumerate() {
                *to = if depth > 0.0 { self.normal(&rays, ids[column], column, depth) } else { [0.0; 3] };
            }
        }
    }

    /// Finds the cosines of incidence of a row, except those on curved surfaces, whose columns are listed.
    ///
    /// Without a return, the id is that of an earlier view or scene, and the cosine any number.
    #[inline(always)]
    fn find_cosines<L: Lanes>(&mut self, rays: &Rays<'_>, ids: &[u32]) {
        let (normals, headings) = (self.scene.normals(), &self.headings[rays.phase]);
        let (slope, inverse_length) = (L::splat(rays.slope as f32), L::splat(rays.inverse_length as f32));
        self.curved.clear();
        for at in (0..self.view.width()).step_by(L::N) {
            let direction = Vector::load(headings, at) + Vector::load(&self.ups, at) * slope;
            let normal = Vector::<L>::gather_at(normals, ids, at);
            // That of a medium is NaN, which makes the cosine 1.
            let cosine = (normal.dot(direction) * inverse_length).abs().min(L::splat(1.0));
            cosine.store(&mut self.cosines, at);
            let mut left = normal.x.gt(L::splat(f32::MAX)).bits();
            while left != 0 {
                self.curved.push(at + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }

    /// The normal of a surface at its hit by a ray, towards the sensor.
    #[inline(always)]
    fn normal(&self, rays: &Rays<'_>, id: u32, column: usize, depth: f32) -> [f32; 3] {
        let [x, y, z] = self.scene.normals();
        let flat = Vec3::new(x[id as usize], y[id as usize], z[id as usize]);
        let (normal, cosine) = if flat.x.is_finite() {
            (flat.as_dvec3(), flat.as_dvec3().dot(rays.ray(column).1))
        } else if flat.x.is_nan() {
            (rays.ray(column).1 * rays.inverse_length, 1.0)
        } else {
            rays.meet(self.scene, id, column, depth)
        };
        (if cosine > 0.0 { -normal } else { normal }).as_vec3().to_array()
    }
}

/// A vector of each column of a view as columns of coordinates, in the frame of the scene.
fn turned(view: &View<'_>, vector: impl Fn(usize) -> DVec3) -> [Vec<f32>; 3] {
    let columns = || (0..padded(view.width())).map(|column| column.min(view.width() - 1));
    let mut turned = [(); 3].map(|()| Vec::with_capacity(columns().len()));
    for vector in columns().map(|column| view.rotation * vector(column)) {
        turned.iter_mut().zip(vector.as_vec3().to_array()).for_each(|(to, x)| to.push(x));
    }
    turned
}

/// The rays of a row of a view.
struct Rays<'a> {
    view: &'a View<'a>,
    phase: usize,
    slope: f64,
    /// 1 / their length.
    inverse_length: f64,
}

impl<'a> Rays<'a> {
    fn new(view: &'a View<'a>, row: usize) -> Rays<'a> {
        let slope = f64::from(view.band.slopes[row]);
        let inverse_length = 1.0 / slope.mul_add(slope, 1.0).sqrt();
        Rays { view, phase: usize::from(view.band.phases[row]), slope, inverse_length }
    }

    /// The origin and direction of a ray, in the frame of the scene.
    #[inline(always)]
    fn ray(&self, column: usize) -> (DVec3, DVec3) {
        let (start, heading, up) = self.view.ray(self.phase, column);
        let View { origin, rotation, .. } = self.view;
        (*origin + *rotation * start, *rotation * (heading + up * self.slope))
    }

    /// The unit normal of a curved surface at its hit by a ray, at about this distance, and the cosine between both.
    #[inline(always)]
    fn meet(&self, scene: &Scene, id: u32, column: usize, depth: f32) -> (DVec3, f64) {
        let Body { pose, solid, .. } = &scene.bodies()[scene.body_table().body_of(id)];
        let (origin, direction) = self.ray(column);
        let ray = Ray { origin: pose.inverse_point(origin), direction: pose.inverse_vector(direction) };
        let normal = normal(solid, &ray, f64::from(depth) * self.inverse_length);
        (pose.rotation * normal, normal.dot(ray.direction) * self.inverse_length)
    }
}

/// The unit normal at the hit of a ray on a solid in its frame, at about this distance.
#[inline(always)]
fn normal(solid: &Solid, ray: &Ray, range: f64) -> DVec3 {
    let at = |exact: Option<f64>| ray.at(exact.unwrap_or(range));
    match solid {
        Solid::Cuboid(shape) => face_normal(shape, ray),
        Solid::Ellipsoid(shape) => shape.normal(at(shape.intersect(ray, 0.0))),
        Solid::Cylinder(shape) => shape.normal(at(shape.intersect(ray, 0.0))),
        Solid::Rectangle(shape) => shape.normal(),
        Solid::Mesh(_) => DVec3::ZERO,
    }
}

/// The normal of the face by which a ray that hits a box enters it, or leaves it if it starts inside; to either side.
#[inline(always)]
fn face_normal(Cuboid { half }: &Cuboid, ray: &Ray) -> DVec3 {
    let (mut axis, mut nearest) = (3, f64::INFINITY);
    for k in 0..3 {
        // The last plane crossed on the way in is that with the least 1 / t.
        let inverse_depth = ray.direction[k] / (half[k].copysign(ray.origin[k]) - ray.origin[k]);
        if ray.origin[k].abs() > half[k] && inverse_depth < nearest {
            (axis, nearest) = (k, inverse_depth);
        }
    }
    if axis < 3 {
        return DVec3::AXES[axis];
    }
    let leaves = |k: usize| ray.direction[k] / (half[k].copysign(ray.direction[k]) - ray.origin[k]);
    let [x, y, z] = [leaves(0), leaves(1), leaves(2)];
    DVec3::AXES[if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) }]
}
