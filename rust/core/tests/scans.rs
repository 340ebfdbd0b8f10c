//! Whole scans: against every surface asked in turn, in degenerate scenes, far from 0, on any number of threads.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec3};

use super::{Random, box_mesh, grid, linear, pattern, primitive, spec};
use crate::{Images, Pose, Primitive, Scene, SensorPattern, Shape, TriangleMesh, scan};

fn random_scene(random: &mut Random, count: usize, place: DVec3) -> Vec<Primitive> {
    (0..count)
        .map(|k| {
            let shape = match k % 5 {
                0 => Shape::Box,
                1 => Shape::Ellipsoid,
                2 => Shape::Cylinder,
                3 => Shape::Plane,
                _ => Shape::Mesh(if k % 2 == 0 { box_mesh() } else { grid(4, |x, y| x * y) }),
            };
            let mut size = random.vector(0.05, 6.0);
            if shape == Shape::Plane {
                size.z = 0.0;
            }
            Primitive {
                center: (place + random.vector(-20.0, 20.0)).to_array(),
                yaw: [0.0, FRAC_PI_2, random.between(-9.0, 9.0)][k % 3],
                label: (k % 200) as u8 + 1,
                instance: k as u32,
                ..primitive(shape, [0.0; 3], size.to_array())
            }
        })
        .collect()
}

fn hdl64() -> SensorPattern {
    pattern(spec(linear(3_f64.to_radians(), -25_f64.to_radians(), 64), 1024))
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose { translation: DVec3::new(x, y, z), ..Pose::IDENTITY }
}

fn agrees_with_every_surface(scene: &Scene, pattern: &SensorPattern, pose: &Pose) -> usize {
    let images = scan(scene, pattern, pose);
    let mut hits = 0;
    for row in 0..images.rows {
        for column in 0..images.columns {
            let origin = pose.point(pattern.origin(row));
            let direction = pose.vector(pattern.direction(row, column));
            let all = scene.closest_of_all(origin, direction);
            let all = all.filter(|hit| pattern.reported(hit.hit.distance).is_some());
            let one = images.get(row, column);
            let seen = one.map(|r| (r.depth, r.primitive, r.label, r.instance));
            let expected = all.map(|s| (s.hit.distance as f32, s.primitive as i32, s.label, s.instance));
            assert_eq!(seen, expected, "row {row}, column {column}");
            hits += usize::from(one.is_some());
        }
    }
    hits
}

#[test]
fn agrees_with_every_surface_in_random_scenes() {
    let mut random = Random(1);
    let pattern = pattern(spec(linear(1.5, -1.5, 24), 96));
    for count in [1, 2, 3, 10, 100, 400] {
        let scene = Scene::new(random_scene(&mut random, count, DVec3::ZERO)).unwrap();
        for _ in 0..3 {
            let turn = DMat3::from_axis_angle(random.direction(), random.between(-PI, PI));
            let pose = Pose { rotation: turn, translation: random.vector(-10.0, 10.0) };
            let hits = agrees_with_every_surface(&scene, &pattern, &pose);
            assert!(count < 100 || hits > 500);
        }
    }
}

#[test]
fn agrees_with_every_surface_from_far_outside() {
    let mut random = Random(2);
    let scene = Scene::new(random_scene(&mut random, 60, DVec3::ZERO)).unwrap();
    let narrow = |half: f64| {
        let mut spec = spec(linear(half, -half, 40), 40);
        (spec.azimuth_start, spec.azimuth_span, spec.max_range) = (half, 2.0 * half, 1e8);
        pattern(spec)
    };
    for distance in [1e2, 1e4, 1e6] {
        // Obliquely, so that no coordinate of the sensor is a number that f32 holds.
        let rotation = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_y(0.4);
        let pose = Pose { rotation, translation: -distance * rotation.x_axis };
        let hits = agrees_with_every_surface(&scene, &narrow(20.0 / distance), &pose);
        assert!(hits > 200, "{hits} hits from {distance} m");
    }
}

#[test]
fn map_coordinates_are_as_precise_as_local_ones() {
    let mut random = Random(4);
    let place = DVec3::new(1_048_576.0, -2_097_152.0, 512.0);
    let here = random_scene(&mut random, 80, DVec3::ZERO);
    let there = |p: &Primitive| Primitive { center: (DVec3::from(p.center) + place).to_array(), ..p.clone() };
    let far = Scene::new(here.iter().map(there).collect()).unwrap();
    let pattern = pattern(spec(linear(0.5, -0.5, 32), 256));
    let near = scan(&Scene::new(here).unwrap(), &pattern, &at(0.537, 0.271, 0.019));
    let pose = Pose { translation: place + DVec3::new(0.537, 0.271, 0.019), ..Pose::IDENTITY };
    let moved = scan(&far, &pattern, &pose);
    let changed = near.primitive.iter().zip(&moved.primitive).filter(|(a, b)| a != b).count();
    assert!(changed <= 2, "{changed} pixels changed");
    let same = (0..near.depth.len()).filter(|&i| near.primitive[i] == moved.primitive[i]);
    let worst = same.map(|i| (near.depth[i] - moved.depth[i]).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5, "depth off by {worst}");
    agrees_with_every_surface(&far, &pattern, &pose);
}

#[test]
fn empty_scene() {
    let images = scan(&Scene::new(vec![]).unwrap(), &hdl64(), &Pose::IDENTITY);
    assert_eq!(images, Images::new(64, 1024));
    assert_eq!(images.primitive[0], -1);
}

#[test]
fn one_triangle() {
    let vertices = vec![[0.0, -0.5, -0.5], [0.0, 0.5, -0.5], [0.0, 0.0, 0.5]];
    let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2]]).unwrap();
    let wall = primitive(Shape::Mesh(mesh), [5.0, 0.0, 0.0], [0.0, 4.0, 4.0]);
    let pattern = pattern(spec(linear(0.4, -0.4, 21), 360));
    let scene = Scene::new(vec![wall]).unwrap();
    let images = scan(&scene, &pattern, &Pose::IDENTITY);
    let hits = images.depth.iter().filter(|&&depth| depth > 0.0).count();
    assert!(hits > 200 && hits < 600, "{hits} hits");
    let middle = images.get(10, 180).unwrap();
    assert!((f64::from(middle.depth) - 5.0 / (PI / 360.0).cos()).abs() < 1e-6);
    assert!((f64::from(middle.incidence) - (PI / 360.0).cos()).abs() < 1e-6);
    agrees_with_every_surface(&scene, &pattern, &Pose::IDENTITY);
}

#[test]
fn degenerate_scenes_are_cast() {
    let flat = TriangleMesh::new(vec![[0.1; 3]; 3], vec![[0, 1, 2]; 100]).unwrap();
    let twins = vec![primitive(Shape::Box, [5.0, 0.0, 0.0], [1.0; 3]); 500];
    let nested = |k: i32| primitive(Shape::Ellipsoid, [0.0; 3], [1.5_f64.powi(k); 3]);
    let extreme = vec![
        primitive(Shape::Box, [1e9; 3], [1e-300; 3]),
        primitive(Shape::Ellipsoid, [-1e9; 3], [1e9, 1e-300, 1.0]),
        primitive(Shape::Cylinder, [0.0; 3], [1e-300, 1e-300, 1e9]),
        primitive(Shape::Plane, [0.0, 0.0, -2.0], [1e9, 1e9, 0.0]),
    ];
    let geometric = (-40..40).map(nested).collect();
    let row = (0..3000).map(|k| primitive(Shape::Box, [f64::from(k), 0.0, 0.0], [0.5; 3])).collect();
    let mesh = vec![primitive(Shape::Mesh(flat), [1.0; 3], [1.0; 3])];
    for scene in [twins, extreme, geometric, row, mesh] {
        let pattern = pattern(spec(linear(0.3, -0.3, 8), 32));
        agrees_with_every_surface(&Scene::new(scene).unwrap(), &pattern, &at(0.1, 0.2, 0.3));
    }
}

#[test]
fn lower_index_wins_at_the_same_distance() {
    let ground = |label, size| Primitive { label, ..primitive(Shape::Plane, [0.3, 0.1, -1.7], [size, size, 0.0]) };
    let pattern = pattern(spec(linear(-0.2, -0.8, 16), 128));
    for sizes in [[200.0, 50.0], [50.0, 200.0]] {
        let scene = Scene::new(vec![ground(1, sizes[0]), ground(2, sizes[1])]).unwrap();
        let images = scan(&scene, &pattern, &Pose::IDENTITY);
        assert!(images.label.iter().all(|&label| label == 1));
    }
}

#[test]
fn range_limits_hide_what_is_beyond() {
    let wall = |x| primitive(Shape::Box, [x, 0.0, 0.0], [0.1, 9.0, 9.0]);
    let mut narrow = spec(vec![0.0], 8);
    (narrow.azimuth_start, narrow.azimuth_span) = (0.1, 0.2);
    (narrow.min_range, narrow.max_range) = (1.0, 20.0);
    let depth =
        |walls: Vec<Primitive>| scan(&Scene::new(walls).unwrap(), &pattern(narrow.clone()), &Pose::IDENTITY).depth[4];
    assert!(depth(vec![wall(10.0)]) > 9.9);
    assert_eq!(depth(vec![wall(25.0)]), 0.0);
    assert_eq!(depth(vec![wall(0.5), wall(10.0)]), 0.0);
}

#[test]
fn same_images_on_any_number_of_threads() {
    let mut random = Random(6);
    let scene = Scene::new(random_scene(&mut random, 150, DVec3::ZERO)).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scan(&scene, &hdl64(), &at(1.0, 2.0, 0.0)))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
    assert!(one.depth.iter().filter(|&&depth| depth > 0.0).count() > 10_000);
}

#[test]
fn turning_the_scene_by_a_column_rolls_the_images() {
    let columns = 360;
    let turn = 2.0 * PI / columns as f64;
    let cars = |yaw: f64| {
        let place = |k: i32| {
            let (sin, cos) = (f64::from(k) * 1.1 + yaw).sin_cos();
            let center = [cos * (8.0 + f64::from(k)), sin * (8.0 + f64::from(k)), 0.0];
            let car = primitive(Shape::Box, center, [4.0, 2.0, 1.5]);
            Primitive { yaw: f64::from(k) + yaw, label: k as u8 + 1, ..car }
        };
        Scene::new((0..6).map(place).collect()).unwrap()
    };
    let pattern = pattern(spec(linear(0.1, -0.1, 8), columns));
    let (still, turned) = (scan(&cars(0.0), &pattern, &Pose::IDENTITY), scan(&cars(turn), &pattern, &Pose::IDENTITY));
    for row in 0..8 {
        for column in 0..columns {
            let (a, b) = (still.get(row, (column + 1) % columns), turned.get(row, column));
            assert_eq!(a.map(|r| r.label), b.map(|r| r.label));
            let depths = (a.map_or(0.0, |r| r.depth), b.map_or(0.0, |r| r.depth));
            assert!((depths.0 - depths.1).abs() < 1e-4);
        }
    }
}

#[test]
fn straight_up_and_down() {
    let room = Scene::new(vec![primitive(Shape::Box, [0.0; 3], [10.0, 10.0, 6.0])]).unwrap();
    let steep = FRAC_PI_2.next_down();
    let images = scan(&room, &pattern(spec(vec![steep, -steep], 16)), &at(0.0, 0.0, 1.0));
    assert!(images.depth[..16].iter().all(|&depth| (depth - 2.0).abs() < 1e-6));
    assert!(images.depth[16..].iter().all(|&depth| (depth - 4.0).abs() < 1e-6));
    assert!(images.incidence.iter().all(|&cosine| (cosine - 1.0).abs() < 1e-6));
}

#[test]
fn beams_start_at_their_own_heights() {
    let ground = primitive(Shape::Plane, [0.0, 0.0, -2.0], [100.0, 100.0, 0.0]);
    let mut spec = spec(vec![-0.5, -0.6], 10);
    spec.origin_heights = vec![1.0, -1.0];
    let images = scan(&Scene::new(vec![ground]).unwrap(), &pattern(spec), &Pose::IDENTITY);
    assert!((f64::from(images.depth[0]) - 3.0 / 0.5_f64.sin()).abs() < 1e-5);
    assert!((f64::from(images.depth[10]) - 1.0 / 0.6_f64.sin()).abs() < 1e-5);
}
