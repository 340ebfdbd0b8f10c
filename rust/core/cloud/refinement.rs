//! Foliage and facades in pieces: halved where the cast of the layout disagrees with the points.

use glam::DVec3;

use super::fitting::fit_crown;
use super::rays::{Rays, Sight};
use super::{Cloud, FittedBox, HeightField, fit_box};
use crate::Shape;

/// Rounds of halving, after each of which useless pieces are removed.
const ROUNDS: [usize; 3] = [11, 1, 1];
/// The distance between neighbours among beams or firings, a share of the range.
const BEAM_GAP: f64 = 0.006;
/// Longer hedges and rows of trees are tiled [m].
const LONGEST_CROWN: f64 = 8.0;
/// The most points for a choice between halves.
const SAMPLE: usize = 150;
/// The least returns that a useful piece explains.
const LEAST_SHOWN: i32 = 2;

/// How finely pieces are cut.
#[derive(Clone, Copy, Debug)]
pub struct Detail {
    /// Pieces at most, by halving.
    pub most_pieces: usize,
    /// Shorter ones are not halved [m].
    pub least_length: f64,
    /// Nor are those that are wrong for fewer returns.
    pub worth: f64,
    /// Whether all pieces stand on the ground: none is stacked, and none left out.
    pub grounded: bool,
}

/// Some points of one cluster, and the shape around them.
#[derive(Clone)]
pub struct Piece {
    /// The indices of the points, in order.
    pub members: Vec<u32>,
    /// The number of the cluster.
    pub cluster: u32,
    /// An ellipsoid, or else a box.
    pub is_crown: bool,
    /// Its box.
    pub around: FittedBox,
    /// The rays that meet it, by number, and the distances.
    meets: Option<Vec<(u32, f64)>>,
    /// Whether halving does not improve it.
    whole: bool,
}

impl Piece {
    /// The piece around some points, enlarged by the gap between beams, so that neighbours meet.
    fn new(points: &[DVec3], members: Vec<u32>, cluster: u32, is_crown: bool) -> Piece {
        let mine: Vec<DVec3> = members.iter().map(|&k| points[k as usize]).collect();
        let mut around = if is_crown { fit_crown(&mine) } else { fit_box(&mine, 0.0) };
        let gap = BEAM_GAP * around.center.length();
        // A crown is along the line of sight.
        around.size += DVec3::new(if is_crown { 0.0 } else { gap }, gap, gap);
        Piece { members, cluster, is_crown, around, meets: None, whole: false }
    }

    fn shape(&self) -> Shape {
        if self.is_crown { Shape::Ellipsoid } else { Shape::Box }
    }

    /// A piece of some of its points.
    fn part(&self, points: &[DVec3], members: Vec<u32>) -> Piece {
        Piece::new(points, members, self.cluster, self.is_crown)
    }

    /// Its points in its own frame.
    fn local(&self, points: &[DVec3]) -> Vec<DVec3> {
        let local = self.around.local();
        self.members.iter().map(|&k| local(points[k as usize])).collect()
    }

    /// A long hedge in tiles of a crown's size, anything else unchanged.
    fn tiles(self, points: &[DVec3]) -> Vec<Piece> {
        let length = self.around.size.truncate().max_element();
        if !self.is_crown || length <= LONGEST_CROWN {
            return vec![self];
        }
        let axis = usize::from(self.around.size.y > self.around.size.x);
        let along: Vec<f64> = self.local(points).iter().map(|point| point[axis]).collect();
        let (low, high) = along.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
        let count = (length / LONGEST_CROWN).ceil();
        let mut tiles = vec![Vec::new(); count as usize];
        for (&member, x) in self.members.iter().zip(along) {
            tiles[((x - low) / (high - low + 1e-9) * count) as usize].push(member);
        }
        tiles.into_iter().filter(|tile| !tile.is_empty()).map(|tile| self.part(points, tile)).collect()
    }
}

/// The first hit of each ray: the distance, or infinity, and the piece, if it is one.
type Met = Vec<(f64, Option<u32>)>;

/// Pieces, and their agreement with rays.
struct Refinement<'a> {
    points: &'a [DVec3],
    rays: &'a Rays,
    /// The first hits of rays without pieces.
    others: Met,
    /// The number of points for each ray.
    scale: f64,
    detail: Detail,
    pieces: Vec<Piece>,
}

impl Cloud {
    /// The pieces of clusters, halved until the cast of the layout agrees with the points, or there are as many as
    /// `detail` allows.
    ///
    /// `clusters` is the number of each point's cluster, from 1, or 0; `crowns` marks the points of clusters that
    /// become ellipsoids, not boxes. `others` are the shapes that stay unchanged. Useless pieces are removed at the
    /// end, unless all of them have to stand on the ground, and their room is used once more.
    pub fn refined(
        &self,
        (clusters, crowns): (&[u32], &[bool]),
        others: &[(Shape, FittedBox)],
        ground: &HeightField,
        detail: Detail,
    ) -> Vec<Piece> {
        let (points, rays) = (&self.points[..], &self.some);
        let mut members = vec![Vec::new(); clusters.iter().copied().max().unwrap_or_default() as usize + 1];
        (0..).zip(clusters).for_each(|(point, &cluster)| members[cluster as usize].push(point));
        let of_cluster = |(cluster, mine): (u32, Vec<u32>)| {
            let is_crown = crowns[mine[0] as usize];
            Piece::new(points, mine, cluster, is_crown).tiles(points)
        };
        let pieces = (0..).zip(members).skip(1).filter(|(_, mine)| !mine.is_empty()).flat_map(of_cluster).collect();
        let on_ground = |sight| ground.hit(rays, sight).map_or(f64::INFINITY, |(distance, _)| distance);
        let mut met: Met = rays.sights().iter().map(|sight| (on_ground(sight), None)).collect();
        for (shape, around) in others {
            for (ray, distance) in rays.meeting(shape, around) {
                met[ray as usize].0 = met[ray as usize].0.min(distance);
            }
        }
        let scale = points.len() as f64 / rays.sights().len().max(1) as f64;
        let mut all = Refinement { points, rays, others: met, scale, detail, pieces };
        all.refine();
        all.pieces
    }
}

impl Refinement<'_> {
    fn refine(&mut self) {
        for rounds in ROUNDS {
            for remaining in (1..=rounds).rev() {
                // The worst first, and some of the room is left for bad pieces of later rounds.
                let room = (2 * self.detail.most_pieces.saturating_sub(self.pieces.len())).div_ceil(remaining + 1);
                if !self.halve(room) {
                    break;
                }
            }
            if self.detail.grounded {
                break;
            }
            let met = self.cast();
            let mut shown = vec![(0_i32, 0_i32); self.pieces.len()];
            for (&(distance, piece), sight) in met.iter().zip(self.rays.sights()) {
                let Some(piece) = piece else { continue };
                let (right, hidden) = &mut shown[piece as usize];
                *hidden += i32::from(sight.is_hidden(distance));
                *right += i32::from(!sight.is_hidden(distance) && !sight.is_short(distance));
            }
            let mut shown = shown.into_iter();
            self.pieces.retain(|_| shown.next().is_some_and(|(right, hidden)| right >= LEAST_SHOWN && right > hidden));
        }
    }

    /// The first hits of all rays.
    fn cast(&mut self) -> Met {
        let mut met = self.others.clone();
        for (number, piece) in (0..).zip(&mut self.pieces) {
            let (shape, around) = (piece.shape(), piece.around);
            let meets = piece.meets.get_or_insert_with(|| self.rays.meeting(&shape, &around).collect());
            for &(ray, distance) in &*meets {
                if distance < met[ray as usize].0 {
                    met[ray as usize] = (distance, Some(number));
                }
            }
        }
        met
    }

    /// Halves at most `most` pieces, those that are wrong for the most returns; returns whether there were any.
    ///
    /// A return whose cast is too near counts against the piece in its way. One whose cast is too far or missing counts
    /// against its own piece.
    fn halve(&mut self, most: usize) -> bool {
        let met = self.cast();
        let mut owner = vec![None; self.points.len()];
        for (number, piece) in (0_u32..).zip(&self.pieces) {
            piece.members.iter().for_each(|&point| owner[point as usize] = Some(number));
        }
        let mut wrong = vec![0; self.pieces.len()];
        // The points of others that are visible past a piece, or should be.
        let mut behind = vec![Vec::new(); self.pieces.len()];
        for (&(distance, piece), sight) in met.iter().zip(self.rays.sights()) {
            let mine = owner[sight.point as usize];
            if sight.is_hidden(distance)
                && let Some(piece) = piece
            {
                wrong[piece as usize] += 1;
                if mine != Some(piece) {
                    behind[piece as usize].push(sight.point);
                }
            } else if sight.is_short(distance)
                && let Some(mine) = mine
            {
                wrong[mine as usize] += 1;
            }
        }
        let mut worst: Vec<usize> = (0..self.pieces.len()).collect();
        worst.sort_by_key(|&number| std::cmp::Reverse(wrong[number]));
        worst.retain(|&number| f64::from(wrong[number]) * self.scale >= self.detail.worth);
        let mut halves: Vec<Vec<Piece>> = vec![Vec::new(); self.pieces.len()];
        let mut halved = 0;
        for number in worst {
            if halved >= most {
                break;
            }
            let piece = &self.pieces[number];
            if piece.whole || piece.around.size.truncate().max_element() < self.detail.least_length {
                continue;
            }
            behind[number].sort_unstable();
            halves[number] = self.halves(piece, &behind[number]);
            self.pieces[number].whole = halves[number].is_empty();
            halved += usize::from(!halves[number].is_empty());
        }
        let before = std::mem::take(&mut self.pieces);
        let parts = before.into_iter().zip(halves);
        self.pieces = parts.flat_map(|(piece, halves)| if halves.is_empty() { vec![piece] } else { halves }).collect();
        halved > 0
    }

    /// The halves of a piece across the axis of its box that corrects most returns; none if it has no halves.
    ///
    /// `behind` are points of others that are visible past it, or should be.
    fn halves(&self, piece: &Piece, behind: &[u32]) -> Vec<Piece> {
        let local = piece.local(self.points);
        let low = local.iter().fold(DVec3::INFINITY, |low, &point| low.min(point));
        let high = local.iter().fold(DVec3::NEG_INFINITY, |high, &point| high.max(point));
        let [own, other] = [&piece.members[..], behind].map(|points| self.sample(points));
        let mut axes: Vec<usize> = (0..if self.detail.grounded { 2 } else { 3 }).collect();
        axes.sort_by(|&a, &b| (high - low)[b].total_cmp(&(high - low)[a]));
        let mut best = (f64::INFINITY, Vec::new());
        for axis in axes {
            let middle = (low[axis] + high[axis]) / 2.0;
            let pairs = piece.members.iter().copied().zip(&local);
            let (far, near): (Vec<_>, Vec<_>) = pairs.partition(|(_, point)| point[axis] > middle);
            if far.is_empty() || near.is_empty() {
                continue;
            }
            let [far, near] = [far, near].map(|half| half.into_iter().map(|(member, _)| member).collect());
            let parts = vec![piece.part(self.points, far), piece.part(self.points, near)];
            let wrong = self.share_wrong(&parts, &own, |sight, met| sight.is_hidden(met) || sight.is_short(met))
                * piece.members.len() as f64
                + self.share_wrong(&parts, &other, Sight::is_hidden) * behind.len() as f64;
            if wrong < best.0 {
                best = (wrong, parts);
            }
            if wrong == 0.0 {
                break;
            }
        }
        best.1
    }

    /// Evenly chosen rays of points, a few at most.
    fn sample(&self, points: &[u32]) -> Vec<Sight> {
        let step = points.len().div_ceil(SAMPLE).max(1);
        let chosen = points.iter().step_by(step);
        chosen.map(|&point| Sight::new(self.rays.origin, point, self.points[point as usize])).collect()
    }

    /// The share of rays whose hit on some pieces is wrong.
    fn share_wrong(&self, pieces: &[Piece], sights: &[Sight], is_wrong: impl Fn(&Sight, f64) -> bool) -> f64 {
        let targets: Vec<_> =
            pieces.iter().map(|piece| piece.around.target(&piece.shape(), self.rays.origin)).collect();
        let wrong = sights.iter().filter(|sight| {
            let distances = targets.iter().filter_map(|target| target.distance(sight.direction));
            is_wrong(sight, distances.fold(f64::INFINITY, f64::min))
        });
        wrong.count() as f64 / sights.len().max(1) as f64
    }
}
