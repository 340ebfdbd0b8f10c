//! Rolling shutter: a pose for each column.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::random::{any_pattern, bodies};
use super::{Random, Tally, linear, pattern, spec};
use crate::{Pose, SensorSpec};

#[test]
fn every_column_elsewhere() {
    let mut tally = Tally::default();
    for seed in 0..60 {
        let mut random = Random(300 + seed);
        let scene = bodies(&mut random, 30);
        let pattern = pattern(any_pattern(&mut random, 6, 70));
        let reach = random.pick(&[0.01, 1.0, 40.0, 40.0, 1000.0]);
        let poses: Vec<Pose> = (0..70).map(|_| random.pose(reach)).collect();
        tally.compare(format!("seed {seed}, reach {reach}"), &scene, &pattern, &poses);
    }
    assert!(tally.hits > tally.rays / 10, "{tally:?}");
    tally.print("every column elsewhere");
}

/// 30 m/s and a turn of 90 degrees a second, at 10 scans a second.
fn drive(start: DVec3, columns: usize) -> Vec<Pose> {
    let pose = |w: usize| {
        let time = 0.1 * w as f64 / columns as f64;
        let rotation = DMat3::from_rotation_z(1.57 * time) * DMat3::from_rotation_y(0.2 * time);
        Pose { rotation, translation: start + DVec3::new(30.0, 2.0, 0.3) * time }
    };
    (0..columns).map(pose).collect()
}

#[test]
fn a_drive() {
    let mut tally = Tally::default();
    for seed in 0..12 {
        let mut random = Random(400 + seed);
        let scene = bodies(&mut random, 100);
        for columns in [100, 512] {
            let flat = spec(linear(0.3, -0.5, 16), columns);
            let apart = SensorSpec { origins: vec![[0.03, -0.05, 0.1]; 16], ..flat.clone() };
            for spec in [flat, apart] {
                let poses = drive(random.vector(-30.0, 30.0), columns);
                tally.compare(format!("seed {seed}, {columns} columns"), &scene, &pattern(spec), &poses);
            }
        }
    }
    tally.print("drive");
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

#[test]
fn equal_poses() {
    let mut tally = Tally::default();
    for seed in 0..40 {
        let mut random = Random(500 + seed);
        let scene = bodies(&mut random, 60);
        let pattern = pattern(any_pattern(&mut random, 8, 90));
        tally.compare(format!("seed {seed}"), &scene, &pattern, &[random.pose(30.0); 90]);
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

/// Beams less than a column apart are rasterized together; here at a steady speed, with small triangles near and far.
#[test]
fn sub_rays_of_a_beam() {
    let mut tally = Tally::default();
    for seed in 0..24 {
        let mut random = Random(600 + seed);
        let scene = bodies(&mut random, 150);
        let mut spec = spec(linear(0.2, -0.5, 24), random.pick(&[200, 512, 700]));
        spec.azimuth_span = random.pick(&[TAU, TAU, 6.2, 1.0]);
        let width = spec.azimuth_span / spec.columns as f64;
        let offsets = random.pick(&[[0.2, -0.1, -0.15], [0.9, 0.0, 0.5], [0.7, -0.7, 0.0]]);
        spec.azimuth_offsets = (0..24).map(|row| 0.3 + offsets[row % 3] * width).collect();
        if random.between(0.0, 1.0) < 0.5 {
            spec.origins = (0..24).map(|row| [0.0, 0.0, if row < 12 { 0.2 } else { 0.1 }]).collect();
        }
        let start = random.pose(30.0);
        let speed = random.pick(&[0.0, 5.0, 15.0, 60.0]);
        let along = |w: usize| start.rotation.x_axis * speed * 0.1 * w as f64 / spec.columns as f64;
        let poses: Vec<Pose> =
            (0..spec.columns).map(|w| Pose { translation: start.translation + along(w), ..start }).collect();
        let poses = if speed == 0.0 { &poses[..1] } else { &poses };
        tally.compare(format!("seed {seed}, {speed} m/s"), &scene, &pattern(spec.clone()), poses);
    }
    tally.print("sub-rays");
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}
