//! Scenes whose primitives have been moved.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{Random, box_mesh, linear, pattern, primitive, random_scene, scanned, spec};
use crate::body::Solid;
use crate::{FreePathKey, Images, Pose, Primitive, Scene, Shape};

fn upright(primitive: &Primitive) -> Pose {
    Pose { rotation: DMat3::from_rotation_z(primitive.yaw), translation: DVec3::from(primitive.center) }
}

/// Pixels that differ in more than rounding.
fn different(a: &Images, b: &Images) -> usize {
    let near = |i: usize| (a.depth[i] - b.depth[i]).abs() <= 1e-5 * (1.0 + a.depth[i]);
    (0..a.depth.len()).filter(|&i| a.primitive[i] != b.primitive[i] || !near(i)).count()
}

#[test]
fn as_if_built_there() {
    let mut random = Random(41);
    let before = random_scene(&mut random, 60, DVec3::ZERO);
    let mut after = before.clone();
    let moved: Vec<u32> = vec![7, 4, 0, 59, 23, 31];
    for &i in &moved {
        after[i as usize].center = random.vector(-9.0, 9.0).to_array();
        after[i as usize].yaw = random.between(-9.0, 9.0);
    }
    let poses: Vec<Pose> = moved.iter().map(|&i| upright(&after[i as usize])).collect();
    let old = Scene::new(before.clone()).unwrap();
    let new = old.moved(&moved, &poses).unwrap();
    let pattern = pattern(spec(linear(1.2, -1.2, 48), 256));
    let seen = scanned(&new, &pattern, &Pose::IDENTITY);
    let built = scanned(&Scene::new(after).unwrap(), &pattern, &Pose::IDENTITY);
    assert!(different(&seen, &built) <= 2, "{} pixels", different(&seen, &built));
    // The old scene stays as it is, and moving back leads there.
    let still = scanned(&Scene::new(before.clone()).unwrap(), &pattern, &Pose::IDENTITY);
    assert_eq!(scanned(&old, &pattern, &Pose::IDENTITY), still);
    assert!(different(&seen, &still) > 100);
    let home: Vec<Pose> = moved.iter().map(|&i| upright(&before[i as usize])).collect();
    let back = scanned(&new.moved(&moved, &home).unwrap(), &pattern, &Pose::IDENTITY);
    assert!(different(&back, &still) <= 2);
    assert_eq!(scanned(&old.moved(&[], &[]).unwrap(), &pattern, &Pose::IDENTITY), still);
}

#[test]
fn moving_everything_is_moving_the_sensor() {
    let mut random = Random(43);
    let scene = Scene::new(random_scene(&mut random, 60, DVec3::ZERO)).unwrap();
    let primitives = random_scene(&mut Random(43), 60, DVec3::ZERO);
    let pattern = pattern(spec(linear(1.2, -1.2, 32), 128));
    let still = scanned(&scene, &pattern, &Pose::IDENTITY);
    for reach in [20.0, 1e6] {
        let by = random.pose(reach);
        let tilted = |p: &Primitive| {
            let pose = upright(p);
            Pose { rotation: by.rotation * pose.rotation, translation: by.point(pose.translation) }
        };
        let poses: Vec<Pose> = primitives.iter().map(tilted).collect();
        let all: Vec<u32> = (0..60).collect();
        let moved = scanned(&scene.moved(&all, &poses).unwrap(), &pattern, &by);
        assert!(different(&moved, &still) <= 3, "{} pixels at {reach} m", different(&moved, &still));
    }
}

#[test]
fn tilted_bodies_in_closed_form() {
    let shapes = [Shape::Box, Shape::Ellipsoid, Shape::Cylinder, Shape::Plane, Shape::Mesh(box_mesh())];
    let size = |shape: &Shape| if *shape == Shape::Plane { [4.0, 4.0, 0.0] } else { [4.0, 4.0, 2.0] };
    let primitives = shapes.iter().map(|shape| primitive(shape.clone(), [0.0; 3], size(shape))).collect();
    let scene = Scene::new(primitives).unwrap();
    // Leaning back by 30 degrees, ahead of the ray; the others stand out of the way.
    let lean = DMat3::from_rotation_y(-std::f64::consts::FRAC_PI_6);
    let (sin, cos) = std::f64::consts::FRAC_PI_6.sin_cos();
    for (ahead, shape) in shapes.iter().enumerate() {
        let at = |k: usize| Pose {
            rotation: lean,
            translation: if k == ahead { DVec3::X * 10.0 } else { DVec3::Z * (100.0 + 10.0 * k as f64) },
        };
        let poses: Vec<Pose> = (0..5).map(at).collect();
        let moved = scene.moved(&[0, 1, 2, 3, 4], &poses).unwrap();
        let hit = moved.closest(DVec3::ZERO, DVec3::X, FreePathKey::of_ray(0, 0)).unwrap();
        // Along x the body's frame is crossed in the direction (cos, 0, -sin).
        let (half, normal) = match shape {
            Shape::Ellipsoid => {
                let reach = 1.0 / (cos * cos / 4.0 + sin * sin).sqrt();
                (reach, DVec3::new(cos / 4.0, 0.0, -sin).normalize())
            }
            Shape::Plane => (0.0, DVec3::Z),
            _ => (1.0 / sin, DVec3::Z),
        };
        assert_eq!(hit.primitive, ahead);
        assert!((hit.distance - (10.0 - half)).abs() < 1e-12, "{shape:?}: {}", hit.distance);
        let found = moved.normal(hit.primitive, hit.part, DVec3::X * hit.distance);
        assert!(((lean * normal).dot(found).abs() - 1.0).abs() < 1e-12, "{shape:?}: {found}");
    }
}

#[test]
fn meshes_are_shared() {
    let scene = Scene::new(vec![primitive(Shape::Mesh(box_mesh()), [0.0; 3], [2.0; 3])]).unwrap();
    let moved = scene.moved(&[0], &[Pose { translation: DVec3::X, ..Pose::IDENTITY }]).unwrap();
    match (&scene.bodies()[0].solid, &moved.bodies()[0].solid) {
        (Solid::Mesh(a), Solid::Mesh(b)) => assert!(Arc::ptr_eq(a, b)),
        _ => panic!("a mesh became something else"),
    }
}

#[test]
fn a_rotation_from_a_float32_text_keeps_its_body_in_shape() {
    let scene = Scene::new(vec![primitive(Shape::Ellipsoid, [0.0; 3], [2.0; 3])]).unwrap();
    let mut rotation = DMat3::from_rotation_z(0.5);
    rotation.x_axis *= 1.0 + 4e-7;
    rotation.y_axis += rotation.x_axis * 4e-7;
    let ball = scene.moved(&[0], &[Pose { rotation, translation: DVec3::X * 5.0 }]).unwrap();
    let hit = ball.closest(DVec3::ZERO, DVec3::X, FreePathKey::of_ray(0, 0)).unwrap();
    assert!((hit.distance - 4.0).abs() < 1e-14, "{}", hit.distance);
}
