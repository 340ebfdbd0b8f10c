//! Tiny scenes of round numbers, where everything touches everything.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::ops::Range;

use glam::{DMat3, DVec3};

use super::{Random, Tally, box_mesh, grid, pattern, primitive, scene, spec};
use crate::{Pose, Primitive, Scene, SensorPattern, Shape, TriangleMesh};

const PLACES: [f64; 16] = [0.0, 0.0, 0.0, 0.5, -0.5, 1.0, -1.0, 1.73, -1.73, 1e-9, -1e-4, 3.0, -3.0, 10.0, 100.0, 0.01];
const SIZES: [f64; 12] = [1.0, 1.0, 2.0, 2.0, 6.0, 0.5, 3.46, 1e-3, 1e-6, 20.0, 200.0, 0.02];
const ANGLES: [f64; 8] = [0.0, 0.0, 0.0, FRAC_PI_2, FRAC_PI_4, PI, 1e-9, 0.3];

fn place(random: &mut Random) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| random.pick(&PLACES)))
}

fn pose(random: &mut Random) -> Pose {
    let [yaw, pitch, roll] = [(); 3].map(|()| random.pick(&ANGLES));
    let rotation = DMat3::from_rotation_z(yaw) * DMat3::from_rotation_y(pitch) * DMat3::from_rotation_x(roll);
    Pose { rotation, translation: place(random) }
}

/// A few triangles between few points.
fn shards(random: &mut Random) -> TriangleMesh {
    let vertices: Vec<[f64; 3]> =
        (0..6).map(|_| [(); 3].map(|()| random.pick(&[-0.5, 0.0, 0.5, 0.25, 1e-9]))).collect();
    let faces = (0..7).map(|_| [(); 3].map(|()| random.between(0.0, 6.0) as u32)).collect();
    TriangleMesh::new(vertices, faces).unwrap()
}

fn body(random: &mut Random, k: usize) -> Primitive {
    let shape = match random.between(0.0, 8.0) as usize {
        0 | 1 => Shape::Box,
        2 => Shape::Ellipsoid,
        3 => Shape::Cylinder,
        4 => Shape::Plane,
        5 => Shape::Mesh(box_mesh()),
        6 => Shape::Mesh(grid(2, |x, y| x * y)),
        _ => Shape::Mesh(shards(random)),
    };
    let mut size = [(); 3].map(|()| random.pick(&SIZES));
    if shape == Shape::Plane {
        size[2] = 0.0;
    }
    let center = place(random).to_array();
    let yaw = random.pick(&ANGLES);
    Primitive { yaw, label: k as u8 + 1, instance: k as u32, ..primitive(shape, center, size) }
}

fn bodies(random: &mut Random) -> Scene {
    let count = random.pick(&[1, 1, 2, 3, 6, 12]);
    let upright = scene((0..count).map(|k| body(random, k)).collect());
    if random.between(0.0, 1.0) < 0.6 {
        return upright;
    }
    upright.moved(&[0], &[pose(random)]).unwrap()
}

/// Columns along the axes and the diagonals, or beside them.
fn rays(random: &mut Random) -> SensorPattern {
    let corner = FRAC_1_SQRT_2.atan();
    let elevations = vec![FRAC_PI_2.next_down(), FRAC_PI_4, corner, 0.1, 0.0, -1e-9, -FRAC_PI_4, -1.5];
    let mut spec = spec(elevations, 16);
    spec.azimuth_start = random.pick(&[PI, PI + TAU / 32.0, 0.0, PI + 1e-9]);
    let origin = random.pick(&[[0.0; 3], [0.0; 3], [0.0; 3], [0.0, 0.0, 0.5], [0.5, 0.0, 0.0], [0.0, -0.5, 1e-9]]);
    spec.origins = vec![origin; 8];
    pattern(spec)
}

fn scans(seeds: Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let mut random = Random(1 + seed * 7919);
        let scene = bodies(&mut random);
        for scan in 0..2 {
            let (pattern, pose) = (rays(&mut random), pose(&mut random));
            tally.compare(format!("seed {seed}, scan {scan}"), &scene, &pattern, &[pose]);
        }
    }
    tally
}

#[test]
fn round_numbers() {
    let tally = scans(0..3000);
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
    tally.print("fuzz");
}

#[test]
#[ignore = "minutes"]
fn many_round_numbers() {
    scans(3000..40_000).print("fuzz");
}
