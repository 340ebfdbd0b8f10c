//! A scene onto the pixels of a view, near things first.

use glam::DVec3;

use super::bounds::{Area, TOUCHING};
use super::draw::{Canvas, draw, draw_doubt};
use super::porous::{Medium, draw_medium};
use super::solids::{self, Local, Porous, Shape};
use super::triangles::{Placed, Ready};
use super::view::View;
use crate::Scene;
use crate::body::{Body, MeshBody, Place, Solid};
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Rectangle};
use crate::packed::{ObbTable, Outline};
use crate::simd::{Lanes, Matrix, Vector, rows};

/// What paints a view: kept from view to view, so that nothing is allocated.
#[derive(Default)]
pub(super) struct Painter {
    pub(super) canvas: Canvas,
    order: Vec<Seen>,
    centers: [Vec<f32>; 3],
    ready: Ready,
}

/// A body, or a part of a mesh, that may be seen.
#[derive(Clone, Copy, Debug)]
struct Seen {
    area: Area,
    body: u32,
    /// Of a mesh: a group of blocks or, counted on from those, a large triangle.
    part: u32,
}

impl Painter {
    /// Draws all that the view may see; an id is the number of a body or, if asked for, of a surface.
    #[inline(always)]
    pub(super) fn paint<L: Lanes>(&mut self, scene: &Scene, view: &View, seed: u64, surfaces: bool) {
        let (bodies, table) = (scene.bodies(), scene.body_table());
        self.canvas.fit(view);
        self.order.clear();
        for obbs in &table.obbs {
            self.find::<L>(obbs, bodies, view);
        }
        // Near things hide far ones without their being looked at. Equals go by number: the order of two bodies, and with
        // it every bit of the images, is the same however a scan is cut into views.
        self.order.sort_unstable_by_key(|seen| (!seen.area.near.to_bits(), seen.body, seen.part));
        for seen in &self.order {
            if self.canvas.hides::<L>(view, &seen.area) {
                continue;
            }
            let body = &bodies[seen.body as usize];
            let id = if surfaces { table.surface(seen.body as usize) } else { seen.body };
            match &body.solid {
                // Every triangle may be where a ray enters or leaves: that takes all of them at once.
                Solid::Mesh(_) if body.extinction.is_some() => draw_doubt::<L>(&seen.area, view, &mut self.canvas),
                Solid::Mesh(mesh) => {
                    let (placed, ids) = (Placed::new(&body.place, view), (id, u32::from(surfaces)));
                    let (part, groups) = (seen.part as usize, mesh.blocks.group_boxes.count);
                    if part < groups {
                        let to = (&mut self.canvas, &mut self.ready);
                        mesh.blocks.draw_group::<L>(part, &placed, ids, view, to);
                    } else {
                        let large = &mesh.blocks.large[part - groups];
                        large.draw::<L>(&placed, ids, &seen.area, view, &mut self.canvas);
                    }
                }
                solid => {
                    let mean = body.extinction.map(|extinction| (1.0 / extinction) as f32);
                    let medium = mean.map(|mean| Medium { seed, body: seen.body, mean });
                    draw_solid::<L>(solid, &body.place, (medium, id), &seen.area, view, &mut self.canvas);
                }
            }
        }
    }

    #[inline(always)]
    fn find<L: Lanes>(&mut self, obbs: &ObbTable, bodies: &[Body], view: &View) {
        for k in 0..3 {
            // From the view's origin, in f64: what is left is exact however far from the scene's origin both are.
            self.centers[k].clear();
            self.centers[k].extend(obbs.center[k].iter().map(|x| (x - view.origin[k]) as f32));
        }
        let into_view = Matrix::splat(rows(&view.rotation.transpose()));
        for at in (0..obbs.bodies.len()).step_by(L::N) {
            let center = into_view.apply(Vector::<L>::load(&self.centers, at));
            let [x, y, z] = &obbs.axes;
            let axes = Matrix {
                x: into_view.apply(Vector::load(x, at)),
                y: into_view.apply(Vector::load(y, at)),
                z: into_view.apply(Vector::load(z, at)),
            };
            let bounds = view.bounds(center, &axes, obbs.outline);
            for (lane, area) in bounds.listed(obbs.bodies.len() - at).seen() {
                let body = obbs.bodies[at + lane];
                match &bodies[body as usize] {
                    // A mesh of one part fills the box that was looked at.
                    Body { solid: Solid::Mesh(mesh), extinction, .. }
                        if mesh.blocks.parts() != 1 || extinction.is_some() =>
                    {
                        self.find_parts::<L>(body, &bodies[body as usize], mesh, view);
                    }
                    _ => self.order.push(Seen { area, body, part: 0 }),
                }
            }
        }
    }

    #[inline(always)]
    fn find_parts<L: Lanes>(&mut self, number: u32, body: &Body, mesh: &MeshBody, view: &View) {
        let placed = Placed::new(&body.place, view);
        // Rays that start in a medium come to rest before they meet its surface.
        let shift = view.motion.as_ref().map_or(0.0, |motion| f64::from(motion.shift));
        let within = body.extinction.is_some() && body.bounds().grown(shift + 1e-3).contains(view.origin);
        let mut part = 0;
        for boxes in [&mesh.blocks.group_boxes, &mesh.blocks.large_boxes] {
            for at in (0..boxes.count).step_by(L::N) {
                let (center, axes) = placed.boxes::<L>(boxes, at);
                let bounds = view.bounds(center, &axes, Outline::Box);
                for (lane, mut area) in bounds.listed(boxes.count - at).seen() {
                    area.near = if within { TOUCHING } else { area.near };
                    self.order.push(Seen { area, body: number, part: part + (at + lane) as u32 });
                }
            }
            part += boxes.count as u32;
        }
    }
}

/// Draws a body, if f32 can tell what rays from near the view's origin see of it.
#[inline(always)]
fn draw_solid<L: Lanes>(
    solid: &Solid,
    place: &Place,
    (medium, id): (Option<Medium>, u32),
    area: &Area,
    view: &View,
    canvas: &mut Canvas,
) {
    let shift = view.motion.as_ref().map_or(0.0, |motion| f64::from(motion.shift));
    let origin = place.inward(view.origin);
    let axes = rows(&(place.rotation.transpose() * view.rotation));
    let local = |half: DVec3| Local {
        axes,
        origin: origin.as_vec3().to_array(),
        half: half.as_vec3().to_array(),
        rounding: view.rounding,
        shift: shift as f32,
    };
    // Whether all rays start beyond the planes of two faces, or all between them.
    let slack = |place: f64, size: f64| 2e-6 * (place.abs() + size) + 4.0 * shift;
    let beyond = |place: f64, size: f64| place.abs() - size > slack(place, size);
    let between = |place: f64, size: f64| size - place.abs() > slack(place, size);
    // What is too thin for f32: its scale overflows, or drowns the direction across it.
    let slight = |half: DVec3| {
        let thin = half.min_element();
        thin < 1e-4 * half.max_element() || thin < 1e-15 * f64::from(view.band.steepest)
    };
    match solid {
        Solid::Cuboid(Cuboid { half }) if half.min_element() < 1e-30 => draw_doubt::<L>(area, view, canvas),
        Solid::Ellipsoid(Ellipsoid { radii: half }) | Solid::Cylinder(Cylinder { half }) if slight(*half) => {
            draw_doubt::<L>(area, view, canvas);
        }
        Solid::Cuboid(Cuboid { half }) if (0..3).all(|k| between(origin[k], half[k])) => {
            put::<L, _>(&solids::Cuboid::<true>(local(*half)), (medium, id), area, view, canvas);
        }
        Solid::Cuboid(Cuboid { half }) if (0..3).any(|k| beyond(origin[k], half[k])) => {
            put::<L, _>(&solids::Cuboid::<false>(local(*half)), (medium, id), area, view, canvas);
        }
        Solid::Ellipsoid(Ellipsoid { radii }) if !touches_unit(origin / *radii, 4.0 * shift / radii.min_element()) => {
            put::<L, _>(&solids::Ellipsoid(local(*radii)), (medium, id), area, view, canvas);
        }
        Solid::Cylinder(Cylinder { half }) => {
            let across = (origin / *half).with_z(0.0);
            // Where rays start over or under it, or in it.
            let settled =
                across.length() > 1.0 || beyond(origin.z, half.z) || medium.is_some() && between(origin.z, half.z);
            if settled && !touches_unit(across, 4.0 * shift / half.x.min(half.y)) {
                put::<L, _>(&solids::Cylinder(local(*half)), (medium, id), area, view, canvas);
            } else {
                draw_doubt::<L>(area, view, canvas);
            }
        }
        Solid::Rectangle(Rectangle { half }) if origin.z.abs() > 1e-6 * half.max_element() + 4.0 * shift => {
            draw::<L>(&solids::Rectangle(local(half.extend(0.0))), id, area, view, canvas);
        }
        _ => draw_doubt::<L>(area, view, canvas),
    }
}

/// Draws a shape, solid or porous.
#[inline(always)]
fn put<L: Lanes, S: Shape>(
    shape: &S,
    (medium, id): (Option<Medium>, u32),
    area: &Area,
    view: &View,
    canvas: &mut Canvas,
) where
    S::Seen<L>: Porous<L>,
{
    match medium {
        Some(medium) => draw_medium::<L, S>(shape, medium, id, area, view, canvas),
        None => draw::<L>(shape, id, area, view, canvas),
    }
}

/// Whether rays may start on the unit ball; near it, roots cancel.
fn touches_unit(place: DVec3, shift: f64) -> bool {
    (place.length() - 1.0).abs() <= 1e-3 + shift
}
