//! Scans of a sensor that moves while it turns: one pose for each column.

use glam::{DMat3, DVec3};

use super::{Random, linear, pattern, primitive, random_scene, scanned, spec, swept};
use crate::{Pose, Scene, SensorSpec, Shape};

#[test]
fn driving_towards_a_wall() {
    // 10 m/s towards a wall 30 m ahead, and 0.1 s for a turn; the wall has no end that a ray of the front could pass.
    let (speed, turn, columns) = (10.0, 0.1, 360);
    let wall = primitive(Shape::Plane, [0.0; 3], [1e4, 1e4, 0.0]);
    let upright = Pose { rotation: DMat3::from_rotation_y(std::f64::consts::FRAC_PI_2), translation: DVec3::X * 30.0 };
    let scene = Scene::new(vec![wall]).unwrap().moved(&[0], &[upright]).unwrap();
    let along = |column: usize| speed * turn * (column as f64 + 0.5) / columns as f64;
    let poses: Vec<Pose> = (0..columns).map(|w| Pose { translation: DVec3::X * along(w), ..Pose::IDENTITY }).collect();
    let spec = SensorSpec { origins: vec![[0.1, 0.0, 0.0]; 3], ..spec(vec![0.2, 0.0, -0.1], columns) };
    let pattern = pattern(spec.clone());
    let images = swept(&scene, &pattern, &poses, 2);
    let mut hits = 0;
    for (row, elevation) in spec.elevations.iter().enumerate() {
        for column in 0..columns {
            let azimuth: f64 = spec.azimuth_start - (column as f64 + 0.5) * spec.azimuth_span / columns as f64;
            // The beam starts 0.1 m along its heading, and covers what is left of the way at this angle to the wall.
            let left = 30.0 - along(column) - 0.1 * azimuth.cos();
            let expected = left / (elevation.cos() * azimuth.cos());
            let depth = f64::from(images.depth[row * columns + column]);
            if azimuth.cos() > 0.01 {
                hits += 1;
                assert!((depth - expected).abs() < 1e-6 * expected, "{depth} is not {expected}");
            } else if azimuth.cos() < 0.0 {
                assert_eq!(depth, 0.0);
            }
        }
    }
    assert!(hits > 500);
}

#[test]
fn each_column_is_that_of_a_scan_from_its_pose() {
    let mut random = Random(51);
    let scene = Scene::new(random_scene(&mut random, 80, DVec3::ZERO)).unwrap();
    let pattern = pattern(spec(linear(0.8, -0.8, 16), 24));
    let poses: Vec<Pose> = (0..24).map(|_| random.pose(9.0)).collect();
    let images = swept(&scene, &pattern, &poses, 1);
    for (column, pose) in poses.iter().enumerate() {
        let whole = scanned(&scene, &pattern, pose);
        for row in 0..16 {
            let i = row * 24 + column;
            assert_eq!((images.depth[i], images.primitive[i]), (whole.depth[i], whole.primitive[i]));
            assert_eq!(images.normal[i], whole.normal[i]);
        }
    }
    assert!(images.primitive.iter().any(|&p| p >= 0));
}

#[test]
fn the_same_pose_for_each_column_is_one_pose() {
    let mut random = Random(52);
    let scene = Scene::new(random_scene(&mut random, 80, DVec3::ZERO)).unwrap();
    let pattern = pattern(spec(linear(0.8, -0.8, 16), 24));
    let pose = random.pose(9.0);
    assert_eq!(swept(&scene, &pattern, &vec![pose; 24], 1), scanned(&scene, &pattern, &pose));
}
