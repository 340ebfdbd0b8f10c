//! A scene onto the pixels of a view, near bodies first.

use super::pixel_rect::PixelRect;
use super::rasterize_medium::Medium;
use super::rasterize_mesh::{PlacedMesh, TriangleColumns};
use super::rasterize_shape::rasterize_unresolved;
use super::rasterize_solid::rasterize_solid;
use super::ray_tests::UNBOUNDED;
use super::view::View;
use super::visibility_buffer::VisibilityBuffer;
use crate::Scene;
use crate::body::{Body, MeshBody, Solid};
use crate::medium::ScanKey;
use crate::packed::{ObbTable, Outline};
use crate::simd::{Lanes, Matrix, Vector, rows};

/// The state of rasterizing a view: kept from view to view, so that nothing is allocated.
#[derive(Default)]
pub(super) struct Rasterizer {
    pub(super) buffer: VisibilityBuffer,
    visible: Vec<VisiblePart>,
    centers: [Vec<f32>; 3],
    triangles: TriangleColumns,
}

/// A body, or a part of a mesh, that may be visible.
#[derive(Clone, Copy, Debug)]
struct VisiblePart {
    rect: PixelRect,
    body: u32,
    /// In a mesh: a group of meshlets or, numbered after those, a large triangle.
    part: u32,
}

impl Rasterizer {
    /// Rasterizes everything that may be visible; an id is the number of a body or, on request, of a surface.
    #[inline(always)]
    pub(super) fn rasterize<L: Lanes>(&mut self, scene: &Scene, view: &View, scan: &ScanKey, surfaces: bool) {
        let (bodies, table) = (scene.bodies(), scene.body_table());
        self.buffer.fit(view);
        self.visible.clear();
        for obbs in &table.obbs {
            self.find_bodies::<L>(obbs, bodies, view);
        }
        // Front to back: near bodies occlude far ones before those are processed. Equals go by number: the order of two
        // bodies, and with it every bit of the images, is the same for any cut of a scan into views.
        self.visible.sort_unstable_by_key(|part| (!part.rect.inverse_depth.to_bits(), part.body, part.part));
        for visible in &self.visible {
            if self.buffer.is_occluded::<L>(view, &visible.rect) {
                continue;
            }
            let body = &bodies[visible.body as usize];
            let id = if surfaces { table.surface(visible.body as usize) } else { visible.body };
            match &body.solid {
                // A ray may enter or leave at any triangle: all of them are needed at once.
                Solid::Mesh(_) if body.extinction.is_some() => {
                    rasterize_unresolved::<L>(&visible.rect, view, &mut self.buffer)
                }
                Solid::Mesh(mesh) => {
                    let (placed, ids) = (PlacedMesh::new(body, mesh, view), (id, u32::from(surfaces)));
                    let (part, groups) = (visible.part as usize, mesh.meshlets.group_aabbs.count);
                    if part < groups {
                        let to = (&mut self.buffer, &mut self.triangles);
                        mesh.meshlets.rasterize_group::<L>(part, &placed, ids, view, to);
                    } else {
                        let large = &mesh.meshlets.large[part - groups];
                        large.rasterize::<L>(&placed, ids, &visible.rect, view, &mut self.buffer);
                    }
                }
                solid => {
                    let medium = body.extinction.map(|extinction| {
                        let number = scene.media()[visible.body as usize];
                        let paths = scan.free_paths(number, extinction, body.pose.translation);
                        Medium { paths, mean: (1.0 / extinction) as f32 }
                    });
                    rasterize_solid::<L>(solid, &body.pose, (medium, id), &visible.rect, view, &mut self.buffer);
                }
            }
        }
    }

    #[inline(always)]
    fn find_bodies<L: Lanes>(&mut self, obbs: &ObbTable, bodies: &[Body], view: &View) {
        for k in 0..3 {
            // From the view's origin, in f64: the difference is exact at any distance from the scene's origin.
            self.centers[k].clear();
            self.centers[k].extend(obbs.center[k].iter().map(|x| (x - view.origin[k]) as f32));
        }
        let into_view = Matrix::splat(rows(&view.rotation.transpose()));
        for at in (0..obbs.bodies.len()).step_by(L::N) {
            let center = into_view.apply(Vector::<L>::load(&self.centers, at));
            let [x, y, z] = &obbs.half_axes;
            let axes = Matrix {
                x: into_view.apply(Vector::load(x, at)),
                y: into_view.apply(Vector::load(y, at)),
                z: into_view.apply(Vector::load(z, at)),
            };
            let bounds = view.bounds(center, &axes, obbs.outline);
            for (lane, rect) in bounds.rects(obbs.bodies.len() - at, view).iter() {
                let body = obbs.bodies[at + lane];
                match &bodies[body as usize] {
                    // A mesh of one part fills the tested box.
                    Body { solid: Solid::Mesh(mesh), extinction, .. }
                        if mesh.meshlets.parts() != 1 || extinction.is_some() =>
                    {
                        self.find_parts::<L>(body, &bodies[body as usize], mesh, view);
                    }
                    _ => self.visible.push(VisiblePart { rect, body, part: 0 }),
                }
            }
        }
    }

    #[inline(always)]
    fn find_parts<L: Lanes>(&mut self, number: u32, body: &Body, mesh: &MeshBody, view: &View) {
        let placed = PlacedMesh::new(body, mesh, view);
        // Rays that start in a medium interact with it before they meet its surface.
        let shift = view.motion.as_ref().map_or(0.0, |motion| f64::from(motion.shift));
        let within = body.extinction.is_some() && body.bounds().grown(shift + 1e-3).contains(view.origin);
        let mut part = 0;
        for boxes in [&mesh.meshlets.group_aabbs, &mesh.meshlets.large_aabbs] {
            for at in (0..boxes.count).step_by(L::N) {
                let (center, axes) = placed.boxes::<L>(boxes, at);
                let bounds = view.bounds(center, &axes, Outline::Box);
                for (lane, mut rect) in bounds.rects(boxes.count - at, view).iter() {
                    rect.inverse_depth = if within { UNBOUNDED } else { rect.inverse_depth };
                    self.visible.push(VisiblePart { rect, body: number, part: part + (at + lane) as u32 });
                }
            }
            part += boxes.count as u32;
        }
    }
}
