//! Meshes as meshlets: sixteen close triangles, and groups of sixteen meshlets.

use glam::{DVec3, Vec3};

use super::AabbTable;
use super::aabb_table::f32_center;
use crate::Bounds;
use crate::intersect::Triangle;
use crate::simd::WIDEST;

/// Triangles of a meshlet: one to a lane.
const MESHLET_SIZE: usize = WIDEST;
/// Meshlets of a group: one to a lane.
pub(crate) const GROUP_SIZE: usize = WIDEST;

/// A mesh in its own frame.
#[derive(Debug)]
pub(crate) struct Meshlets {
    pub(crate) meshlets: Vec<Meshlet>,
    /// The boxes around the meshlets, and around each `GROUP_SIZE` of them in a row.
    pub(crate) meshlet_aabbs: AabbTable,
    /// A cone around the normals of each meshlet: its axis, by coordinate, and the sine of the angle to its side.
    pub(crate) normal_axes: [Vec<f32>; 3],
    pub(crate) normal_sines: Vec<f32>,
    pub(crate) group_aabbs: AabbTable,
    /// Triangles that are not part of a meshlet, and the boxes around them.
    pub(crate) large: Vec<LargeTriangle>,
    pub(crate) large_aabbs: AabbTable,
}

/// A triangle so large that its corners may be much further away than its plane is: its test takes f64.
#[derive(Debug)]
pub(crate) struct LargeTriangle {
    pub(crate) corners: [DVec3; 3],
    /// Its number in the mesh.
    pub(crate) triangle: u32,
}

/// Triangles larger than this are large [m]: some ten times the height of a sensor.
const LARGE: f64 = 16.0;

/// Sixteen triangles or fewer.
#[derive(Debug)]
pub(crate) struct Meshlet {
    /// Corner, axis, triangle: relative to the middle of the meshlet's box, which keeps them exact far from the mesh's origin.
    /// The edge from the last corner to the first is the longest.
    pub(crate) corners: [[[f32; MESHLET_SIZE]; 3]; 3],
    /// Their numbers in the mesh.
    pub(crate) triangles: [u32; MESHLET_SIZE],
    pub(crate) count: usize,
}

impl Meshlets {
    /// Meshlets of the triangles with an area, in the order of a Morton curve through their middles.
    pub(crate) fn new(vertices: &[DVec3], faces: &[[u32; 3]]) -> Meshlets {
        let corners = |face: u32| faces[face as usize].map(|v| vertices[v as usize]);
        let with_area = (0..faces.len() as u32).filter(|&face| {
            let [a, b, c] = corners(face);
            (b - a).cross(c - a) != DVec3::ZERO
        });
        let bounded = with_area.map(|face| (face, Triangle { corners: corners(face) }.bounds()));
        let (large, small): (Vec<_>, Vec<_>) = bounded.partition(|face| face.1.diagonal() > LARGE);
        let order = morton_order(small);
        let (mut meshlets, mut boxes) = (Vec::new(), Vec::new());
        let (mut normal_axes, mut normal_sines) = ([(); 3].map(|()| Vec::new()), Vec::new());
        for chunk in order.chunks(MESHLET_SIZE) {
            let bounds = chunk.iter().fold(Bounds::EMPTY, |all, face| all.union(face.1));
            let mut meshlet =
                Meshlet { corners: [[[0.0; MESHLET_SIZE]; 3]; 3], triangles: [0; MESHLET_SIZE], count: chunk.len() };
            for (lane, &(face, _)) in chunk.iter().enumerate() {
                meshlet.triangles[lane] = face;
                for (k, corner) in longest_last(corners(face)).into_iter().enumerate() {
                    let local = (corner - f32_center(&bounds)).as_vec3();
                    (0..3).for_each(|axis| meshlet.corners[k][axis][lane] = local[axis]);
                }
            }
            let (axis, sine) = normal_cone(chunk.iter().map(|&(face, _)| corners(face)));
            normal_axes.iter_mut().zip(axis.to_array()).for_each(|(table, x)| table.push(x));
            normal_sines.push(sine);
            meshlets.push(meshlet);
            boxes.push(bounds);
        }
        let padded = meshlets.len().next_multiple_of(WIDEST);
        normal_axes.iter_mut().chain([&mut normal_sines]).for_each(|table| table.resize(padded, 0.0));
        let groups =
            boxes.chunks(GROUP_SIZE).map(|group| group.iter().fold(Bounds::EMPTY, |all, &next| all.union(next)));
        Meshlets {
            group_aabbs: AabbTable::new(groups.collect()),
            meshlet_aabbs: AabbTable::new(boxes),
            normal_axes,
            normal_sines,
            meshlets,
            large: large.iter().map(|&(triangle, _)| LargeTriangle { corners: corners(triangle), triangle }).collect(),
            large_aabbs: AabbTable::new(large.iter().map(|face| face.1).collect()),
        }
    }
}

impl Meshlets {
    /// The number of groups and large triangles.
    pub(crate) fn parts(&self) -> usize {
        self.group_aabbs.count + self.large_aabbs.count
    }
}

/// A cone around the normals of triangles: its axis and the sine of the angle to its side, more than 1 if they have any
/// direction.
fn normal_cone(triangles: impl Iterator<Item = [DVec3; 3]> + Clone) -> (Vec3, f32) {
    let normals = triangles.map(|[a, b, c]| (b - a).cross(c - a).normalize_or_zero());
    let axis = normals.clone().sum::<DVec3>().normalize_or_zero();
    let cosine = normals.map(|normal| normal.dot(axis)).fold(1.0, f64::min);
    let sine = if cosine > 0.0 { (1.0 - cosine * cosine).sqrt() + 1e-4 } else { 2.0 };
    (axis.as_vec3(), sine as f32)
}

/// The corners in the same orientation, with the edge from the last to the first as the longest.
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

/// Triangles in the order of a Morton curve. The few that are much larger than the others come first, as they would
/// stretch the boxes of their meshlets.
fn morton_order(faces: Vec<(u32, Bounds)>) -> Vec<(u32, Bounds)> {
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
            let key = morton_bits(place.x) | morton_bits(place.y) << 1 | morton_bits(place.z) << 2;
            // A large triangle shares a meshlet only with other large ones.
            (if face.1.diagonal() > large { key } else { key | 1 << 63 }, face)
        })
        .collect();
    keyed.sort_unstable_by_key(|&(key, (face, _))| (key, face));
    keyed.into_iter().map(|(_, face)| face).collect()
}

/// The lowest 21 bits of a whole number, two zeros between each.
fn morton_bits(value: f64) -> u64 {
    let steps = [(32, 0x1f_0000_0000_ffff), (16, 0x1f_0000_ff00_00ff), (8, 0x100f_00f0_0f00_f00f)];
    let steps = steps.into_iter().chain([(4, 0x10c3_0c30_c30c_30c3), (2, 0x1249_2492_4924_9249)]);
    steps.fold(value as u64 & 0x1f_ffff, |bits, (shift, mask)| (bits | bits << shift) & mask)
}
