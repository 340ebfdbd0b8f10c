//! Meshes for the scan kernel: triangles in blocks that lie close together, sixteen to a block and sixteen blocks to a group.

use glam::DVec3;

use crate::Bounds;
use crate::simd::WIDEST;

/// Triangles of a block, and blocks of a group: one to a lane.
pub(crate) const SIDE: usize = WIDEST;

/// A mesh in its own frame.
#[derive(Debug)]
pub(crate) struct Blocks {
    pub(crate) blocks: Vec<Block>,
    /// The boxes around the blocks, and around each `SIDE` of them in a row.
    pub(crate) block_boxes: Boxes,
    pub(crate) group_boxes: Boxes,
    /// Triangles that are no part of a block, and the boxes around them.
    pub(crate) large: Vec<Large>,
    pub(crate) large_boxes: Boxes,
}

/// A triangle so large that its corners may be much further away than its plane is: that takes f64.
#[derive(Debug)]
pub(crate) struct Large {
    pub(crate) corners: [DVec3; 3],
    /// Its number in the mesh.
    pub(crate) triangle: u32,
}

/// Triangles that reach further than this are large [m]: some ten times the height of a sensor.
const LARGE: f64 = 16.0;

/// Sixteen triangles or fewer.
#[derive(Debug)]
pub(crate) struct Block {
    /// Corner, axis, triangle: relative to the middle of the block's box, which keeps them exact far from the mesh's origin.
    /// The edge from the last corner to the first is the longest.
    pub(crate) corners: [[[f32; SIDE]; 3]; 3],
    /// Their numbers in the mesh.
    pub(crate) triangles: [u32; SIDE],
    pub(crate) count: usize,
}

/// Boxes as columns of numbers, by axis and padded to whole vectors.
#[derive(Debug)]
pub(crate) struct Boxes {
    pub(crate) center: [Vec<f32>; 3],
    pub(crate) half: [Vec<f32>; 3],
    /// Lengths of the diagonals.
    pub(crate) size: Vec<f32>,
    pub(crate) count: usize,
}

impl Blocks {
    /// Blocks of the triangles that have an area, along a curve through their middles.
    pub(crate) fn new(vertices: &[DVec3], faces: &[[u32; 3]]) -> Blocks {
        let corners = |face: u32| faces[face as usize].map(|v| vertices[v as usize]);
        let solid = (0..faces.len() as u32).filter(|&face| {
            let [a, b, c] = corners(face);
            (b - a).cross(c - a) != DVec3::ZERO
        });
        let bounded = solid.map(|face| (face, around(&corners(face))));
        let (large, small): (Vec<_>, Vec<_>) = bounded.partition(|face| face.1.diagonal() > LARGE);
        let order = along_curve(small);
        let (mut blocks, mut boxes) = (Vec::new(), Vec::new());
        for chunk in order.chunks(SIDE) {
            let bounds = chunk.iter().fold(Bounds::EMPTY, |all, face| all.union(face.1));
            let mut block = Block { corners: [[[0.0; SIDE]; 3]; 3], triangles: [0; SIDE], count: chunk.len() };
            for (lane, &(face, _)) in chunk.iter().enumerate() {
                block.triangles[lane] = face;
                for (k, corner) in longest_last(corners(face)).into_iter().enumerate() {
                    let local = (corner - f32_center(&bounds)).as_vec3();
                    (0..3).for_each(|axis| block.corners[k][axis][lane] = local[axis]);
                }
            }
            blocks.push(block);
            boxes.push(bounds);
        }
        let groups = boxes.chunks(SIDE).map(|group| group.iter().fold(Bounds::EMPTY, |all, &next| all.union(next)));
        Blocks {
            group_boxes: Boxes::new(groups.collect()),
            block_boxes: Boxes::new(boxes),
            blocks,
            large: large.iter().map(|&(triangle, _)| Large { corners: corners(triangle), triangle }).collect(),
            large_boxes: Boxes::new(large.iter().map(|face| face.1).collect()),
        }
    }
}

impl Blocks {
    /// How many groups and large triangles there are.
    pub(crate) fn parts(&self) -> usize {
        self.group_boxes.count + self.large_boxes.count
    }
}

impl Boxes {
    fn new(boxes: Vec<Bounds>) -> Boxes {
        let padded = boxes.len().next_multiple_of(WIDEST);
        let table = |f: &dyn Fn(&Bounds) -> f32| {
            let mut table: Vec<f32> = boxes.iter().map(f).collect();
            table.resize(padded, 0.0);
            table
        };
        Boxes {
            center: [0, 1, 2].map(|k| table(&|b| f32_center(b)[k] as f32)),
            // The middle was rounded, so the box is measured from there, and upwards.
            half: [0, 1, 2].map(|k| {
                table(&|b| {
                    let center = f32_center(b)[k];
                    ((b.max[k] - center).max(center - b.min[k]) as f32).next_up()
                })
            }),
            size: table(&|b| b.diagonal() as f32),
            count: boxes.len(),
        }
    }
}

/// The corners in the same order around, such that the edge from the last to the first is the longest.
fn longest_last([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    let [ab, bc, ca] = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    if ab >= bc.max(ca) {
        [b, c, a]
    } else if bc >= ca {
        [c, a, b]
    } else {
        [a, b, c]
    }
}

fn around(corners: &[DVec3; 3]) -> Bounds {
    let [a, b, c] = *corners;
    Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
}

/// The middle as f32 holds it.
fn f32_center(bounds: &Bounds) -> DVec3 {
    bounds.center().as_vec3().as_dvec3()
}

/// Triangles in the order of a Morton curve; the few that are much larger than the others come first, or they would
/// stretch the boxes of all blocks they fell into.
fn along_curve(faces: Vec<(u32, Bounds)>) -> Vec<(u32, Bounds)> {
    let all = faces.iter().fold(Bounds::EMPTY, |all, face| all.union(face.1));
    let extent = (all.max - all.min).max_element().max(f64::MIN_POSITIVE);
    let mut sizes: Vec<f64> = faces.iter().map(|face| face.1.diagonal()).collect();
    let large = match sizes.len() {
        0 => 0.0,
        count => 8.0 * *sizes.select_nth_unstable_by(count / 2, f64::total_cmp).1,
    };
    let mut keyed: Vec<(u64, (u32, Bounds))> = faces
        .into_iter()
        .map(|face| {
            let place = (face.1.center() - all.min) / extent * f64::from(1_u32 << 20);
            let key = spaced(place.x) | spaced(place.y) << 1 | spaced(place.z) << 2;
            // A large triangle shares a block with no other kind, but may with its like.
            (if face.1.diagonal() > large { key } else { key | 1 << 63 }, face)
        })
        .collect();
    keyed.sort_unstable_by_key(|&(key, (face, _))| (key, face));
    keyed.into_iter().map(|(_, face)| face).collect()
}

/// The lowest 21 bits of a whole number, two zeros between each.
fn spaced(value: f64) -> u64 {
    let steps = [(32, 0x1f_0000_0000_ffff), (16, 0x1f_0000_ff00_00ff), (8, 0x100f_00f0_0f00_f00f)];
    let steps = steps.into_iter().chain([(4, 0x10c3_0c30_c30c_30c3), (2, 0x1249_2492_4924_9249)]);
    steps.fold(value as u64 & 0x1f_ffff, |bits, (shift, mask)| (bits | bits << shift) & mask)
}
