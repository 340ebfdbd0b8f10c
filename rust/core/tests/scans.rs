//! Whole scans: against every surface asked in turn, in degenerate scenes, far from 0, on any number of threads.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec3};

use super::{Random, box_mesh, linear, pattern, primitive, random_scene, scanned, spec, swept};
use crate::medium::ScanKey;
use crate::{
    Backend, FreePathKey, Images, ImagesMut, Pose, Primitive, Scene, SensorPattern, Shape, TriangleMesh, scan,
    scan_batch,
};

fn hdl64() -> SensorPattern {
    pattern(spec(linear(3_f64.to_radians(), -25_f64.to_radians(), 64), 1024))
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose { translation: DVec3::new(x, y, z), ..Pose::IDENTITY }
}

/// Every pixel is that of the closest of all surfaces, with the normal there.
fn agrees_with_every_surface(scene: &Scene, pattern: &SensorPattern, pose: &Pose) -> usize {
    let images = scanned(scene, pattern, pose);
    let media = ScanKey::new(0, pattern.spec().column_width(), pose.translation - scene.origin());
    let mut hits = 0;
    for row in 0..pattern.rows() {
        for column in 0..pattern.columns() {
            let origin = pose.point(pattern.origin(row, column));
            let direction = pose.vector(pattern.direction(row, column));
            let all = scene.closest_of_all(
                origin,
                direction,
                FreePathKey { scan: media, row: pattern.spec().row_key(row), column },
            );
            let all = all.filter(|hit| pattern.reported(hit.distance).is_some());
            let i = row * pattern.columns() + column;
            let seen = (images.depth[i], images.primitive[i], images.label[i], images.instance[i]);
            let expected = all.map(|s| (s.distance as f32, s.primitive as i32, s.label, s.instance));
            assert_eq!(seen, expected.unwrap_or((0.0, -1, 0, 0)), "row {row}, column {column}");
            let normal = all.map(|s| scene.normal(s.primitive, s.part, origin + direction * s.distance));
            let cosine = -normal.unwrap_or_default().dot(direction) / direction.length();
            assert_eq!(images.incidence[i], cosine.abs().min(1.0) as f32);
            let towards = normal.unwrap_or_default() * if cosine < 0.0 { -1.0 } else { 1.0 };
            assert_eq!(images.normal[i], towards.as_vec3().to_array());
            hits += usize::from(all.is_some());
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
    let near = scanned(&Scene::new(here).unwrap(), &pattern, &at(0.537, 0.271, 0.019));
    let pose = Pose { translation: place + DVec3::new(0.537, 0.271, 0.019), ..Pose::IDENTITY };
    let moved = scanned(&far, &pattern, &pose);
    let changed = near.primitive.iter().zip(&moved.primitive).filter(|(a, b)| a != b).count();
    assert!(changed <= 2, "{changed} pixels changed");
    let same = (0..near.depth.len()).filter(|&i| near.primitive[i] == moved.primitive[i]);
    let worst = same.map(|i| (near.depth[i] - moved.depth[i]).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5, "depth off by {worst}");
    agrees_with_every_surface(&far, &pattern, &pose);
}

#[test]
fn empty_scene() {
    let images = scanned(&Scene::new(vec![]).unwrap(), &hdl64(), &Pose::IDENTITY);
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
    let images = scanned(&scene, &pattern, &Pose::IDENTITY);
    let hits = images.depth.iter().filter(|&&depth| depth > 0.0).count();
    assert!(hits > 200 && hits < 600, "{hits} hits");
    let middle = 10 * 360 + 180;
    assert!((f64::from(images.depth[middle]) - 5.0 / (PI / 360.0).cos()).abs() < 1e-6);
    assert!((f64::from(images.incidence[middle]) - (PI / 360.0).cos()).abs() < 1e-6);
    assert_eq!(images.normal[middle], [-1.0, 0.0, 0.0]);
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
        let images = scanned(&scene, &pattern, &Pose::IDENTITY);
        assert!(images.label.iter().all(|&label| label == 1));
    }
}

#[test]
fn lower_triangle_wins_at_the_same_distance() {
    let corners = vec![[0.0, -0.5, -0.5], [0.0, 0.5, -0.5], [0.0, 0.0, 0.5]];
    // The same triangle, begun at each of its corners, from both sides, after one that is passed by.
    let faces = vec![[0, 0, 1], [2, 0, 1], [1, 0, 2], [0, 1, 2], [1, 2, 0]];
    let wall = primitive(Shape::Mesh(TriangleMesh::new(corners, faces).unwrap()), [5.0, 0.0, 0.0], [0.0, 4.0, 4.0]);
    let scene = Scene::new(vec![wall.clone(), wall]).unwrap();
    let mut random = Random(14);
    for _ in 0..1000 {
        let aim = DVec3::new(5.0, random.between(-0.5, 0.5), random.between(-1.0, 0.5));
        let hit = scene.closest(DVec3::ZERO, aim, FreePathKey::of_ray(0, 0)).unwrap();
        assert_eq!((hit.primitive, hit.part), (0, 1));
    }
}

#[test]
fn a_mesh_in_map_coordinates_around_a_middle_of_0() {
    let place = [1_048_576.0, -2_097_152.0, 512.0];
    let mesh = box_mesh();
    let vertices = mesh.vertices().iter().map(|v| std::array::from_fn(|k| v[k] * 10.0 + place[k])).collect();
    let mesh = TriangleMesh::new(vertices, mesh.faces().to_vec()).unwrap();
    let room = Scene::new(vec![primitive(Shape::Mesh(mesh), [0.0; 3], [1.0; 3])]).unwrap();
    let pose = Pose { translation: DVec3::from(place) + DVec3::new(0.5, -1.25, 2.0), ..Pose::IDENTITY };
    let hits = agrees_with_every_surface(&room, &pattern(spec(linear(1.4, -1.4, 24), 96)), &pose);
    assert_eq!(hits, 24 * 96);
}

#[test]
fn range_limits_hide_what_is_beyond() {
    let wall = |x| primitive(Shape::Box, [x, 0.0, 0.0], [0.1, 9.0, 9.0]);
    let mut narrow = spec(vec![0.0], 8);
    (narrow.azimuth_start, narrow.azimuth_span) = (0.1, 0.2);
    (narrow.min_range, narrow.max_range) = (1.0, 20.0);
    let depth = |walls: Vec<Primitive>| {
        scanned(&Scene::new(walls).unwrap(), &pattern(narrow.clone()), &Pose::IDENTITY).depth[4]
    };
    assert!(depth(vec![wall(10.0)]) > 9.9);
    assert_eq!(depth(vec![wall(25.0)]), 0.0);
    assert_eq!(depth(vec![wall(0.5), wall(10.0)]), 0.0);
}

#[test]
fn same_images_on_any_number_of_threads() {
    let mut random = Random(6);
    let scene = Scene::new(random_scene(&mut random, 150, DVec3::ZERO)).unwrap();
    let pattern = hdl64();
    let poses: Vec<Pose> = (0..1024).map(|k| at(1.0 + f64::from(k) / 1024.0, 2.0, 0.0)).collect();
    for poses in [&poses[..1], &poses] {
        let one = swept(&scene, &pattern, poses, 1);
        assert!(one.depth.iter().filter(|&&depth| depth > 0.0).count() > 10_000);
        for threads in [0, 2, 3, 7] {
            assert_eq!(one, swept(&scene, &pattern, poses, threads), "{threads} threads");
        }
    }
}

#[test]
fn a_batch_is_its_scans() {
    let mut random = Random(8);
    let scene = Scene::new(random_scene(&mut random, 60, DVec3::ZERO)).unwrap();
    let pattern = pattern(spec(linear(0.3, -0.3, 8), 64));
    let poses: Vec<Pose> = (0..5 * 64).map(|_| random.pose(9.0)).collect();
    for columns in [1, 64] {
        let poses: Vec<&[Pose]> = poses.chunks(64).map(|sweep| &sweep[..columns]).collect();
        let singly: Vec<Images> = poses.iter().map(|sweep| swept(&scene, &pattern, sweep, 1)).collect();
        for (scans, threads) in [(0, 2), (1, 3), (5, 1), (5, 2), (5, 0), (5, 7)] {
            let mut images = Images::new(5 * 8, 64);
            let mut all = images.as_mut();
            let mut pieces = all.pieces(8 * 64);
            scan_batch(&scene, &pattern, &poses[..scans], 0, &mut pieces[..scans], Some(Backend::Reference), threads)
                .unwrap();
            for (k, scan) in singly.iter().enumerate() {
                let pixels = k * 8 * 64..(k + 1) * 8 * 64;
                let blank = Images::new(8, 64);
                let expected = if k < scans { scan } else { &blank };
                assert_eq!(images.depth[pixels.clone()], expected.depth);
                assert_eq!(images.primitive[pixels.clone()], expected.primitive);
                assert_eq!(images.normal[pixels], expected.normal);
            }
        }
    }
}

#[test]
fn images_that_are_not_wanted_change_nothing_in_the_others() {
    let mut random = Random(12);
    let scene = Scene::new(random_scene(&mut random, 60, DVec3::ZERO)).unwrap();
    let pattern = pattern(spec(linear(0.3, -0.3, 8), 64));
    let all = scanned(&scene, &pattern, &Pose::IDENTITY);
    let mut some = Images { depth: vec![f32::NAN; 8 * 64], label: vec![9; 8 * 64], ..Images::new(8, 64) };
    let mut wanted = ImagesMut { primitive: None, incidence: None, normal: None, ..some.as_mut() };
    scan(&scene, &pattern, &[Pose::IDENTITY], 0, &mut wanted, Some(Backend::Reference), 1).unwrap();
    assert_eq!((&some.depth, &some.label, &some.instance), (&all.depth, &all.label, &all.instance));
    assert!(some.primitive.iter().all(|&index| index == -1) && all.primitive.iter().any(|&index| index > 0));
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
    let (still, turned) =
        (scanned(&cars(0.0), &pattern, &Pose::IDENTITY), scanned(&cars(turn), &pattern, &Pose::IDENTITY));
    for row in 0..8 {
        for column in 0..columns {
            let (a, b) = (row * columns + (column + 1) % columns, row * columns + column);
            assert_eq!(still.label[a], turned.label[b]);
            assert!((still.depth[a] - turned.depth[b]).abs() < 1e-4);
        }
    }
}

#[test]
fn straight_up_and_down() {
    let room = Scene::new(vec![primitive(Shape::Box, [0.0; 3], [10.0, 10.0, 6.0])]).unwrap();
    let steep = FRAC_PI_2.next_down();
    let images = scanned(&room, &pattern(spec(vec![steep, -steep], 16)), &at(0.0, 0.0, 1.0));
    assert!(images.depth[..16].iter().all(|&depth| (depth - 2.0).abs() < 1e-6));
    assert!(images.depth[16..].iter().all(|&depth| (depth - 4.0).abs() < 1e-6));
    assert!(images.incidence.iter().all(|&cosine| (cosine - 1.0).abs() < 1e-6));
}
