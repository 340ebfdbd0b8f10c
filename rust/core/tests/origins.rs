//! Beams that start beside the middle of the sensor.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::sensor_pattern::returns_to_its_pixels;
use super::{Random, linear, pattern, primitive, scanned, spec};
use crate::{Pose, Scene, SensorSpec, Shape};

/// 64 lasers in two columns at the left and the right of the head, the higher ones higher up (Velodyne HDL-64E).
fn velodyne() -> SensorSpec {
    let mut spec = spec(linear(0.035, -0.43, 64), 500);
    spec.azimuth_offsets = (0..64).map(|h| 0.1 * f64::from(h % 4) - 0.15).collect();
    let side = |h: i32| if h % 2 == 0 { 0.026 } else { -0.026 };
    spec.origins = (0..64).map(|h| [0.0, side(h), 0.21 - 0.02 * f64::from(h) / 63.0]).collect();
    spec
}

/// 128 lasers 15.8 mm in front of the axis, in four columns (Ouster OS1-128).
fn ouster() -> SensorSpec {
    let mut spec = spec(linear(0.39, -0.39, 128), 512);
    spec.azimuth_offsets = (0..128).map(|h| [4.23_f64, 1.41, -1.41, -4.23][h % 4].to_radians()).collect();
    spec.origins = vec![[0.015_806, 0.0, 0.0]; 128];
    spec
}

#[test]
fn rays_start_beside_their_own_azimuth() {
    let mut spec = spec(vec![0.1, -0.1], 4);
    spec.azimuth_start = FRAC_PI_2 + std::f64::consts::FRAC_PI_4;
    spec.azimuth_offsets = vec![0.0, FRAC_PI_2];
    spec.origins = vec![[1.0, 2.0, 3.0], [0.5, 0.25, -1.0]];
    let pattern = pattern(spec);
    // Column 0 looks to +y; the offset turns row 1 on to -x.
    assert!((pattern.origin(0, 0) - DVec3::new(-2.0, 1.0, 3.0)).length() < 1e-15);
    assert!((pattern.origin(0, 1) - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-15);
    assert!((pattern.origin(1, 0) - DVec3::new(-0.5, -0.25, -1.0)).length() < 1e-15);
    let all = pattern.origins();
    assert_eq!(all.len(), 8);
    assert_eq!(all[5], pattern.origin(1, 1).to_array());
}

#[test]
fn points_project_to_their_pixels() {
    returns_to_its_pixels(velodyne());
    returns_to_its_pixels(ouster());
    returns_to_its_pixels(SensorSpec { azimuth_start: 1.0, azimuth_span: 2.0, ..velodyne() });
    returns_to_its_pixels(SensorSpec { azimuth_start: 1.0, azimuth_span: 2.0, ..ouster() });
    for [forward, left] in [[0.2, 0.2], [0.2, -0.2], [-0.2, 0.2], [-0.2, -0.2], [0.0, 0.2]] {
        let common = vec![[forward, left, 0.1]; 40];
        let spec = spec(linear(0.3, -0.5, 40), 300);
        returns_to_its_pixels(SensorSpec { origins: common.clone(), ..spec.clone() });
        // The same with a table of different origins.
        let mut uneven = common;
        uneven[39][2] -= 1e-3;
        returns_to_its_pixels(SensorSpec { origins: uneven, ..spec });
    }
}

#[test]
fn one_origin_and_a_table_of_it_agree() {
    for origin in [[0.015_806, 0.0, 0.0], [-0.3, 0.2, 0.1], [0.1, -0.4, 0.0]] {
        let one = SensorSpec { origins: vec![origin; 24], ..spec(linear(0.2, -0.4, 24), 64) };
        let mut table = one.clone();
        table.origins[23][2] += 1e-15;
        let mut random = Random(13);
        let points: Vec<_> = (0..20_000).map(|_| random.vector(-2.0, 2.0).to_array()).collect();
        let (a, b) = (pattern(one).project(&points), pattern(table).project(&points));
        assert_eq!(a, b);
        assert!(a.rows.contains(&-1) && a.rows.contains(&0) && a.rows.contains(&23));
    }
}

#[test]
fn points_that_no_beam_can_be_turned_to() {
    let beside = SensorSpec { origins: vec![[0.0, 0.2, 0.0]], ..spec(vec![0.0], 8) };
    let before = SensorSpec { origins: vec![[0.2, 0.0, 0.0]], ..spec(vec![0.0], 8) };
    for spec in [beside, before] {
        let pattern = pattern(spec);
        let found = pattern.project(&[[0.1, 0.1, 0.0], [0.5, 0.5, 0.0], [0.0; 3]]);
        assert_eq!((found.rows[0], found.rows[2]), (-1, -1));
        assert_eq!(found.rows[1], 0);
    }
}

#[test]
fn a_point_behind_the_axis_of_a_beam_that_starts_there() {
    let spec = SensorSpec { origins: vec![[-0.5, 0.0, 0.0]], ..spec(vec![0.0], 8) };
    let found = pattern(spec.clone()).project(&[[-0.3, 1e-9, 0.0]]);
    // Two rays pass it: one looks ahead from 0.2 m behind it, one looks back from 0.8 m before it.
    assert!([0.2_f32, 0.8].contains(&found.distances[0]), "{:?}", found.distances);
}

#[test]
fn beams_start_at_their_own_heights() {
    let ground = primitive(Shape::Plane, [0.0, 0.0, -2.0], [100.0, 100.0, 0.0]);
    let mut spec = spec(vec![-0.5, -0.6], 10);
    spec.origins = vec![[0.3, 0.1, 1.0], [0.0, 0.0, -1.0]];
    let images = scanned(&Scene::new(vec![ground]).unwrap(), &pattern(spec), &Pose::IDENTITY);
    assert!((f64::from(images.depth[0]) - 3.0 / 0.5_f64.sin()).abs() < 1e-5);
    assert!((f64::from(images.depth[10]) - 1.0 / 0.6_f64.sin()).abs() < 1e-5);
}

#[test]
fn a_round_wall_is_seen_from_beside_its_axis() {
    let tower = primitive(Shape::Cylinder, [0.0; 3], [20.0, 20.0, 50.0]);
    let mut spec = spec(vec![0.1, -0.2], 90);
    spec.origins = vec![[0.2, 0.0, 0.0], [0.5, -3.0, 1.0]];
    let images = scanned(&Scene::new(vec![tower]).unwrap(), &pattern(spec), &Pose::IDENTITY);
    for column in 0..90 {
        // Across, a beam meets the wall of 10 m where (forward + t)^2 + left^2 = 100.
        assert!((f64::from(images.depth[column]) - 9.8 / 0.1_f64.cos()).abs() < 1e-5);
        let across = (100.0_f64 - 9.0).sqrt() - 0.5;
        assert!((f64::from(images.depth[90 + column]) - across / 0.2_f64.cos()).abs() < 1e-5);
    }
}
