//! A scene onto the pixels of a view, near things first.

use glam::DVec3;

use super::bounds::{Area, Outline};
use super::draw::{Canvas, draw, draw_doubt};
use super::lanes::Lanes;
use super::solids::{self, Local};
use super::stage::{Hulls, Stage};
use super::triangles::{Placed, Ready};
use super::vector::{Matrix, Vector, rows};
use super::view::View;
use crate::body::{Body, Place, Solid};
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Rectangle};

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
    pub(super) fn paint<L: Lanes>(&mut self, bodies: &[Body], stage: &Stage, view: &View, surfaces: bool) {
        self.canvas.fit(view);
        self.order.clear();
        for hulls in &stage.hulls {
            self.find_solids::<L>(hulls, view);
        }
        for &body in &stage.meshes {
            self.find_parts::<L>(body, &bodies[body], view);
        }
        // Near things hide far ones without their being looked at. Equals go by number: the order of two bodies, and with
        // it every bit of the images, is the same however a scan is cut into views.
        self.order.sort_unstable_by_key(|seen| (!seen.area.near.to_bits(), seen.body, seen.part));
        for seen in &self.order {
            if self.canvas.hides::<L>(view, &seen.area) {
                continue;
            }
            let body = &bodies[seen.body as usize];
            let id = if surfaces { stage.surface(seen.body as usize) } else { seen.body };
            match &body.solid {
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
                solid => draw_solid::<L>(solid, &body.place, id, seen, view, &mut self.canvas),
            }
        }
    }

    #[inline(always)]
    fn find_solids<L: Lanes>(&mut self, hulls: &Hulls, view: &View) {
        for k in 0..3 {
            // From the view's origin, in f64: what is left is exact however far from the scene's origin both are.
            self.centers[k].clear();
            self.centers[k].extend(hulls.center[k].iter().map(|x| (x - view.origin[k]) as f32));
        }
        let into_view = Matrix::splat(rows(&view.rotation.transpose()));
        for at in (0..hulls.bodies.len()).step_by(L::N) {
            let center = into_view.apply(Vector::<L>::load(&self.centers, at));
            let [x, y, z] = &hulls.axes;
            let axes = Matrix {
                x: into_view.apply(Vector::load(x, at)),
                y: into_view.apply(Vector::load(y, at)),
                z: into_view.apply(Vector::load(z, at)),
            };
            let bounds = view.bounds(center, &axes, hulls.outline);
            let bodies = &hulls.bodies[at..];
            for (lane, area) in bounds.listed(bodies.len()).seen() {
                self.order.push(Seen { area, body: bodies[lane], part: 0 });
            }
        }
    }

    #[inline(always)]
    fn find_parts<L: Lanes>(&mut self, number: usize, body: &Body, view: &View) {
        let Solid::Mesh(mesh) = &body.solid else { return };
        let placed = Placed::new(&body.place, view);
        let mut part = 0;
        for boxes in [&mesh.blocks.group_boxes, &mesh.blocks.large_boxes] {
            for at in (0..boxes.count).step_by(L::N) {
                let (center, axes) = placed.boxes::<L>(boxes, at);
                let bounds = view.bounds(center, &axes, Outline::Box);
                for (lane, area) in bounds.listed(boxes.count - at).seen() {
                    self.order.push(Seen { area, body: number as u32, part: part + (at + lane) as u32 });
                }
            }
            part += boxes.count as u32;
        }
    }
}

/// Draws a body, if f32 can tell what rays from near the view's origin see of it.
#[inline(always)]
fn draw_solid<L: Lanes>(solid: &Solid, place: &Place, id: u32, seen: &Seen, view: &View, canvas: &mut Canvas) {
    let shift = view.motion.as_ref().map_or(0.0, |motion| f64::from(motion.shift));
    let origin = place.inward(view.origin);
    let axes = rows(&(place.rotation.transpose() * view.rotation));
    let local = |half: DVec3| Local {
        axes,
        origin: origin.as_vec3().to_array(),
        half: half.as_vec3().to_array(),
        rounding: view.rounding,
    };
    let area = &seen.area;
    // Whether rays may start on the surface, or in the plane of a face.
    let touches = |place: f64, size: f64| (place.abs() - size).abs() <= 1e-6 * (place.abs() + size) + 4.0 * shift;
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
        Solid::Cuboid(Cuboid { half }) if !(0..3).any(|k| touches(origin[k], half[k])) => {
            if origin.abs().cmplt(*half).all() {
                draw::<L>(&solids::Cuboid::<true>(local(*half)), id, area, view, canvas);
            } else {
                draw::<L>(&solids::Cuboid::<false>(local(*half)), id, area, view, canvas);
            }
        }
        Solid::Ellipsoid(Ellipsoid { radii }) if !touches_unit(origin / *radii, 4.0 * shift / radii.min_element()) => {
            draw::<L>(&solids::Ellipsoid(local(*radii)), id, area, view, canvas);
        }
        Solid::Cylinder(Cylinder { half }) if !touches(origin.z, half.z) => {
            let across = (origin / *half).with_z(0.0);
            let inside = across.length() < 1.0 && origin.z.abs() < half.z;
            if inside || touches_unit(across, 4.0 * shift / half.x.min(half.y)) {
                draw_doubt::<L>(area, view, canvas);
            } else {
                draw::<L>(&solids::Cylinder(local(*half)), id, area, view, canvas);
            }
        }
        Solid::Rectangle(Rectangle { half }) if origin.z.abs() > 1e-6 * half.max_element() + 4.0 * shift => {
            draw::<L>(&solids::Rectangle(local(half.extend(0.0))), id, area, view, canvas);
        }
        _ => draw_doubt::<L>(area, view, canvas),
    }
}

/// Whether rays may start on the unit ball; near it, roots cancel.
fn touches_unit(place: DVec3, shift: f64) -> bool {
    (place.length() - 1.0).abs() <= 1e-3 + shift
}
