//! Random scenes, patterns and poses.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::{Random, Tally, box_mesh, grid, linear, pattern, primitive, scene, spec};
use crate::{Pose, Primitive, Scene, SensorSpec, Shape};

/// Tilted bodies of 5 cm to 100 m.
pub(super) fn bodies(random: &mut Random, count: usize) -> Scene {
    let primitives = (0..count).map(|k| body(random, k)).collect();
    let upright = scene(primitives);
    let tilted: Vec<u32> = (0..count as u32).filter(|_| random.between(0.0, 1.0) < 0.5).collect();
    let poses: Vec<Pose> = tilted.iter().map(|_| random.pose(40.0)).collect();
    upright.moved(&tilted, &poses).unwrap()
}

fn body(random: &mut Random, k: usize) -> Primitive {
    let shape = match random.between(0.0, 6.0) as usize {
        0 => Shape::Box,
        1 => Shape::Ellipsoid,
        2 => Shape::Cylinder,
        3 => Shape::Plane,
        4 => Shape::Mesh(box_mesh()),
        _ => Shape::Mesh(grid(random.pick(&[1, 3, 9]), |x, y| (9.0 * x).sin() * (7.0 * y).cos() / 3.0)),
    };
    let scale = random.pick(&[1.0, 1.0, 1.0, 20.0]);
    let mut size = [(); 3].map(|()| random.magnitude(0.05, 5.0) * scale);
    if shape == Shape::Plane {
        size[2] = 0.0;
    }
    Primitive {
        yaw: random.pick(&[0.0, FRAC_PI_2, 2.5]),
        label: (k % 200) as u8 + 1,
        instance: k as u32,
        ..primitive(shape, random.vector(-40.0, 40.0).to_array(), size)
    }
}

/// A pattern that may be anything that is allowed.
pub(super) fn any_pattern(random: &mut Random, rows: usize, columns: usize) -> SensorSpec {
    let (low, high) = random.pick(&[(-0.4, 0.1), (-1.5, 1.5), (-FRAC_PI_2, FRAC_PI_2), (-0.01, 0.01), (-1.57, -1.2)]);
    let mut elevations: Vec<f64> = (0..rows).map(|_| random.between(low, high)).collect();
    elevations.sort_by(|a, b| b.total_cmp(a));
    if random.between(0.0, 1.0) < 0.1 {
        elevations[0] = FRAC_PI_2.next_down();
    }
    elevations.dedup();
    let rows = elevations.len();
    let span = random.pick(&[TAU, TAU, 3.0, 0.02, PI, 6.2]);
    let offset = random.pick(&[0.0, 0.0, 3.0 * span / columns as f64, 2.0]);
    let beside = random.pick(&[0.0, 0.0, 0.05, 1.0]);
    let mut spec = spec(elevations, columns);
    if random.between(0.0, 1.0) < 0.5 {
        spec.azimuth_offsets = (0..rows).map(|row| offset * [1.0, -1.0, 0.3][row % 3]).collect();
        spec.origins = (0..rows)
            .map(|row| if row % 4 == 3 { [0.0; 3] } else { (random.vector(-1.0, 1.0) * beside).to_array() })
            .collect();
    } else {
        spec.azimuth_offsets = vec![offset; rows];
        spec.origins = vec![(random.vector(-1.0, 1.0) * beside).to_array(); rows];
    }
    let anywhere = random.between(-9.0, 9.0);
    spec.azimuth_start = random.pick(&[PI, 0.0, -PI, 1.0, 20.0, anywhere]);
    spec.azimuth_span = span;
    (spec.min_range, spec.max_range) = random.pick(&[(0.0, 1e4), (0.0, 1e4), (1.0, 30.0)]);
    spec
}

fn small_scans(seeds: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let mut random = Random(1000 + seed);
        let count = random.pick(&[1, 2, 5, 20, 60, 400]);
        let scene = bodies(&mut random, count);
        for scan in 0..6 {
            let (rows, columns) = random.pick(&[(7, 37), (1, 1), (3, 16), (5, 33), (16, 100), (2, 257), (9, 8)]);
            let pattern = pattern(any_pattern(&mut random, rows, columns));
            let pose = random.pose(40.0);
            tally.compare(format!("seed {seed}, scan {scan}"), &scene, &pattern, &[pose]);
        }
    }
    tally
}

fn large_scans(seeds: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let mut random = Random(5000 + seed);
        let mut primitives: Vec<Primitive> = (0..200).map(|k| body(&mut random, k)).collect();
        primitives.push(primitive(Shape::Plane, [0.0, 0.0, -1.8], [400.0, 300.0, 0.0]));
        let scene = scene(primitives);
        let mut spec = spec(linear(0.05, -0.43, 64), 1024);
        spec.max_range = 120.0;
        let pose = Pose { translation: random.vector(-20.0, 20.0) * DVec3::new(1.0, 1.0, 0.05), ..random.pose(0.0) };
        let level = Pose { translation: pose.translation, ..Pose::IDENTITY };
        let pattern = pattern(spec);
        tally.compare(format!("seed {seed}, turned"), &scene, &pattern, &[pose]);
        tally.compare(format!("seed {seed}, level"), &scene, &pattern, &[level]);
    }
    tally
}

#[test]
fn random_scenes() {
    let mut tally = small_scans(0..100);
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
    tally.print("small");
    tally = large_scans(0..2);
    assert!(tally.hits > tally.rays / 3, "{tally:?}");
    tally.print("large");
}

#[test]
#[ignore = "minutes"]
fn many_random_scenes() {
    small_scans(100..6000).print("small");
    large_scans(2..80).print("large");
}
