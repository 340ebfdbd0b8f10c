//! The rays to the points of a scan, which measure the agreement of shapes with it.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::{Cloud, FittedBox};
use crate::Shape;

/// Cells of directions along the sine of the elevation, and around: about half a degree each near the horizon.
const ROWS: usize = 230;
const COLUMNS: usize = 720;
/// The largest error of a cast that agrees with a return: 0.5 m, or this share of its range.
const TOLERANCE: (f64, f64) = (0.5, 0.05);

/// Rays from one place to points, sorted by direction.
pub(super) struct Rays {
    pub(super) origin: DVec3,
    /// The rays, row of cells by row.
    sights: Vec<Sight>,
    /// The start of each cell in them, and the end of the last one.
    starts: Vec<u32>,
}

/// A ray to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Its length is 1.
    pub(super) direction: DVec3,
    pub(super) range: f64,
    /// The index of the point.
    pub(super) point: u32,
}

impl Sight {
    /// The ray to a point.
    pub(super) fn new(origin: DVec3, point: u32, end: DVec3) -> Sight {
        let range = (end - origin).length();
        Sight { direction: (end - origin) / range.max(1e-6), range, point }
    }

    /// The largest error of a cast that agrees with it [m].
    pub(super) fn tolerance(&self) -> f64 {
        TOLERANCE.0.max(TOLERANCE.1 * self.range)
    }

    /// Whether something at a distance is in its way.
    pub(super) fn is_hidden(&self, distance: f64) -> bool {
        distance < self.range - self.tolerance()
    }

    /// Whether it should have ended before a distance.
    pub(super) fn is_short(&self, distance: f64) -> bool {
        distance > self.range + self.tolerance()
    }

    /// The cell of its direction.
    fn cell(&self) -> usize {
        let column = (turn(self.direction.truncate()) + 2.0) / COLUMN;
        row(self.direction.z) * COLUMNS + column as usize % COLUMNS
    }
}

/// The width of a column, in units of [`turn`].
const COLUMN: f64 = 4.0 / COLUMNS as f64;

/// A number from -2 to 2 that grows with the azimuth of a direction, at the cost of a division. It grows by 2 in half a
/// turn.
fn turn(DVec2 { x, y }: DVec2) -> f64 {
    let slope = y / (x.abs() + y.abs()).max(1e-9);
    if x >= 0.0 { slope } else { 2.0_f64.copysign(y) - slope }
}

fn row(sine: f64) -> usize {
    (((sine + 1.0) / 2.0 * ROWS as f64) as usize).min(ROWS - 1)
}

impl Rays {
    /// The rays from `origin` to every `step`-th of the points.
    pub(super) fn new(points: &[DVec3], origin: DVec3, step: usize) -> Rays {
        let chosen = (0..points.len()).step_by(step);
        let sights: Vec<Sight> = chosen.map(|k| Sight::new(origin, k as u32, points[k])).collect();
        let cells: Vec<u32> = sights.iter().map(|sight| sight.cell() as u32).collect();
        let mut starts = vec![0; ROWS * COLUMNS + 1];
        cells.iter().for_each(|&cell| starts[cell as usize + 1] += 1);
        (1..starts.len()).for_each(|cell| starts[cell] += starts[cell - 1]);
        let (mut next, mut sorted) = (starts.clone(), sights.clone());
        for (sight, &cell) in sights.iter().zip(&cells) {
            sorted[next[cell as usize] as usize] = *sight;
            next[cell as usize] += 1;
        }
        Rays { origin, sights: sorted, starts }
    }

    /// All of them.
    pub(super) fn sights(&self) -> &[Sight] {
        &self.sights
    }

    /// The rays that meet the shape in a box: their numbers among all of them, and the distances.
    pub(super) fn meeting(&self, shape: &Shape, around: &FittedBox) -> impl Iterator<Item = (u32, f64)> {
        let target = around.target(shape, self.origin);
        let met = move |k: usize| Some((k as u32, target.distance(self.sights[k].direction)?));
        self.towards(around).flatten().filter_map(met)
    }

    /// The rays in the cells that a box covers, row by row.
    fn towards(&self, around: &FittedBox) -> impl Iterator<Item = Range<usize>> {
        let center = around.center - self.origin;
        let local = DVec2::from_angle(-around.yaw).rotate(center.truncate());
        let half = around.size / 2.0;
        let nearest = (local.abs() - half.truncate()).max(DVec2::ZERO).length();
        let furthest = (local.abs() + half.truncate()).length();
        let [low, high] = [center.z - half.z, center.z + half.z];
        let sine = |z: f64, away: f64| if z == 0.0 { 0.0 } else { z / z.hypot(away) };
        let lowest = sine(low, if low < 0.0 { nearest } else { furthest });
        let highest = sine(high, if high > 0.0 { nearest } else { furthest });
        let columns = if nearest > 0.0 {
            let (along, middle) = (DVec2::from_angle(around.yaw), turn(center.truncate()));
            let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
                .map(|(x, y)| turn(center.truncate() + along.rotate(DVec2::new(x * half.x, y * half.y))) - middle)
                // A direction beyond the seam behind the sensor is near all the same.
                .map(|off| {
                    if off > 2.0 {
                        off - 4.0
                    } else if off < -2.0 {
                        off + 4.0
                    } else {
                        off
                    }
                });
            let [right, left] =
                [corners.iter().copied().fold(0.0, f64::min), corners.iter().copied().fold(0.0, f64::max)];
            let column = |off: f64| ((middle + off + 2.0) / COLUMN).floor() as i64;
            column(right)..column(left) + 1
        } else {
            0..COLUMNS as i64
        };
        (row(lowest)..row(highest) + 1).flat_map(move |row| {
            let run = |from: i64, to: i64| {
                let at = |column: i64| self.starts[row * COLUMNS + column as usize] as usize;
                at(from.max(0))..at(to.clamp(0, COLUMNS as i64))
            };
            let (from, to, all) = (columns.start, columns.end, COLUMNS as i64);
            // The part beyond the seam behind the sensor continues at the other side.
            [run(from, to), run(0, to - all), run((from + all).min(all), all)]
        })
    }
}

impl Cloud {
    /// The number of rays, each counted `weights` times by its point, through each core of a box that end behind or
    /// below it.
    ///
    /// Rays that end over the box of the core, above its bottom, are on the same object, such as a windscreen behind a
    /// hood.
    pub fn passed(&self, weights: &[f64], cores: &[FittedBox], boxes: &[FittedBox]) -> Vec<f64> {
        let through = |(core, whole): (&FittedBox, &FittedBox)| {
            let (bottom, half) = (core.center.z - core.size.z / 2.0, whole.size.truncate() / 2.0);
            let hidden =
                self.rays.meeting(&Shape::Box, core).map(|(k, distance)| (&self.rays.sights[k as usize], distance));
            let ends =
                hidden.filter(|(sight, distance)| sight.is_hidden(*distance)).map(|(sight, _)| sight.point as usize);
            let local = whole.local();
            let inside = |&end: &usize| {
                self.points[end].z > bottom && local(self.points[end]).truncate().abs().cmplt(half).all()
            };
            ends.filter(|end| !inside(end)).map(|end| weights[end]).sum()
        };
        cores.iter().zip(boxes).map(through).collect()
    }
}
