//! Rays that start on a surface do not hit it there.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{Random, box_mesh, linear, pattern, primitive, spec};
use crate::body::{Body, MeshBody, Solid};
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Ray, Rectangle};
use crate::{Backend, Images, Pose, Scene, Shape, scan};

const HALF: DVec3 = DVec3::new(2.0, 3.5, 1.0);

/// From a direction to the point of a surface that lies there, and the outward normal.
type Surface = fn(DVec3) -> (DVec3, DVec3);

/// Convex bodies and their surfaces.
fn solids() -> [(Solid, Surface); 4] {
    let on_box: Surface = |towards| {
        let point = HALF * towards / towards.abs().max_element();
        (point, Cuboid { half: HALF }.normal(point))
    };
    let on_ball: Surface = |towards| (HALF * towards, (towards / HALF).normalize());
    let on_can: Surface = |towards| {
        let point = HALF * towards / towards.truncate().length().max(towards.z.abs());
        (point, Cylinder { half: HALF }.normal(point))
    };
    let mesh = MeshBody::new(box_mesh(), 2.0 * HALF);
    [
        (Solid::Cuboid(Cuboid { half: HALF }), on_box),
        (Solid::Ellipsoid(Ellipsoid { radii: HALF }), on_ball),
        (Solid::Cylinder(Cylinder { half: HALF }), on_can),
        (Solid::Mesh(Arc::new(mesh)), on_box),
    ]
}

fn poses(random: &mut Random) -> [Pose; 3] {
    let level = Pose { rotation: DMat3::from_rotation_z(0.3), translation: random.vector(-50.0, 50.0) };
    [Pose::IDENTITY, level, random.pose(1e4)]
}

#[test]
fn from_a_closed_surface() {
    let mut random = Random(31);
    for (k, (solid, surface)) in solids().into_iter().enumerate() {
        for pose in poses(&mut random) {
            let body = Body::new(solid.clone(), pose, None);
            for _ in 0..3000 {
                let (point, normal) = surface(random.direction());
                let direction = random.direction();
                // Nearly along the surface as well.
                let rise = random.between(-9.0, 0.0).exp();
                let along = (direction - normal * direction.dot(normal)).normalize();
                let (out, into) = (along + rise * normal, along - rise * normal);
                let see = |direction: DVec3| {
                    let ray = Ray { origin: pose.point(point), direction: pose.vector(direction) };
                    body.intersect(&ray, f32::INFINITY, || 0.0).map(|hit| hit.distance)
                };
                assert_eq!(see(out), None, "solid {k} at {pose:?}, out from {point}");
                let far = see(into).unwrap();
                assert!(far > 1e-7, "solid {k} at {pose:?}, into it from {point}: {far}");
            }
        }
    }
}

#[test]
fn from_a_rectangle() {
    let mut random = Random(32);
    for pose in poses(&mut random) {
        let body = Body::new(Solid::Rectangle(Rectangle { half: HALF.truncate() }), pose, None);
        for _ in 0..3000 {
            let point = (HALF * random.vector(-1.0, 1.0)).with_z(0.0);
            let ray = Ray { origin: pose.point(point), direction: random.direction() };
            assert_eq!(body.intersect(&ray, f32::INFINITY, || 0.0), None, "{pose:?}, from {point}");
        }
    }
}

#[test]
fn a_scan_from_a_roof() {
    let hull = primitive(Shape::Ellipsoid, [0.0; 3], [200.0; 3]);
    for shape in [Shape::Box, Shape::Ellipsoid, Shape::Cylinder, Shape::Plane, Shape::Mesh(box_mesh())] {
        let (height, tall) = if shape == Shape::Plane { (0.7, 0.0) } else { (0.5, 0.4) };
        let below = primitive(shape.clone(), [2.3, 1.1, height], [2.0, 2.0, tall]);
        let scene = Scene::new(vec![hull.clone(), below]).unwrap();
        let origin = Pose { translation: DVec3::new(2.3, 1.1, 0.7), ..Pose::IDENTITY };
        for min_range in [0.0, 0.5] {
            let up = crate::SensorSpec { min_range, ..spec(linear(1.5, 0.01, 16), 64) };
            for backend in Backend::available() {
                let mut images = Images::new(16, 64);
                scan(&scene, &pattern(up.clone()), &[origin], 0, &mut images.as_mut(), Some(backend), 1).unwrap();
                let name = format!("{shape:?}, {}, not nearer than {min_range}", backend.name());
                assert!(images.primitive.iter().all(|&index| index == 0), "{name}");
                assert!(images.depth.iter().all(|&depth| (depth - 100.0).abs() < 3.0), "{name}");
            }
        }
    }
}
