//! The ground under a scan: one height field in several classes.

use glam::{DVec2, I64Vec2};

use super::Cloud;
use super::rays::{Rays, Sight};

/// The side of a cell [m].
const CELL: f64 = 1.0;
/// The ground extends this far [m] from a seen cell.
const BRIDGED: f64 = 4.0;
/// Cells on each side of the seen ones: more than the ground extends.
const MARGIN: i64 = 5;
/// Rounds of removing cells: further ones may be exposed once the first are gone.
const ROUNDS: usize = 2;
/// The number of near cells whose mean, weighted by distance, is the height of a place.
const AVERAGED: usize = 4;

/// Median height and most frequent class of the ground points in each cell of a grid.
///
/// A cell that hides more points than it explains is left out, and the ground continues there at the height of the
/// cells around: an object on it was labelled as ground.
#[derive(Default)]
pub struct HeightField {
    /// The first cell of the grid, in cells from the origin.
    low: I64Vec2,
    /// The cells of the grid along each axis. A grid is stored column by column of y.
    size: I64Vec2,
    seen: Vec<Cell>,
    /// The index in `seen` of each cell of the grid.
    index: Vec<Option<u32>>,
    /// The index in `seen` of the nearest seen cell, as far as the ground extends.
    nearest: Vec<Option<u32>>,
    /// The highest corner of each cell, or -inf without ground.
    tops: Vec<f64>,
    /// Heights of the corners of the grid, one more along each axis; NaN without ground.
    corners: Vec<f64>,
    /// The highest corner of all.
    top: f64,
}

/// A cell with ground points.
struct Cell {
    /// Their mean place [m].
    place: DVec2,
    height: f64,
    label: u8,
}

impl Cloud {
    /// The ground given by points of some classes; empty without such points.
    pub fn ground(&self, labels: &[u8], classes: &[u8]) -> HeightField {
        let mine = || (0..).zip(labels).filter(|(_, label)| classes.contains(label)).map(|(k, _): (u32, _)| k);
        let place = |k: u32| self.points[k as usize].truncate();
        let low = mine().fold(DVec2::INFINITY, |low, k| low.min(place(k)));
        if !low.is_finite() {
            return HeightField { corners: vec![f64::NAN], ..HeightField::default() };
        }
        let high = mine().fold(DVec2::NEG_INFINITY, |high, k| high.max(place(k)));
        let margin = I64Vec2::splat(MARGIN);
        let (low, high) = (cell_of(low) - margin, cell_of(high) + margin);
        let size = high - low + 1;
        let cell = |k: u32| {
            let at = cell_of(place(k)) - low;
            (at.x * size.y + at.y) as u32
        };
        let mut keyed: Vec<(u32, u32)> = mine().map(|k| (cell(k), k)).collect();
        keyed.sort_unstable();
        let seen = keyed.chunk_by(|a, b| a.0 == b.0).map(|same| {
            let mut heights: Vec<f64> = same.iter().map(|&(_, k)| self.points[k as usize].z).collect();
            let (_, &mut height, _) = heights.select_nth_unstable_by(same.len() / 2, f64::total_cmp);
            let votes =
                classes.iter().rev().map(|class| same.iter().filter(|(_, k)| labels[*k as usize] == *class).count());
            // Of equally frequent classes the first.
            let label = votes.zip(classes.iter().rev()).max_by_key(|&(count, _)| count).map_or(0, |(_, &class)| class);
            Cell { place: same.iter().map(|&(_, k)| place(k)).sum::<DVec2>() / same.len() as f64, height, label }
        });
        let seen = seen.collect();
        let mut field = HeightField { low, size, seen, ..HeightField::default() };
        field.surface();
        for _ in 0..ROUNDS {
            let kept = field.shows(&self.some);
            if !kept.contains(&true) || !kept.contains(&false) {
                break;
            }
            let mut kept = kept.into_iter();
            field.seen.retain(|_| kept.next().unwrap_or_default());
            field.surface();
        }
        field
    }
}

impl HeightField {
    /// The first cell of the grid, in cells from the origin, and the number of cells along each axis.
    pub fn grid(&self) -> ([i64; 2], [usize; 2]) {
        (self.low.to_array(), self.size.to_array().map(|size| size as usize))
    }

    /// The heights of the corners of the grid, one more along each axis, x by x; NaN without ground.
    pub fn corners(&self) -> &[f64] {
        &self.corners
    }

    /// The class of each cell of the grid, 0 without ground.
    pub fn labels(&self) -> Vec<u8> {
        self.nearest.iter().map(|nearest| nearest.map_or(0, |k| self.seen[k as usize].label)).collect()
    }

    /// Height of the ground at a place, seen or not, and the distance to the seen ground [m]; 0 without ground.
    pub fn height(&self, place: impl Into<DVec2>) -> (f64, f64) {
        let place = place.into();
        let near = self.nearest(place);
        let Some(&(distance, first)) = near.first() else {
            return (0.0, f64::INFINITY);
        };
        if distance == 0.0 {
            return (self.seen[first as usize].height, 0.0);
        }
        let weights: f64 = near.iter().map(|&(away, _)| 1.0 / away).sum();
        let sum: f64 = near.iter().map(|&(away, k)| self.seen[k as usize].height / away).sum();
        (sum / weights, distance)
    }

    /// The nearest seen cells, nearest first, by their distances.
    fn nearest(&self, place: DVec2) -> Vec<(f64, u32)> {
        let mut found: Vec<(f64, u32)> = Vec::with_capacity(AVERAGED + 1);
        let at = cell_of(place) - self.low;
        let last = self.size - 1;
        let first_ring = (-at).max(at - last).max(I64Vec2::ZERO).max_element();
        let last_ring = at.abs().max((last - at).abs()).max_element();
        for ring in first_ring..=last_ring {
            // Cells on a ring are further away than the width of those within.
            if found.len() == AVERAGED && found[AVERAGED - 1].0 <= (ring - 1) as f64 * CELL {
                break;
            }
            for x in (at.x - ring).max(0)..=(at.x + ring).min(last.x) {
                let step = if (x - at.x).abs() == ring { 1 } else { (2 * ring).max(1) };
                let rows = (at.y - ring..=at.y + ring).step_by(step as usize);
                for y in rows.filter(|y| (0..=last.y).contains(y)) {
                    if let Some(k) = self.index[(x * self.size.y + y) as usize] {
                        let entry = (self.seen[k as usize].place.distance(place), k);
                        let before = found.partition_point(|other| *other < entry);
                        found.insert(before, entry);
                        found.truncate(AVERAGED);
                    }
                }
            }
        }
        found
    }

    /// Lays the ground over the seen cells and those around them. A corner's height depends on its place only.
    fn surface(&mut self) {
        let (size, corner) = (self.size, |x: i64, y: i64| (x * (self.size.y + 1) + y) as usize);
        self.index = vec![None; (size.x * size.y) as usize];
        let mut nearest = vec![(BRIDGED.next_up(), None); self.index.len()];
        for (k, cell) in (0..).zip(&self.seen) {
            let at = cell_of(cell.place) - self.low;
            self.index[(at.x * size.y + at.y) as usize] = Some(k);
            for x in at.x - MARGIN..=at.x + MARGIN {
                for y in at.y - MARGIN..=at.y + MARGIN {
                    let middle = (I64Vec2::new(x, y) + self.low).as_dvec2() * CELL + CELL / 2.0;
                    let (away, best) = (middle.distance(cell.place), &mut nearest[(x * size.y + y) as usize]);
                    if away < best.0 {
                        *best = (away, Some(k));
                    }
                }
            }
        }
        self.nearest = nearest.into_iter().map(|(_, k)| k).collect();
        self.corners = vec![f64::NAN; ((size.x + 1) * (size.y + 1)) as usize];
        (self.tops, self.top) = (vec![f64::NEG_INFINITY; self.nearest.len()], f64::NEG_INFINITY);
        for x in 0..size.x {
            for y in 0..size.y {
                let cell = (x * size.y + y) as usize;
                if self.nearest[cell].is_none() {
                    continue;
                }
                for (x, y) in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)] {
                    if self.corners[corner(x, y)].is_nan() {
                        let place = (I64Vec2::new(x, y) + self.low).as_dvec2() * CELL;
                        self.corners[corner(x, y)] = self.height(place).0;
                    }
                    self.tops[cell] = self.tops[cell].max(self.corners[corner(x, y)]);
                }
                self.top = self.top.max(self.tops[cell]);
            }
        }
    }

    /// Whether each seen cell explains at least as many points as it hides.
    fn shows(&self, rays: &Rays) -> Vec<bool> {
        let mut more = vec![0_i32; self.seen.len()];
        for sight in rays.sights() {
            if let Some((distance, cell)) = self.hit(rays, sight)
                && let Some(k) = self.nearest[cell]
            {
                more[k as usize] += if sight.is_hidden(distance) { -1 } else { 1 };
            }
        }
        more.into_iter().map(|more| more >= 0).collect()
    }

    /// The hit of a ray on the ground, within the distance that agrees with it, and its cell of the grid.
    pub(super) fn hit(&self, rays: &Rays, sight: &Sight) -> Option<(f64, usize)> {
        if self.seen.is_empty() {
            return None;
        }
        let limit = sight.range + sight.tolerance();
        let start = rays.origin.truncate() / CELL - self.low.as_dvec2();
        let step = sight.direction.truncate() / CELL;
        let size = self.size.as_dvec2();
        // A ray from above matters only once it is as low as the highest ground.
        let above = self.top - rays.origin.z;
        let falls = if above >= 0.0 {
            0.0
        } else if sight.direction.z < 0.0 {
            above / sight.direction.z
        } else {
            limit
        };
        // From its entry over the grid to its exit.
        let sides = [(start.x, step.x, size.x), (start.y, step.y, size.y)].map(|(start, step, size)| {
            let (a, b) = (-start / step, (size - start) / step);
            if step == 0.0 { (f64::NEG_INFINITY, f64::INFINITY) } else { (a.min(b), a.max(b)) }
        });
        let mut from = sides[0].0.max(sides[1].0).max(falls);
        let end = sides[0].1.min(sides[1].1).min(limit);
        let mut at = (start + step * from).floor().as_i64vec2().clamp(I64Vec2::ZERO, self.size - 1);
        let height = |distance: f64| rays.origin.z + sight.direction.z * distance;
        let forward = I64Vec2::new((step.x > 0.0).into(), (step.y > 0.0).into());
        while from < end && at.cmpge(I64Vec2::ZERO).all() && at.cmplt(self.size).all() {
            let edge = (at + forward).as_dvec2() - start;
            let leave_x = if step.x == 0.0 { f64::INFINITY } else { edge.x / step.x };
            let leave_y = if step.y == 0.0 { f64::INFINITY } else { edge.y / step.y };
            let to = leave_x.min(leave_y).min(end).max(from);
            let cell = (at.x * self.size.y + at.y) as usize;
            if height(from).min(height(to)) <= self.tops[cell] {
                let over = [from, to].map(|distance| height(distance) - self.at(start + step * distance, at));
                if (over[0] > 0.0) != (over[1] > 0.0) {
                    return Some((from + (to - from) * over[0] / (over[0] - over[1]), cell));
                }
            }
            if leave_x < leave_y {
                at.x += 2 * forward.x - 1;
            } else {
                at.y += 2 * forward.y - 1;
            }
            from = to;
        }
        None
    }

    /// The height at a place of a cell, both in cells of the grid.
    fn at(&self, place: DVec2, cell: I64Vec2) -> f64 {
        let DVec2 { x, y } = place - cell.as_dvec2();
        let first = (cell.x * (self.size.y + 1) + cell.y) as usize;
        let second = first + self.size.y as usize + 1;
        let [near, far] = [first, second].map(|k| self.corners[k] + y * (self.corners[k + 1] - self.corners[k]));
        near + x * (far - near)
    }
}

fn cell_of(place: DVec2) -> I64Vec2 {
    (place / CELL).floor().as_i64vec2()
}
