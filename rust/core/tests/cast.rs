//! Any rays: against whole scans, and what a direction and a range may be.

use glam::DVec3;

use super::{Random, linear, pattern, primitive, random_scene, spec, swept};
use crate::{Pose, Scene, Shape, cast};

#[test]
fn agrees_with_a_scan() {
    let mut random = Random(31);
    let mut spec = spec(linear(0.5, -0.5, 24), 200);
    spec.origins = (0..24).map(|_| random.vector(-0.2, 0.2).to_array()).collect();
    spec.max_range = 15.0;
    let pattern = pattern(spec);
    let scene = Scene::new(random_scene(&mut random, 100, DVec3::ZERO)).unwrap();
    let poses: Vec<Pose> = (0..200).map(|_| random.pose(5.0)).collect();
    let images = swept(&scene, &pattern, &poses, 1);
    let (mut origins, mut directions) = (Vec::new(), Vec::new());
    for pixel in 0..24 * 200 {
        let (row, column) = (pixel / 200, pixel % 200);
        origins.push(poses[column].point(pattern.origin(row, column)).to_array());
        directions.push((poses[column].vector(pattern.direction(row, column)) * random.between(0.1, 9.0)).to_array());
    }
    let one = cast(&scene, &origins, &directions, 15.0, 0, 1).unwrap();
    for threads in [0, 2, 3, 7] {
        assert_eq!(one, cast(&scene, &origins, &directions, 15.0, 0, threads).unwrap());
    }
    assert_eq!((&one.label, &one.instance, &one.primitive), (&images.label, &images.instance, &images.primitive));
    let hits = one.primitive.iter().filter(|&&p| p >= 0).count();
    assert!((500..24 * 200).contains(&hits), "{hits} hits");
    for pixel in 0..24 * 200 {
        assert!((one.distance[pixel] - images.depth[pixel]).abs() <= 1e-6 * images.depth[pixel]);
        let off = DVec3::from(one.normal[pixel].map(f64::from)) - DVec3::from(images.normal[pixel].map(f64::from));
        assert!(off.length() < 1e-5);
    }
}

#[test]
fn directions_of_any_length_and_the_range() {
    let scene = Scene::new(vec![primitive(Shape::Box, [10.0, 0.0, 0.0], [2.0; 3])]).unwrap();
    let distance =
        |length: f64, range| cast(&scene, &[[0.0; 3]], &[[length, 0.0, 0.0]], range, 0, 1).unwrap().distance[0];
    for length in [1.0, 5e-324, 1e-200, 1e200, f64::MAX] {
        assert!((distance(length, f64::INFINITY) - 9.0).abs() < 1e-6, "{length}");
    }
    assert_eq!(distance(-1.0, f64::INFINITY), 0.0);
    assert_eq!(distance(2.0, 8.9), 0.0);
    assert!(distance(2.0, 9.1) > 8.9);
    let none = cast(&scene, &[], &[], 1.0, 0, 2).unwrap();
    assert!(none.distance.is_empty() && none.normal.is_empty());
}

#[test]
fn normals_look_towards_the_ray() {
    let scene = Scene::new(vec![primitive(Shape::Box, [0.0; 3], [2.0; 3])]).unwrap();
    let origins = [[-5.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 5.0]];
    let directions = [[1.0, 0.1, 0.0], [1.0, 0.1, 0.0], [0.0, 0.1, -2.0]];
    let hits = cast(&scene, &origins, &directions, f64::INFINITY, 0, 1).unwrap();
    assert_eq!(hits.normal, [[-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
}
