//! Level ground becomes ground that rises and falls: meshes are cut where a lattice of heights bends, and raised.

use std::collections::HashMap;

use crate::TriangleMesh;

/// Metres under which vertices are the same, and over a line by which nothing is cut.
const SAME: f64 = 1e-6;

/// Heights where lines meet; a cell between them is two triangles, which share the edge from its least x and y to its
/// most. Beyond the outermost lines it goes on as high as it is there.
#[derive(Clone, Copy, Debug)]
pub struct Relief<'a> {
    /// Two lines or more, which increase.
    pub x: &'a [f64],
    /// The same of the other axis.
    pub y: &'a [f64],
    /// Row by row: those of the first x along all y come first.
    pub heights: &'a [f64],
}

type Polygon = Vec<[f64; 3]>;

impl Relief<'_> {
    /// The pieces of a mesh between lines and diagonals, as far over the relief as the mesh lies over z = 0.
    pub fn lay(&self, mesh: &TriangleMesh) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
        for &triangle in mesh.faces() {
            let whole = triangle.map(|corner| mesh.vertices()[corner as usize]).to_vec();
            for strip in pieces(whole, self.x, |p| p[0]) {
                for part in pieces(strip, self.y, |p| p[1]) {
                    let cell = self.cell(&part);
                    let (before, after) = split(&part, |p| self.over(cell, p).1);
                    for piece in [before, after].into_iter().filter(|piece| piece.len() > 2) {
                        let corners = piece.iter().map(|&p| {
                            let raised = [p[0], p[1], p[2] + self.over(cell, p).0];
                            *numbers.entry(p.map(|x| (x / SAME).round() as i64)).or_insert_with(|| {
                                vertices.push(raised);
                                (vertices.len() - 1) as u32
                            })
                        });
                        let corners: Vec<u32> = corners.collect();
                        let fan = corners.windows(2).skip(1).map(|ends| [corners[0], ends[0], ends[1]]);
                        faces.extend(fan.filter(|[a, b, c]| a != b && b != c && c != a));
                    }
                }
            }
        }
        (vertices, faces)
    }

    /// The cell in which the middle of a polygon lies.
    fn cell(&self, polygon: &Polygon) -> [usize; 2] {
        let middle = |axis: usize| polygon.iter().map(|p| p[axis]).sum::<f64>() / polygon.len() as f64;
        let before = |lines: &[f64], at: f64| lines.partition_point(|&line| line <= at).clamp(1, lines.len() - 1) - 1;
        [before(self.x, middle(0)), before(self.y, middle(1))]
    }

    /// The height of a cell over a point, and on which side of its diagonal that is.
    fn over(&self, [row, column]: [usize; 2], [x, y, _]: [f64; 3]) -> (f64, f64) {
        let share = |lines: &[f64], k: usize, at: f64| ((at - lines[k]) / (lines[k + 1] - lines[k])).clamp(0.0, 1.0);
        let (p, q) = (share(self.x, row, x), share(self.y, column, y));
        let height = |i: usize, k: usize| self.heights[(row + i) * self.y.len() + column + k];
        let (here, after) = (height(0, 0), height(1, 1));
        let rise = if p >= q {
            p * (height(1, 0) - here) + q * (after - height(1, 0))
        } else {
            q * (height(0, 1) - here) + p * (after - height(0, 1))
        };
        (here + rise, p - q)
    }
}

/// The pieces of a convex polygon between lines of one axis.
fn pieces(polygon: Polygon, lines: &[f64], axis: impl Fn([f64; 3]) -> f64) -> Vec<Polygon> {
    let (low, high) = polygon
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &p| (low.min(axis(p)), high.max(axis(p))));
    let first = lines.partition_point(|&line| line <= low + SAME);
    let (mut rest, mut found) = (polygon, Vec::new());
    for &line in lines[first..].iter().take_while(|&&line| line < high - SAME) {
        let (before, after) = split(&rest, |p| line - axis(p));
        found.push(before);
        rest = after;
    }
    found.push(rest);
    found
}

/// What of a convex polygon lies where `side` is 0 or more, and what lies where it is less; empty where there is none.
fn split(polygon: &Polygon, side: impl Fn([f64; 3]) -> f64) -> (Polygon, Polygon) {
    let sides: Vec<f64> = polygon.iter().map(|&p| side(p)).collect();
    if sides.iter().all(|&s| s >= -SAME) {
        return (polygon.clone(), Vec::new());
    }
    if sides.iter().all(|&s| s <= SAME) {
        return (Vec::new(), polygon.clone());
    }
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    for (k, (&a, &s)) in polygon.iter().zip(&sides).enumerate() {
        if s >= 0.0 {
            inside.push(a);
        }
        if s <= 0.0 {
            outside.push(a);
        }
        let (b, t) = (polygon[(k + 1) % polygon.len()], sides[(k + 1) % polygon.len()]);
        if s * t < 0.0 {
            let met = [0, 1, 2].map(|axis| a[axis] + s / (s - t) * (b[axis] - a[axis]));
            inside.push(met);
            outside.push(met);
        }
    }
    (inside, outside)
}
