//! Closed rooms of round numbers: no ray leaves them, on any backend.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::{Tally, at, box_mesh, fast, linear, pattern, primitive, scene, seen, spec};
use crate::{Pose, Primitive, Scene, SensorPattern, Shape, TriangleMesh};

/// 65,536 rays; with half a cell, columns look along the axes and the diagonals.
fn sphere(high: f64, shift: f64) -> SensorPattern {
    let mut spec = spec(linear(high, -high, 64), 1024);
    spec.azimuth_start = PI + shift * spec.azimuth_span / 1024.0;
    pattern(spec)
}

fn rooms() -> Vec<Scene> {
    let slab = |axis: usize, sign: f64| {
        let (mut center, mut size) = ([0.0; 3], [20.0; 3]);
        (center[axis], size[axis]) = (sign * 10.5, 1.0);
        Primitive { label: axis as u8 + 1, ..primitive(Shape::Box, center, size) }
    };
    let sides = |axis| vec![slab(axis, -1.0), slab(axis, 1.0)];
    let plane = |z| primitive(Shape::Plane, [0.0, 0.0, z], [20.0, 20.0, 0.0]);
    // A quad for each wall, as bodies of their own.
    let mesh = box_mesh();
    let quads = mesh.faces().chunks(2).map(|pair| {
        let quad = TriangleMesh::new(mesh.vertices().to_vec(), pair.to_vec()).unwrap();
        primitive(Shape::Mesh(quad), [0.0; 3], [20.0; 3])
    });
    let rooms = [
        vec![primitive(Shape::Box, [0.0; 3], [20.0; 3])],
        vec![primitive(Shape::Mesh(box_mesh()), [0.0; 3], [20.0; 3])],
        [sides(0), sides(1), sides(2)].concat(),
        [sides(0), sides(1), vec![plane(-10.0), plane(10.0)]].concat(),
        quads.collect(),
    ];
    rooms.map(scene).into()
}

/// Six rectangles.
fn cards() -> Scene {
    let flat = scene(vec![primitive(Shape::Plane, [0.0; 3], [20.0, 20.0, 0.0]); 6]);
    let wall = |k: usize| {
        let sign = [-1.0, 1.0][k % 2];
        let mut pose = at(0.0, 0.0, 0.0);
        pose.translation[k / 2] = sign * 10.0;
        pose.rotation = match k / 2 {
            0 => glam::DMat3::from_rotation_y(FRAC_PI_2),
            1 => glam::DMat3::from_rotation_x(FRAC_PI_2),
            _ => glam::DMat3::IDENTITY,
        };
        pose
    };
    let poses: Vec<Pose> = (0..6).map(wall).collect();
    flat.moved(&[0, 1, 2, 3, 4, 5], &poses).unwrap()
}

#[test]
fn no_ray_leaves() {
    let edge = (1.0_f64 / 2.0_f64.sqrt()).atan();
    let patterns = [sphere(FRAC_PI_4, 0.0), sphere(FRAC_PI_4, 0.5), sphere(edge, 0.5)];
    for (room, scene) in rooms().iter().enumerate() {
        for (k, pattern) in patterns.iter().enumerate() {
            let pose = at(0.0, 0.0, [0.0, 2.5, -9.0][(room + k) % 3]);
            for backend in fast() {
                let images = seen(scene, pattern, &[pose], backend, 1);
                let leaks = images.depth.iter().filter(|&&depth| depth == 0.0).count();
                assert_eq!(leaks, 0, "room {room}, pattern {k}, {}", backend.name());
            }
        }
    }
}

#[test]
fn every_wall_is_where_the_reference_sees_it() {
    let mut tally = Tally::default();
    let edge = (1.0_f64 / 2.0_f64.sqrt()).atan();
    let mut all = rooms();
    all.push(cards());
    for (room, scene) in all.iter().enumerate() {
        for high in [FRAC_PI_4, edge, 1.57] {
            let mut spec = spec(linear(high, -high, 17), 96);
            for shift in [0.0, 0.5] {
                spec.azimuth_start = PI + shift * spec.azimuth_span / 96.0;
                for [x, y, z] in [[0.0; 3], [0.0, 0.0, 2.5], [-9.0, 0.0, 0.0], [3.0, -3.0, 9.99], [5.0, 5.0, 10.0]] {
                    let name = format!("room {room}, up to {high}, shift {shift}, from {x} {y} {z}");
                    tally.compare(name, scene, &pattern(spec.clone()), &[at(x, y, z)]);
                }
            }
        }
    }
    assert!(tally.hits > tally.rays * 9 / 10, "{tally:?}");
}
