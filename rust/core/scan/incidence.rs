//! Incidence and normals of what was rasterized in a view.
//!
//! Neighbouring pixels mostly show the same surface, which is looked up once for all of them. A flat one has one normal; on
//! others the point that was hit is worked out anew in f64, because a range in f32 may be nearer to another face of a thin
//! body. Rays are those of the view, off from those of the pattern by a rounding in f32.

use std::ops::Range;

use glam::{DMat3, DVec3, Vec3};

use super::view::View;
use super::visibility_buffer::UNRESOLVED;
use crate::body::{Body, Solid};
use crate::intersect::{Cuboid, Ray};
use crate::{ImagesMut, Scene};

/// Turns by less than this change no cosine by more than rounding does.
const STEADY: f32 = 1e-7;

/// A surface as the rays of a view meet it.
#[derive(Clone, Copy)]
enum Surface<'a> {
    /// One normal, in the frame of the view.
    Flat(DVec3),
    Curved(&'a Body),
    Medium,
}

/// How many surfaces are remembered: a power of two.
const CACHED: usize = 512;

/// Writes incidence and normals, row by row: what a row shows, the next one mostly shows too.
pub(super) struct IncidenceWriter<'a> {
    scene: &'a Scene,
    view: &'a View<'a>,
    /// Surfaces that were looked up before, each at its number modulo `CACHED`.
    cache: Vec<(u32, Surface<'a>)>,
    /// The last body with a flat surface, and the rotation from its frame into the view's.
    last: (usize, DMat3),
}

impl<'a> IncidenceWriter<'a> {
    pub(super) fn new(scene: &'a Scene, view: &'a View<'a>) -> IncidenceWriter<'a> {
        IncidenceWriter {
            scene,
            view,
            cache: vec![(UNRESOLVED, Surface::Medium); CACHED],
            last: (usize::MAX, DMat3::ZERO),
        }
    }

    /// Writes a row of the view; `ids` are numbers of surfaces, where there is a return.
    #[inline(always)]
    pub(super) fn write(&mut self, row: usize, ids: &[u32], image: &mut ImagesMut<'_>) {
        let rays = Rays::new(self.view, row);
        let mut start = 0;
        while start < ids.len() {
            let id = ids[start];
            let known = image.depth[start] > 0.0;
            // Where there is no return, the id is that of an earlier view.
            let same = |pixel: &(&u32, &f32)| *pixel.0 == id && (*pixel.1 > 0.0) == known;
            let end = start + ids[start..].iter().zip(&image.depth[start..]).take_while(same).count();
            if known {
                self.surface(id).write(&rays, start..end, image);
            } else {
                if let Some(incidence) = &mut image.incidence {
                    incidence[start..end].fill(0.0);
                }
                if let Some(normal) = &mut image.normal {
                    normal[start..end].fill([0.0; 3]);
                }
            }
            start = end;
        }
    }

    #[inline(always)]
    fn surface(&mut self, id: u32) -> Surface<'a> {
        let slot = id as usize % CACHED;
        if self.cache[slot].0 != id {
            self.cache[slot] = (id, self.look_up(id));
        }
        self.cache[slot].1
    }

    fn look_up(&mut self, id: u32) -> Surface<'a> {
        let (number, part) = self.scene.body_table().body_of(id);
        let body = &self.scene.bodies()[number];
        if body.extinction.is_some() {
            return Surface::Medium;
        }
        let normal = match &body.solid {
            Solid::Rectangle(shape) => shape.normal(),
            Solid::Mesh(mesh) => Vec3::from(mesh.normals()[part as usize]).as_dvec3(),
            _ => return Surface::Curved(body),
        };
        if self.last.0 != number {
            self.last = (number, self.view.rotation.transpose() * body.pose.rotation);
        }
        Surface::Flat(self.last.1 * normal)
    }
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

    /// Where a ray starts and where it looks.
    #[inline(always)]
    fn ray(&self, column: usize) -> (DVec3, DVec3) {
        let (start, heading, up) = self.view.ray(self.phase, column);
        (start, heading + up * self.slope)
    }

    /// The cosines of the angles between rays and a normal to either side.
    #[inline(always)]
    fn cosines(&self, normal: DVec3, columns: Range<usize>, to: &mut [f32]) {
        if self.view.motion.as_ref().is_some_and(|motion| motion.twist > STEADY) {
            for (to, column) in to.iter_mut().zip(columns) {
                *to = (normal.dot(self.ray(column).1) * self.inverse_length).abs().min(1.0) as f32;
            }
            return;
        }
        let from = self.view.columns.start + columns.start;
        let [x, y] = self.view.band.headings(self.phase);
        let (along, rise) =
            ((normal * self.inverse_length).as_vec3(), (normal.z * self.slope * self.inverse_length) as f32);
        for ((to, x), y) in to.iter_mut().zip(&x[from..]).zip(&y[from..]) {
            *to = (along.x * x + along.y * y + rise).abs().min(1.0);
        }
    }
}

impl Surface<'_> {
    /// Writes incidence and normals in these columns.
    #[inline(always)]
    fn write(&self, rays: &Rays, columns: Range<usize>, image: &mut ImagesMut<'_>) {
        if let Surface::Curved(body) = self {
            let rotation = body.pose.rotation.transpose() * rays.view.rotation;
            let origin = body.pose.inverse_point(rays.view.origin);
            for column in columns {
                let (start, direction) = rays.ray(column);
                let ray = Ray { origin: origin + rotation * start, direction: rotation * direction };
                let normal = normal(&body.solid, &ray, f64::from(image.depth[column]) * rays.inverse_length);
                let cosine = normal.dot(ray.direction) * rays.inverse_length;
                if let Some(incidence) = &mut image.incidence {
                    incidence[column] = cosine.abs().min(1.0) as f32;
                }
                if let Some(image) = &mut image.normal {
                    image[column] = towards(body.pose.rotation * normal, cosine);
                }
            }
            return;
        }
        if let Some(incidence) = &mut image.incidence {
            let to = &mut incidence[columns.clone()];
            match self {
                Surface::Flat(normal) => rays.cosines(*normal, columns.clone(), to),
                _ => to.fill(1.0),
            }
        }
        if let Some(image) = &mut image.normal {
            for column in columns {
                let (_, direction) = rays.ray(column);
                let normal = if let Surface::Flat(normal) = self { *normal } else { direction * rays.inverse_length };
                image[column] = towards(rays.view.rotation * normal, normal.dot(direction));
            }
        }
    }
}

/// A normal on the side that a ray comes from, given the cosine between both.
fn towards(normal: DVec3, cosine: f64) -> [f32; 3] {
    (if cosine > 0.0 { -normal } else { normal }).as_vec3().to_array()
}

/// The unit normal where a ray meets a solid in its frame, at about this distance.
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
        // The last plane that is crossed on the way in is that with the least 1 / t.
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
