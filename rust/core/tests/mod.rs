//! Tests of the core, one file for each question.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod backends;
mod cast;
mod errors;
mod joined;
mod media;
mod moved;
mod noise;
mod obj;
mod observe;
mod origins;
mod outward;
mod receiver;
mod scans;
mod sensor_pattern;
mod shapes;
mod starts;
mod sweep;
mod watertight;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec3};

use crate::{Backend, Images, Pose, Primitive, Scene, SensorPattern, SensorSpec, Shape, TriangleMesh, scan};

/// Xorshift64*: Vigna, "An experimental exploration of Marsaglia's xorshift generators, scrambled", 2016.
struct Random(u64);

impl Random {
    /// A number in [low, high).
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11;
        low + (high - low) * bits as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.between(low, high)))
    }

    /// A pose turned anywhere, with coordinates in [-reach, reach).
    fn pose(&mut self, reach: f64) -> Pose {
        let rotation = DMat3::from_axis_angle(self.direction(), self.between(-PI, PI));
        Pose { rotation, translation: self.vector(-reach, reach) }
    }

    /// A direction, uniform on the sphere.
    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(-1.0, 1.0);
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

fn primitive(shape: Shape, center: [f64; 3], size: [f64; 3]) -> Primitive {
    Primitive { shape, center, size, yaw: 0.0, label: 1, instance: 0, extinction: None }
}

/// A whole turn, level origins, no offsets.
fn spec(elevations: Vec<f64>, columns: usize) -> SensorSpec {
    SensorSpec {
        azimuth_offsets: vec![0.0; elevations.len()],
        origins: vec![[0.0; 3]; elevations.len()],
        elevations,
        columns,
        azimuth_start: PI,
        azimuth_span: TAU,
        min_range: 0.0,
        max_range: 1e4,
    }
}

/// Beams at equal angles, both ends included.
fn linear(high: f64, low: f64, beams: usize) -> Vec<f64> {
    let step = (low - high) / (beams - 1) as f64;
    (0..beams).map(|h| high + step * h as f64).collect()
}

fn pattern(spec: SensorSpec) -> SensorPattern {
    SensorPattern::new(spec).unwrap()
}

/// What a sensor sees from one pose.
fn scanned(scene: &Scene, pattern: &SensorPattern, pose: &Pose) -> Images {
    swept(scene, pattern, std::slice::from_ref(pose), 0)
}

/// What a sensor sees from one pose, or from one for each column, on this many threads.
fn swept(scene: &Scene, pattern: &SensorPattern, poses: &[Pose], threads: usize) -> Images {
    let mut images = Images::new(pattern.rows(), pattern.columns());
    scan(scene, pattern, poses, 0, &mut images.as_mut(), Some(Backend::Reference), threads).unwrap();
    images
}

/// The square [-1/2, 1/2]^2 as `cells` x `cells` quads of two triangles, at the heights that a function gives.
fn grid(cells: u32, height: impl Fn(f64, f64) -> f64) -> TriangleMesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for i in 0..=cells {
        for j in 0..=cells {
            let (x, y) = (f64::from(i) / f64::from(cells) - 0.5, f64::from(j) / f64::from(cells) - 0.5);
            vertices.push([x, y, height(x, y)]);
        }
    }
    for i in 0..cells {
        for j in 0..cells {
            let a = i * (cells + 1) + j;
            let (b, c, d) = (a + 1, a + cells + 1, a + cells + 2);
            faces.extend([[a, c, d], [a, d, b]]);
        }
    }
    TriangleMesh::new(vertices, faces).unwrap()
}

/// The unit box as twelve triangles with shared corners.
fn box_mesh() -> TriangleMesh {
    let corner = |i: u32| [2, 1, 0].map(|bit| f64::from(i >> bit & 1) - 0.5);
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    TriangleMesh::new((0..8).map(corner).collect(), faces.collect()).unwrap()
}

/// Shapes of every kind within 20 m of a place.
fn random_scene(random: &mut Random, count: usize, place: DVec3) -> Vec<Primitive> {
    (0..count)
        .map(|k| {
            let shape = match k % 5 {
                0 => Shape::Box,
                1 => Shape::Ellipsoid,
                2 => Shape::Cylinder,
                3 => Shape::Plane,
                _ => Shape::Mesh(if k % 2 == 0 { box_mesh() } else { grid(4, |x, y| x * y) }),
            };
            let mut size = random.vector(0.05, 6.0);
            if shape == Shape::Plane {
                size.z = 0.0;
            }
            Primitive {
                center: (place + random.vector(-20.0, 20.0)).to_array(),
                yaw: [0.0, FRAC_PI_2, random.between(-9.0, 9.0)][k % 3],
                label: (k % 200) as u8 + 1,
                instance: k as u32,
                ..primitive(shape, [0.0; 3], size.to_array())
            }
        })
        .collect()
}
