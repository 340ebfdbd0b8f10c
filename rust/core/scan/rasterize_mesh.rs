//! Meshes onto pixels: the triangles of a meshlet are bounded and their tests made together, one to a lane.

use glam::{DMat3, DVec3, Vec2};

use super::pixel_rect::PixelRect;
use super::rasterize_shape::{rasterize_shape, rasterize_still};
use super::ray_tests::{Facet, Triangle, TriangleTest};
use super::small_triangles::SmallTriangles;
use super::view::View;
use super::visibility_buffer::VisibilityBuffer;
use crate::body::{Body, MeshBody};
use crate::packed::{AabbTable, GROUP_SIZE, LargeTriangle, Meshlets, Outline};
use crate::simd::{Lanes, Mask, Matrix, Vector, WIDEST, rows};

/// The pose of a mesh in a view.
pub(super) struct PlacedMesh {
    /// The axes of the view, as rows in the frame of the mesh.
    rows: [[f32; 3]; 3],
    offset: [f32; 3],
    /// Set if faces that point away are left out: others occlude them. Rays start no further than this from the origin
    /// [m].
    culled: Option<f32>,
    /// Both again, for exact computations.
    into_view: DMat3,
    origin: DVec3,
}

/// The middle of a meshlet in the view, the direction to it along the horizon, and its column.
pub(super) struct MeshletCenter {
    /// The largest inverse depth of its corners [1/m].
    pub(super) inverse_depth: f32,
    center: [f32; 3],
    pub(super) heading: [f32; 2],
    pub(super) column: f32,
    /// The largest coordinate on the way to its corners, except the middle's own, which comes from f64 [m].
    pub(super) reach: f32,
}

impl PlacedMesh {
    pub(super) fn new(body: &Body, mesh: &MeshBody, view: &View) -> PlacedMesh {
        let shift = view.motion.as_ref().map_or(0.0, |motion| motion.shift);
        let within = body.bounds().grown(f64::from(shift) + 1e-3).contains(view.origin);
        let pose = &body.pose;
        let into_view = view.rotation.transpose();
        let offset = into_view * (pose.translation - view.origin);
        let into_view = into_view * pose.rotation;
        let culled = (mesh.outward && !within).then_some(shift);
        PlacedMesh { rows: rows(&into_view), offset: offset.as_vec3().to_array(), culled, into_view, origin: offset }
    }

    /// Middles and half axes of boxes from `at` on, in the view.
    #[inline(always)]
    pub(super) fn boxes<L: Lanes>(&self, boxes: &AabbTable, at: usize) -> (Vector<L>, Matrix<L>) {
        let rows = Matrix::<L>::splat(self.rows);
        let center = rows.apply(Vector::load(&boxes.center, at)) + Vector::splat(self.offset);
        let half = Vector::load(&boxes.half, at);
        let axes = Matrix {
            x: Vector::new(rows.x.x, rows.y.x, rows.z.x) * half.x,
            y: Vector::new(rows.x.y, rows.y.y, rows.z.y) * half.y,
            z: Vector::new(rows.x.z, rows.y.z, rows.z.z) * half.z,
        };
        (center, axes)
    }
}

impl Meshlets {
    /// Rasterizes the triangles of a group; `first` and `step` make ids from their numbers.
    #[inline(always)]
    pub(super) fn rasterize_group<L: Lanes>(
        &self,
        group: usize,
        placed: &PlacedMesh,
        ids: (u32, u32),
        view: &View,
        (buffer, triangles): (&mut VisibilityBuffer, &mut TriangleColumns),
    ) {
        let end = self.meshlets.len().min((group + 1) * GROUP_SIZE);
        for at in (group * GROUP_SIZE..end).step_by(L::N) {
            let (center, axes) = placed.boxes::<L>(&self.meshlet_aabbs, at);
            let bounds = view.bounds(center, &axes, Outline::Box);
            let mut centers = [[0.0; WIDEST]; 3];
            center.store(&mut centers);
            let mut rects = bounds.rects(end - at, view);
            if let Some(shift) = placed.culled {
                rects.remove(self.looking_away::<L>(at, placed, center, shift));
            }
            for (lane, rect) in rects.iter() {
                if !buffer.is_occluded::<L>(view, &rect) {
                    let rough = Vec2::new(centers[0][lane], centers[1][lane]);
                    let middle = MeshletCenter::new(placed, &self.meshlet_aabbs, at + lane, rough, &rect);
                    self.rasterize_meshlet::<L>(at + lane, placed, &middle, ids, view, (buffer, triangles));
                }
            }
        }
    }

    /// The meshlets from `at` on, at these centers in the view, all of whose triangles certainly point away from the
    /// start of the rays; one bit each.
    #[inline(always)]
    fn looking_away<L: Lanes>(&self, at: usize, placed: &PlacedMesh, center: Vector<L>, shift: f32) -> u32 {
        let axis = Matrix::splat(placed.rows).apply(Vector::<L>::load(&self.normal_axes, at));
        let (distance, sine) = (center.length(), L::load(&self.normal_sines, at));
        // No normal of the cone has a smaller product with the centre than axis . centre - sine * distance, and no point
        // of the box is further from it than half its diagonal.
        let radius = L::load(&self.meshlet_aabbs.size, at).mul_add(L::splat(0.501), L::splat(shift));
        axis.dot(center).gt(distance.mul_add(sine + L::splat(1e-4), radius)).bits()
    }

    #[inline(always)]
    fn rasterize_meshlet<L: Lanes>(
        &self,
        number: usize,
        placed: &PlacedMesh,
        middle: &MeshletCenter,
        (first, step): (u32, u32),
        view: &View,
        (buffer, triangles): (&mut VisibilityBuffer, &mut TriangleColumns),
    ) {
        let meshlet = &self.meshlets[number];
        let (rows, center) = (Matrix::splat(placed.rows), Vector::<L>::splat(middle.center));
        for at in (0..meshlet.count).step_by(L::N) {
            let [a, b, c] = &meshlet.corners;
            let corners = [
                rows.apply(Vector::load(a, at)) + center,
                rows.apply(Vector::load(b, at)) + center,
                rows.apply(Vector::load(c, at)) + center,
            ];
            let bounds = view.triangle_bounds(&corners, middle);
            let mut rects = bounds.rects(meshlet.count - at, view);
            if rects.is_empty() {
                continue;
            }
            let test = TriangleTest::new(corners, L::splat(middle.reach), view.rounding);
            if let Some(shift) = placed.culled {
                rects.remove(test.looks_away(&corners, shift).bits());
                if rects.is_empty() {
                    continue;
                }
            }
            let ids = &meshlet.triangles[at..at + L::N];
            let small = SmallTriangles { test, corners, reach: middle.reach, numbers: ids, first, step };
            rects.remove(small.rasterize(&bounds, &rects, view, buffer));
            if rects.is_empty() {
                continue;
            }
            if let Some(motion) = &view.motion {
                triangles.store_corners(&corners);
                for (lane, rect) in rects.iter() {
                    let triangle = triangles.triangle(lane, middle.reach + 2.0 * motion.shift, view);
                    rasterize_shape::<L>(&triangle, first + step * ids[lane], &rect, view, buffer);
                }
            } else {
                triangles.store_tests(&test);
                for (lane, rect) in rects.iter() {
                    let (test, id) = (triangles.test(lane), first + step * ids[lane]);
                    rasterize_still::<L>(&test, id, &rect, view, buffer);
                }
            }
        }
    }
}

impl LargeTriangle {
    /// Rasterizes the triangle.
    #[inline(always)]
    pub(super) fn rasterize<L: Lanes>(
        &self,
        placed: &PlacedMesh,
        (first, step): (u32, u32),
        rect: &PixelRect,
        view: &View,
        buffer: &mut VisibilityBuffer,
    ) {
        let [a, b, c] = self.corners.map(|corner| placed.into_view * corner + placed.origin);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let height = normal.dot(a);
        let reach = a.length().max(b.length()).max(c.length());
        let shift = view.motion.as_ref().map_or(0.0, |motion| motion.shift);
        let facet = Facet {
            corners: [a, b, c].map(|corner| corner.as_vec3().to_array()),
            normal: normal.as_vec3().to_array(),
            height: height as f32,
            reach: reach as f32 + 2.0 * shift,
            shift,
            rounding: view.rounding,
        };
        rasterize_shape::<L>(&facet, first + step * self.triangle, rect, view, buffer);
    }
}

impl MeshletCenter {
    /// `rough` is the middle from the bounds, in f32: the column of `rect` is that of its heading.
    fn new(placed: &PlacedMesh, boxes: &AabbTable, meshlet: usize, rough: Vec2, rect: &PixelRect) -> MeshletCenter {
        let [x, y, z] = &boxes.center;
        let center = DVec3::new(f64::from(x[meshlet]), f64::from(y[meshlet]), f64::from(z[meshlet]));
        let center = (placed.into_view * center + placed.origin).as_vec3();
        let ground = rough.length();
        // Straight above or below, any heading will do.
        let heading = if ground > 1e-12 { rough / ground } else { Vec2::X };
        MeshletCenter {
            inverse_depth: rect.inverse_depth,
            center: center.to_array(),
            heading: heading.to_array(),
            column: rect.middle,
            reach: center.length() + boxes.size[meshlet],
        }
    }
}

/// The tests of the triangles of a meshlet, and their corners, as columns of numbers.
#[derive(Default)]
pub(super) struct TriangleColumns {
    rows: [[[f32; WIDEST]; 3]; 4],
    edge_error: [f32; WIDEST],
    plane_error: [f32; WIDEST],
    height_error: [f32; WIDEST],
    corners: [[[f32; WIDEST]; 3]; 3],
}

impl TriangleColumns {
    #[inline(always)]
    fn store_tests<L: Lanes>(&mut self, test: &TriangleTest<L>) {
        for (columns, row) in self.rows.iter_mut().zip(test.rows) {
            row.store(columns);
        }
        test.edge_error.store(&mut self.edge_error, 0);
        test.plane_error.store(&mut self.plane_error, 0);
        test.height_error.store(&mut self.height_error, 0);
    }

    #[inline(always)]
    fn store_corners<L: Lanes>(&mut self, corners: &[Vector<L>; 3]) {
        for (columns, corner) in self.corners.iter_mut().zip(corners) {
            corner.store(columns);
        }
    }

    #[inline(always)]
    fn test<L: Lanes>(&self, lane: usize) -> TriangleTest<L> {
        let [a, b, c, d] = &self.rows;
        TriangleTest {
            rows: [
                Vector::splat(at(a, lane)),
                Vector::splat(at(b, lane)),
                Vector::splat(at(c, lane)),
                Vector::splat(at(d, lane)),
            ],
            edge_error: L::splat(self.edge_error[lane]),
            plane_error: L::splat(self.plane_error[lane]),
            height_error: L::splat(self.height_error[lane]),
        }
    }

    fn triangle(&self, lane: usize, reach: f32, view: &View) -> Triangle {
        let [a, b, c] = &self.corners;
        Triangle { corners: [at(a, lane), at(b, lane), at(c, lane)], reach, rounding: view.rounding }
    }
}

/// One vector of columns of coordinates.
#[inline(always)]
fn at([x, y, z]: &[[f32; WIDEST]; 3], lane: usize) -> [f32; 3] {
    [x[lane], y[lane], z[lane]]
}
