//! Meshes onto pixels: the triangles of a block are bounded and made ready together, one to a lane.

use glam::{DMat3, DVec3, Vec2};

use super::bounds::{Area, Bounds, TOUCHING};
use super::draw::{Canvas, draw, draw_seen};
use super::solids::{Facet, SeenTriangle, Triangle};
use super::specks::Specks;
use super::view::View;
use crate::body::Place;
use crate::packed::{Blocks, Boxes, Large, Outline, SIDE, SWEEPS};
use crate::simd::{Lanes, Mask, Matrix, Vector, WIDEST, arctangent, rows, small_arctangent};

/// Where a mesh stands in a view.
pub(super) struct Placed {
    /// The axes of the view, as rows in the frame of the mesh.
    rows: [[f32; 3]; 3],
    offset: [f32; 3],
    /// Both again, for what must be exact.
    into_view: DMat3,
    origin: DVec3,
}

/// The middle of a block in the view, the direction to it along the horizon, and its column.
struct Middle {
    /// No corner is nearer than this [1/m].
    near: f32,
    center: [f32; 3],
    heading: [f32; 2],
    column: f32,
    /// No coordinate on the way to its corners is larger, but for the middle's own, which comes from f64 [m].
    reach: f32,
}

impl Placed {
    pub(super) fn new(place: &Place, view: &View) -> Placed {
        let into_view = view.rotation.transpose();
        let offset = into_view * (place.center - view.origin);
        let into_view = into_view * place.rotation;
        Placed { rows: rows(&into_view), offset: offset.as_vec3().to_array(), into_view, origin: offset }
    }

    /// Middles and half axes of boxes from `at` on, in the view.
    #[inline(always)]
    pub(super) fn boxes<L: Lanes>(&self, boxes: &Boxes, at: usize) -> (Vector<L>, Matrix<L>) {
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

impl Blocks {
    /// Draws the triangles of a group; `first` and `step` make ids from their numbers.
    #[inline(always)]
    pub(super) fn draw_group<L: Lanes>(
        &self,
        group: usize,
        placed: &Placed,
        ids: (u32, u32),
        view: &View,
        (canvas, ready): (&mut Canvas, &mut Ready),
    ) {
        let end = self.blocks.len().min((group + 1) * SIDE);
        for at in (group * SIDE..end).step_by(L::N) {
            let (center, axes) = placed.boxes::<L>(&self.block_boxes, at);
            let bounds = view.bounds(center, &axes, Outline::Box);
            let mut centers = [[0.0; WIDEST]; 3];
            center.store(&mut centers);
            for (lane, area) in bounds.listed(end - at).seen() {
                if !canvas.hides::<L>(view, &area) {
                    let rough = Vec2::new(centers[0][lane], centers[1][lane]);
                    let middle = Middle::new(placed, &self.block_boxes, at + lane, rough, &area);
                    self.draw_block::<L>(at + lane, placed, &middle, ids, view, (canvas, ready));
                }
            }
        }
    }

    #[inline(always)]
    fn draw_block<L: Lanes>(
        &self,
        number: usize,
        placed: &Placed,
        middle: &Middle,
        (first, step): (u32, u32),
        view: &View,
        (canvas, ready): (&mut Canvas, &mut Ready),
    ) {
        let block = &self.blocks[number];
        let (rows, center) = (Matrix::splat(placed.rows), Vector::<L>::splat(middle.center));
        for at in (0..block.count).step_by(L::N) {
            let [a, b, c] = &block.corners;
            let corners = [
                rows.apply(Vector::load(a, at)) + center,
                rows.apply(Vector::load(b, at)) + center,
                rows.apply(Vector::load(c, at)) + center,
            ];
            let bounds = view.triangle_bounds(&corners, middle);
            let mut listed = bounds.listed(block.count - at);
            if listed.is_empty() {
                continue;
            }
            let seen = SeenTriangle::new(corners, L::splat(middle.reach), view.rounding);
            let ids = &block.triangles[at..at + L::N];
            let specks = Specks { seen, corners, reach: middle.reach, numbers: ids, first, step };
            listed.drop(specks.draw(&bounds, &listed, view, canvas));
            if listed.is_empty() {
                continue;
            }
            if let Some(motion) = &view.motion {
                ready.keep_corners(&corners);
                for (lane, area) in listed.seen() {
                    let triangle = ready.triangle(lane, middle.reach + 2.0 * motion.shift, view);
                    draw::<L>(&triangle, first + step * ids[lane], &area, view, canvas);
                }
            } else {
                ready.keep(&seen);
                for (lane, area) in listed.seen() {
                    let (seen, id) = (ready.seen(lane), first + step * ids[lane]);
                    // Most patterns have one sweep, whose products then stay in registers.
                    if view.band.count == 1 {
                        draw_seen::<L, 1>(&seen, id, &area, view, canvas);
                    } else {
                        draw_seen::<L, SWEEPS>(&seen, id, &area, view, canvas);
                    }
                }
            }
        }
    }
}

impl Large {
    /// Draws the triangle.
    #[inline(always)]
    pub(super) fn draw<L: Lanes>(
        &self,
        placed: &Placed,
        (first, step): (u32, u32),
        area: &Area,
        view: &View,
        canvas: &mut Canvas,
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
        draw::<L>(&facet, first + step * self.triangle, area, view, canvas);
    }
}

impl Middle {
    /// `rough` is where the bounds had the middle, in f32: the column of `area` is that of the heading to there.
    fn new(placed: &Placed, boxes: &Boxes, block: usize, rough: Vec2, area: &Area) -> Middle {
        let [x, y, z] = &boxes.center;
        let center = DVec3::new(f64::from(x[block]), f64::from(y[block]), f64::from(z[block]));
        let center = (placed.into_view * center + placed.origin).as_vec3();
        let ground = rough.length();
        // Straight above or below, any heading will do.
        let heading = if ground > 1e-12 { rough / ground } else { Vec2::X };
        Middle {
            near: area.near,
            center: center.to_array(),
            heading: heading.to_array(),
            column: (area.low + area.high) / 2.0,
            reach: center.length() + boxes.size[block],
        }
    }
}

/// The tests of the triangles of a block, and their corners, as columns of numbers.
#[derive(Default)]
pub(super) struct Ready {
    rows: [[[f32; WIDEST]; 3]; 4],
    edge_error: [f32; WIDEST],
    plane_error: [f32; WIDEST],
    height_error: [f32; WIDEST],
    corners: [[[f32; WIDEST]; 3]; 3],
}

impl Ready {
    #[inline(always)]
    fn keep<L: Lanes>(&mut self, seen: &SeenTriangle<L>) {
        for (columns, row) in self.rows.iter_mut().zip(seen.rows) {
            row.store(columns);
        }
        seen.edge_error.store(&mut self.edge_error, 0);
        seen.plane_error.store(&mut self.plane_error, 0);
        seen.height_error.store(&mut self.height_error, 0);
    }

    #[inline(always)]
    fn keep_corners<L: Lanes>(&mut self, corners: &[Vector<L>; 3]) {
        for (columns, corner) in self.corners.iter_mut().zip(corners) {
            corner.store(columns);
        }
    }

    #[inline(always)]
    fn seen<L: Lanes>(&self, lane: usize) -> SeenTriangle<L> {
        let [a, b, c, d] = &self.rows;
        SeenTriangle {
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

#[inline(always)]
fn least<L: Lanes>([a, b, c]: [L; 3]) -> L {
    a.min(b).min(c)
}

#[inline(always)]
fn most<L: Lanes>([a, b, c]: [L; 3]) -> L {
    a.max(b).max(c)
}

/// Triangles from an observer who looks along some heading.
struct Facing<L: Lanes> {
    /// Tangents of the azimuths, to the left of the heading.
    left: L,
    right: L,
    first: L,
    last: L,
    /// Where the triangle lies before the observer, within 45 degrees of the heading.
    simple: L::Mask,
}

impl View<'_> {
    /// Bounds of triangles close to a point.
    #[inline(always)]
    fn triangle_bounds<L: Lanes>(&self, corners: &[Vector<L>; 3], middle: &Middle) -> Bounds<L> {
        let splat = L::splat;
        let (near, slack) = (splat(middle.near), self.slack(splat(middle.reach)));
        let facing = self.facing(corners, (splat(middle.heading[0]), splat(middle.heading[1])), slack);
        let Facing { first, last, simple, .. } = facing;
        let (low, high) = self.columns_of(&facing, splat(middle.column));
        // Far away most triangles lie between two columns, or between two rows.
        let between = splat(self.band.turn.fract()).gt(splat(0.0));
        let seen = last.ge(first) & (high.floor().ge(low) | between) & self.shows(low, high);
        if simple.all() {
            return Bounds { near, low, high, first, last, seen };
        }
        // What is close and lies aside of the point, or behind: each along its own heading.
        let [a, b, c] = corners;
        let (x, y) = (a.x + b.x + c.x, a.y + b.y + c.y);
        let inverse = splat(1.0) / x.mul_add(x, y * y).sqrt().max(splat(1e-20));
        let (cos, sin) = (x * inverse, y * inverse);
        let own = self.facing(corners, (cos, sin), slack);
        let (own_low, own_high) = self.columns_of(&own, self.column(arctangent(sin, cos)));
        // And what is around the observer, by height and distance alone.
        let (far_first, far_last) = self.rows_around(corners, slack);
        let turn = splat(self.band.turn);
        let first = L::select(simple, first, L::select(own.simple, own.first, far_first));
        let last = L::select(simple, last, L::select(own.simple, own.last, far_last));
        let low = L::select(simple, low, L::select(own.simple, own_low, -turn));
        let high = L::select(simple, high, L::select(own.simple, own_high, turn));
        let seen = last.ge(first) & (high.floor().ge(low) | between) & self.shows(low, high);
        Bounds { near, low, high, first, last, seen }
    }

    /// In the frame that looks along a heading a corner has the tangents v / u and z / u, and so a triangle that lies before
    /// the observer is bounded by those of its corners. The slope of a point is its z / u times the cosine of its azimuth.
    #[inline(always)]
    fn facing<L: Lanes>(&self, [a, b, c]: &[Vector<L>; 3], (cos, sin): (L, L), slack: L) -> Facing<L> {
        let (zero, one, splat) = (L::splat(0.0), L::splat(1.0), L::splat);
        let ahead = [a.x.mul_add(cos, a.y * sin), b.x.mul_add(cos, b.y * sin), c.x.mul_add(cos, c.y * sin)];
        let aside = [a.y.mul_add(cos, -(a.x * sin)), b.y.mul_add(cos, -(b.x * sin)), c.y.mul_add(cos, -(c.x * sin))];
        let nearest = least(ahead) - slack;
        let inverse = [one / ahead[0], one / ahead[1], one / ahead[2]];
        let tangent = [aside[0] * inverse[0], aside[1] * inverse[1], aside[2] * inverse[2]];
        let grade = [a.z * inverse[0], b.z * inverse[1], c.z * inverse[2]];
        // By how much a point that is moved by the slack can change either.
        let blur = slack / nearest;
        let (left, right) = (most(tangent), least(tangent));
        let steepest = most(grade).max(-least(grade));
        let (left, right) = (left + blur * (left.abs() + one), right - blur * (right.abs() + one));
        let rise = blur * (steepest + one);
        let (top, bottom) = (most(grade) + rise, least(grade) - rise);
        // 1 - x^2 / 2 <= cos(atan(x)) <= 1 - x^2 / 2 + 3 x^4 / 8.
        let widest = left.abs().max(right.abs());
        let narrowest = right.max(-left).max(zero);
        let (wide, narrow) = (widest * widest, narrowest * narrowest);
        let low = wide.mul_add(splat(-0.5), one);
        let high = narrow.mul_add(narrow.mul_add(splat(0.375), splat(-0.5)), one);
        let top = top * L::select(top.gt(zero), high, low);
        let bottom = bottom * L::select(bottom.gt(zero), low, high);
        let (first, last) = self.band.rows_between(bottom, top);
        Facing { left, right, first, last, simple: nearest.gt(splat(1e-6)) & one.ge(widest) }
    }

    /// The columns of what is seen around one.
    #[inline(always)]
    fn columns_of<L: Lanes>(&self, facing: &Facing<L>, column: L) -> (L, L) {
        let (density, margin) = (L::splat(self.band.density), L::splat(self.margin()));
        let low = small_arctangent(facing.left).neg_mul_add(density, column) - margin;
        let high = small_arctangent(facing.right).neg_mul_add(density, column) + margin;
        (low, high)
    }

    /// The rows of triangles wherever they are, by height and distance.
    #[inline(always)]
    fn rows_around<L: Lanes>(&self, [a, b, c]: &[Vector<L>; 3], slack: L) -> (L, L) {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let above = [a.z, b.z, c.z];
        let distance = [a.x.mul_add(a.x, a.y * a.y), b.x.mul_add(b.x, b.y * b.y), c.x.mul_add(c.x, c.y * c.y)];
        let furthest = one / (most(distance).sqrt() + slack);
        let (ceiling, floor) = (most(above) + slack, least(above) - slack);
        let top = ceiling * L::select(ceiling.gt(zero), L::splat(TOUCHING), furthest);
        let bottom = floor * L::select(floor.gt(zero), furthest, L::splat(TOUCHING));
        self.band.rows_between(bottom, top)
    }
}
