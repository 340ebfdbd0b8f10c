//! Every bit of the images is the same for any number of threads, in a batch, and whatever else is asked for.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use super::random::{any_pattern, bodies};
use super::{Random, fast, linear, pattern, primitive, random_scene, scene, seen, spec};
use crate::{Backend, Images, ImagesMut, Pose, Primitive, Scene, SensorPattern, Shape, TriangleMesh, scan, scan_batch};

/// Scenes, patterns and poses that differ in everything: pieces of a scan, beams beside each other, rolling shutter.
fn scans() -> Vec<(Scene, SensorPattern, Vec<Pose>)> {
    let mut random = Random(81);
    let mut scans = Vec::new();
    for k in 0..12 {
        let mut primitives = random_scene(&mut random, 80, DVec3::ZERO);
        // Twins, whose pixels are always unresolved.
        primitives.extend(primitives.clone());
        primitives.push(primitive(Shape::Plane, [0.0, 0.0, -3.0], [90.0, 90.0, 0.0]));
        let scene = scene(primitives);
        let columns = [300, 513, 1024][k % 3];
        let mut spec = spec(linear(0.3, -0.6, 6), columns);
        match k % 4 {
            1 => spec.origins = vec![[0.3, -0.2, 0.1]; 6],
            2 => spec = any_pattern(&mut random, 6, columns),
            _ => {}
        }
        let pose = random.pose(5.0);
        let poses = match k % 5 {
            3 => {
                (0..columns).map(|w| Pose { translation: pose.translation * (1.0 + 1e-3 * w as f64), ..pose }).collect()
            }
            _ => vec![pose],
        };
        scans.push((scene, pattern(spec), poses));
    }
    scans
}

#[test]
fn any_number_of_threads() {
    for (k, (scene, pattern, poses)) in scans().iter().enumerate() {
        for backend in fast() {
            let one = seen(scene, pattern, poses, backend, 1);
            for threads in [2, 3, 7, 0] {
                let many = seen(scene, pattern, poses, backend, threads);
                assert!(one == many, "scan {k}, {}, {threads} threads", backend.name());
            }
        }
    }
}

/// Triangles seen edge-on are unresolved wherever they may be: but nowhere else, or bits of what is beside them would
/// depend on the cut.
#[test]
fn surfaces_seen_edge_on() {
    let columns = 1024_u32;
    let triangle =
        TriangleMesh::new(vec![[9.0, 0.0, -4.0], [9.0, 0.0, 4.0], [12.0, 0.0, 0.0]], vec![[0, 1, 2]]).unwrap();
    let mut random = Random(84);
    let mut primitives = vec![primitive(Shape::Ellipsoid, [0.3, -0.2, 0.1], [90.0, 80.0, 70.0])];
    primitives.extend((0..60).map(|_| {
        let column = random.between(0.0, f64::from(columns)).floor();
        let yaw = PI - TAU * (column + 0.5) / f64::from(columns);
        Primitive { yaw, ..primitive(Shape::Mesh(triangle.clone()), [0.0; 3], [1.0; 3]) }
    }));
    let (scene, pattern) = (scene(primitives), pattern(spec(linear(0.2, -0.2, 16), columns as usize)));
    for backend in fast() {
        let one = seen(&scene, &pattern, &[Pose::IDENTITY], backend, 1);
        for threads in [2, 3, 7] {
            let many = seen(&scene, &pattern, &[Pose::IDENTITY], backend, threads);
            assert!(one == many, "{}, {threads} threads", backend.name());
        }
    }
}

#[test]
fn a_batch() {
    let mut random = Random(82);
    let scene = bodies(&mut random, 80);
    let pattern = pattern(spec(linear(0.4, -0.4, 8), 150));
    let poses: Vec<Vec<Pose>> = (0..5).map(|k| vec![random.pose(9.0); [1, 150][k % 2]]).collect();
    for backend in fast() {
        let single = |poses: &Vec<Pose>| seen(&scene, &pattern, poses, backend, 1);
        let singles: Vec<Images> = poses.iter().map(single).collect();
        for threads in [1, 2, 7, 0] {
            let mut batch: Vec<Images> = poses.iter().map(|_| Images::new(8, 150)).collect();
            let mut all: Vec<ImagesMut> = batch.iter_mut().map(Images::as_mut).collect();
            let lists: Vec<&[Pose]> = poses.iter().map(Vec::as_slice).collect();
            scan_batch(&scene, &pattern, &lists, 0, &mut all, Some(backend), threads).unwrap();
            assert!(batch == singles, "{}, {threads} threads", backend.name());
        }
    }
}

/// What other scans left behind is not seen in the next one.
#[test]
fn a_scan_after_others() {
    let scans = scans();
    for backend in fast() {
        let look =
            |(scene, pattern, poses): &(Scene, SensorPattern, Vec<Pose>)| seen(scene, pattern, poses, backend, 1);
        let first: Vec<Images> = scans.iter().map(look).collect();
        let again: Vec<Images> = scans.iter().rev().map(look).collect();
        for (k, (a, b)) in first.iter().zip(again.iter().rev()).enumerate() {
            assert!(a == b, "scan {k}, {}", backend.name());
        }
    }
}

#[test]
fn images_that_are_not_wanted() {
    for (k, (scene, pattern, poses)) in scans().iter().enumerate() {
        for backend in fast() {
            let all = seen(scene, pattern, poses, backend, 1);
            for wanted in 0..8 {
                let mut some = Images::new(pattern.rows(), pattern.columns());
                some.depth.fill(f32::NAN);
                some.label.fill(9);
                let images = some.as_mut();
                let mut images = ImagesMut {
                    primitive: images.primitive.filter(|_| wanted & 1 != 0),
                    incidence: images.incidence.filter(|_| wanted & 2 != 0),
                    normal: images.normal.filter(|_| wanted & 4 != 0),
                    ..images
                };
                scan(scene, pattern, poses, 0, &mut images, Some(backend), 1).unwrap();
                let name = format!("scan {k}, {}, wanted {wanted}", backend.name());
                assert!(some.depth == all.depth, "{name}: depth");
                assert!((&some.label, &some.instance) == (&all.label, &all.instance), "{name}: label or instance");
                assert!(wanted & 1 == 0 || some.primitive == all.primitive, "{name}: primitive");
                assert!(wanted & 2 == 0 || some.incidence == all.incidence, "{name}: incidence");
                assert!(wanted & 4 == 0 || some.normal == all.normal, "{name}: normal");
                assert!(wanted & 1 != 0 || some.primitive.iter().all(|&index| index == -1), "{name}");
            }
        }
    }
}

/// Where the range is off by a rounding, a point at an edge may fall on the face beside it.
const FLIPPED: f64 = 0.005;

#[test]
fn incidence_and_normals() {
    let mut random = Random(83);
    let (mut pixels, mut flipped) = (0, 0);
    for round in 0..40 {
        let scene = bodies(&mut random, 80);
        let pattern = pattern(any_pattern(&mut random, 12, 150));
        let (pose, axis) = (random.pose(30.0), random.direction());
        // Standing still, driving straight on or turning while it sweeps.
        let (columns, step, twist) = match round % 3 {
            0 => (1, 0.0, 0.0),
            turning => (pattern.columns(), 0.01, 0.002 * f64::from(turning - 1)),
        };
        let moved = |k: usize| Pose {
            rotation: DMat3::from_axis_angle(axis, twist * k as f64) * pose.rotation,
            translation: pose.translation + DVec3::X * (step * k as f64),
        };
        let poses: Vec<Pose> = (0..columns).map(moved).collect();
        let expected = seen(&scene, &pattern, &poses, Backend::Reference, 1);
        for backend in fast() {
            let found = seen(&scene, &pattern, &poses, backend, 1);
            for i in 0..found.depth.len() {
                let (a, b) =
                    (DVec3::from(found.normal[i].map(f64::from)), DVec3::from(expected.normal[i].map(f64::from)));
                let off = f64::from((found.incidence[i] - expected.incidence[i]).abs()).max((a - b).length());
                pixels += usize::from(expected.depth[i] > 0.0);
                flipped += usize::from(off > 1e-3);
                let length = a.length();
                let unit = (length - 1.0).abs() < 1e-5 || (length == 0.0 && b.length() == 0.0);
                assert!(unit, "round {round}, {}, pixel {i}: {a}", backend.name());
            }
        }
    }
    let share = f64::from(flipped as u32) / f64::from(pixels as u32);
    assert!(pixels > 10_000 && share < FLIPPED, "{share} of {pixels} pixels");
}
