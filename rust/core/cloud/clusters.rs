//! Clusters of points.

use std::collections::HashMap;

use glam::{DVec3, IVec3};

/// The highest over the lowest reach of points whose neighbours are searched together.
const BAND: f64 = 1.25;

/// The root of points in no cluster.
const NONE: u32 = u32::MAX;

/// Distinct cells along an axis.
const MOST_CELLS: u64 = 1 << 21;

/// DBSCAN (Ester et al., KDD 1996): the indices of each cluster in order, largest first; points of none are left out.
///
/// Two points are neighbours within `reach` [m] and `per_range`, less than 0.1, of their horizontal range, as points
/// are sparser further away. A cluster grows from points with `min_points` neighbours, themselves included. Points
/// closer than a quarter of the reach are searched as one.
pub fn cluster(points: &[[f64; 3]], reach: f64, per_range: f64, min_points: usize) -> Vec<Vec<u32>> {
    let points: Vec<DVec3> = points.iter().map(|&point| point.into()).collect();
    let voxels = thinned(&points, reach / 4.0);
    let places: Vec<DVec3> = voxels.iter().map(|voxel| points[voxel[0] as usize]).collect();
    let reaches: Vec<f64> = places.iter().map(|place| reach + per_range * place.truncate().length()).collect();
    let pairs = Neighbours { places: &places, reaches: &reaches, per_range }.pairs();
    let mut neighbours: Vec<usize> = voxels.iter().map(Vec::len).collect();
    for &[a, b] in &pairs {
        neighbours[a as usize] += voxels[b as usize].len();
        neighbours[b as usize] += voxels[a as usize].len();
    }
    let is_core = |voxel: u32| neighbours[voxel as usize] >= min_points;
    let mut forest = Forest((0..voxels.len() as u32).collect());
    pairs.iter().filter(|[a, b]| is_core(*a) && is_core(*b)).for_each(|&[a, b]| forest.join(a, b));
    let mut root: Vec<u32> = (0..).zip(&voxels).map(|(k, _)| if is_core(k) { forest.root(k) } else { NONE }).collect();
    // A point that is not a core belongs to the cluster of an adjacent core.
    for &[a, b] in pairs.iter().filter(|[a, b]| is_core(*a) != is_core(*b)) {
        let [core, edge] = if is_core(a) { [a, b] } else { [b, a] };
        root[edge as usize] = root[edge as usize].min(forest.root(core));
    }
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); voxels.len()];
    for (voxel, &root) in voxels.iter().zip(&root).filter(|&(_, &root)| root != NONE) {
        members[root as usize].extend(voxel);
    }
    members.retain(|cluster| !cluster.is_empty());
    members.iter_mut().for_each(|cluster| cluster.sort_unstable());
    members.sort_by_key(|cluster| std::cmp::Reverse(cluster.len()));
    members
}

/// The indices of the points in each cell of size `voxel` [m], those of lower cells first.
fn thinned(points: &[DVec3], voxel: f64) -> Vec<Vec<u32>> {
    let low = points.iter().fold(DVec3::INFINITY, |low, &point| low.min(point));
    let key = |point: &DVec3| {
        let [x, y, z] = ((point - low) / voxel).to_array().map(|cells| (cells as u64).min(MOST_CELLS));
        (z * MOST_CELLS + y) * MOST_CELLS + x
    };
    let mut keyed: Vec<(u64, u32)> = points.iter().map(key).zip(0..).collect();
    keyed.sort_unstable();
    keyed.chunk_by(|a, b| a.0 == b.0).map(|same| same.iter().map(|&(_, index)| index).collect()).collect()
}

/// Points no further apart than the mean of their reaches.
struct Neighbours<'a> {
    places: &'a [DVec3],
    reaches: &'a [f64],
    per_range: f64,
}

impl Neighbours<'_> {
    /// Both indices of each pair, once.
    ///
    /// By bands of the lesser reach of the two: a grid is as coarse as its largest reach, so one far point would make
    /// it coarse for all.
    fn pairs(&self) -> Vec<[u32; 2]> {
        // The reach of a neighbour is at most this many times the other's, as their ranges are alike.
        let most = 1.0 + 2.0 * self.per_range;
        let highest = self.reaches.iter().copied().fold(0.0, f64::max);
        let mut low = self.reaches.iter().copied().fold(f64::INFINITY, f64::min);
        let mut pairs = Vec::new();
        while low <= highest {
            let high = low * BAND;
            self.add_pairs_of_band(low, high, high * most, &mut pairs);
            low = high;
        }
        pairs
    }

    /// The pairs whose lesser reach is from `low` up to `high`; no two are further apart than `furthest`.
    fn add_pairs_of_band(&self, low: f64, high: f64, furthest: f64, pairs: &mut Vec<[u32; 2]>) {
        let cell = |place: &DVec3| (place / furthest).floor().as_ivec3();
        let inside =
            (0..).zip(self.places.iter().zip(self.reaches)).filter(|(_, (_, reach))| (low..furthest).contains(*reach));
        let mut keyed: Vec<(IVec3, u32)> = inside.map(|(k, (place, _))| (cell(place), k)).collect();
        keyed.sort_unstable_by_key(|&(cell, k)| (cell.to_array(), k));
        let cells: HashMap<IVec3, &[(IVec3, u32)]> =
            keyed.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same)).collect();
        for same in keyed.chunk_by(|a, b| a.0 == b.0) {
            for next in forward().filter_map(|step| cells.get(&(same[0].0 + step))) {
                for (number, &(cell, a)) in same.iter().enumerate() {
                    let others = if next[0].0 == cell { &next[number + 1..] } else { next };
                    let (place, own) = (self.places[a as usize], self.reaches[a as usize]);
                    for &(_, b) in others {
                        let other = self.reaches[b as usize];
                        let reach = (own + other) / 2.0;
                        let close = place.distance_squared(self.places[b as usize]) <= reach * reach;
                        if close && own.min(other) < high {
                            pairs.push([a, b]);
                        }
                    }
                }
            }
        }
    }
}

/// A cell itself, and half of its neighbours, so that each pair of cells occurs once.
fn forward() -> impl Iterator<Item = IVec3> {
    (13..27).map(|k| IVec3::new(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1))
}

/// Groups of numbers: each number names another of its group, the lowest itself.
struct Forest(Vec<u32>);

impl Forest {
    fn root(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            let next = self.0[self.0[number as usize] as usize];
            self.0[number as usize] = next;
            number = next;
        }
        number
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
