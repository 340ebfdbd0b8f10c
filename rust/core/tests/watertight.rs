//! No ray slips between surfaces that meet.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::DVec3;

use super::{Random, box_mesh, grid, linear, pattern, primitive, scanned, spec};
use crate::{FreePathKey, Pose, Primitive, Scene, SensorPattern, Shape};

fn leaks(scene: &Scene, pattern: &SensorPattern, pose: &Pose) -> usize {
    let images = scanned(scene, pattern, pose);
    images.depth.iter().filter(|&&depth| depth == 0.0).count()
}

#[test]
fn rays_at_shared_edges_of_a_mesh() {
    let cells = 16;
    let bumps = |x: f64, y: f64| 0.02 * (9.0 * x).sin() * (7.0 * y).cos();
    for mesh in [grid(cells, |_, _| 0.0), grid(cells, bumps)] {
        let size = [10.0, 10.0, 10.0];
        let floor = Primitive { yaw: 0.3, ..primitive(Shape::Mesh(mesh.clone()), [3.0, 1.0, -2.0], size) };
        let place = |v: [f64; 3]| {
            let (sin, cos) = 0.3_f64.sin_cos();
            let [x, y, z] = v.map(|a| a * 10.0);
            DVec3::new(cos * x - sin * y + 3.0, sin * x + cos * y + 1.0, z - 2.0)
        };
        let scene = Scene::new(vec![floor]).unwrap();
        let inner = |v: u32| mesh.vertices()[v as usize][..2].iter().all(|a| a.abs() < 0.5);
        let faces: Vec<_> = mesh.faces().iter().filter(|f| f.iter().all(|&v| inner(v))).collect();
        let mut random = Random(11);
        for k in 0..50_000 {
            let face = faces[k % faces.len()];
            let corner = |i: usize| place(mesh.vertices()[face[i % 3] as usize]);
            let (a, b) = (corner(k / faces.len()), corner(k / faces.len() + 1));
            let along = [0.0, 0.5, random.between(0.0, 1.0)][k % 3];
            let origin = random.vector(-2.0, 2.0) + DVec3::new(3.0, 1.0, 3.0);
            let direction = (a + (b - a) * along - origin).normalize();
            assert!(
                scene.closest(origin, direction, FreePathKey::of_ray(0, 0)).is_some(),
                "ray {k} from {origin} leaks"
            );
        }
    }
}

/// A closed room with round numbers, of one box seen from inside, of twelve triangles, of six walls or of six slabs that
/// only touch at their edges.
fn rooms() -> Vec<Scene> {
    let inside = primitive(Shape::Box, [0.0; 3], [20.0, 20.0, 20.0]);
    let mesh = primitive(Shape::Mesh(box_mesh()), [0.0; 3], [20.0, 20.0, 20.0]);
    let wall = |axis: usize, sign: f64| {
        let (mut center, mut size) = ([0.0; 3], [20.0; 3]);
        (center[axis], size[axis]) = (sign * 10.5, 1.0);
        primitive(Shape::Box, center, size)
    };
    let walls = (0..6).map(|k| wall(k / 2, [-1.0, 1.0][k % 2])).collect();
    let plane = |z| primitive(Shape::Plane, [0.0, 0.0, z], [20.0, 20.0, 0.0]);
    let side = |axis| vec![wall(axis, -1.0), wall(axis, 1.0)];
    let lidded = [side(0), side(1), vec![plane(-10.0), plane(10.0)]].concat();
    [vec![inside], vec![mesh], walls, lidded].map(|room| Scene::new(room).unwrap()).into()
}

#[test]
fn axis_aligned_room() {
    // Beams and columns hit the edges of the room exactly: both end angles look along diagonals.
    let edge = (1.0_f64 / 2.0_f64.sqrt()).atan();
    let mut partial = spec(linear(FRAC_PI_4, -FRAC_PI_4, 65), 1024);
    partial.azimuth_span = 2.0 * PI * 1024.0 / 1025.0;
    let patterns = [spec(linear(FRAC_PI_4, -FRAC_PI_4, 64), 1024), spec(linear(edge, -edge, 64), 1020), partial];
    for spec in patterns {
        // Half a cell further, so that columns look along the axes and the diagonals.
        let cell = spec.azimuth_span / spec.columns as f64;
        let shifted = super::spec(spec.elevations.clone(), spec.columns);
        let shifted = crate::SensorSpec { azimuth_start: PI + cell / 2.0, ..shifted };
        for spec in [spec, shifted] {
            let pattern = pattern(spec);
            for (room, scene) in rooms().iter().enumerate() {
                for height in [0.0, 1.0, 2.5, -9.0] {
                    let pose = Pose { translation: DVec3::new(0.0, 0.0, height), ..Pose::IDENTITY };
                    assert_eq!(leaks(scene, &pattern, &pose), 0, "room {room}, height {height}");
                }
            }
        }
    }
}

#[test]
fn room_seen_from_anywhere() {
    let mut random = Random(5);
    for scene in rooms() {
        for _ in 0..40_000 {
            let origin = random.vector(-9.5, 9.5);
            assert!(scene.closest(origin, random.direction(), FreePathKey::of_ray(0, 0)).is_some());
            // Towards an edge: two coordinates on walls.
            let mut target = random.vector(-10.0, 10.0);
            (target.x, target.y) = (10.0, -10.0);
            assert!(scene.closest(origin, (target - origin).normalize(), FreePathKey::of_ray(0, 0)).is_some());
        }
    }
}
