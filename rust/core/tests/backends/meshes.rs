//! Meshes: rays through shared corners, huge triangles, slivers, triangles that lie on each other.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec3};

use super::{Random, Tally, at, box_mesh, grid, linear, pattern, primitive, scene, spec};
use crate::{Pose, Primitive, SensorPattern, Shape, TriangleMesh};

fn wide() -> SensorPattern {
    pattern(spec(linear(1.5, -1.5, 31), 72))
}

/// A mesh whose corners lie on the rays of a pattern, at distances that a function gives.
fn on_the_rays(pattern: &SensorPattern, distance: impl Fn(usize) -> f64) -> TriangleMesh {
    let (rows, columns) = (pattern.rows(), pattern.columns());
    let corner = |i: usize| (pattern.direction(i / columns, i % columns) * distance(i)).to_array();
    let index = |row: usize, column: usize| (row * columns + column % columns) as u32;
    let quads = (0..rows - 1).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let faces = quads.flat_map(|(h, w)| {
        let (a, b, c, d) = (index(h, w), index(h, w + 1), index(h + 1, w), index(h + 1, w + 1));
        [[a, b, d], [a, d, c]]
    });
    TriangleMesh::new((0..rows * columns).map(corner).collect(), faces.collect()).unwrap()
}

#[test]
fn rays_through_shared_corners() {
    let mut tally = Tally::default();
    for columns in [16, 45] {
        let pattern = pattern(spec(linear(1.3, -1.3, 17), columns));
        let smooth = on_the_rays(&pattern, |_| 5.0);
        let rough = on_the_rays(&pattern, |i| 5.0 + (i as f64 * 12.9898).sin());
        let deep = on_the_rays(&pattern, |i| [1.0, 100.0, 7.0][i % 3]);
        for mesh in [smooth, rough, deep] {
            let shell = primitive(Shape::Mesh(mesh), [0.0; 3], [1.0; 3]);
            let still = scene(vec![shell.clone()]);
            tally.compare(format!("{columns} columns"), &still, &pattern, &[Pose::IDENTITY]);
            // And with a part of it as a body of its own.
            let turn = Primitive { yaw: 2.0 * PI / columns as f64, label: 2, ..shell.clone() };
            let twice = scene(vec![turn, shell]);
            tally.compare(format!("{columns} columns, twice"), &twice, &pattern, &[Pose::IDENTITY]);
        }
    }
    assert!(tally.hits > tally.rays * 9 / 10, "{tally:?}");
}

/// Of a span that is no whole number of columns in a turn: what lies behind the seam lies between other columns.
#[test]
fn small_triangles_all_around_a_part_of_a_turn() {
    let mut tally = Tally::default();
    let shell = pattern(spec(linear(1.3, -1.3, 17), 90));
    let mesh = on_the_rays(&shell, |i| 5.0 + (i as f64 * 12.9898).sin());
    let shell = scene(vec![primitive(Shape::Mesh(mesh), [0.0; 3], [1.0; 3])]);
    for span in [6.2, 3.0, 2.0 * PI - 0.01, 1.0] {
        for columns in [33, 7, 100] {
            for start in [PI, 0.0, -2.0, 20.0] {
                let mut spec = spec(linear(1.2, -1.2, 9), columns);
                (spec.azimuth_start, spec.azimuth_span) = (start, span);
                let name = format!("{columns} columns over {span} from {start}");
                tally.compare(name, &shell, &pattern(spec), &[Pose::IDENTITY]);
            }
        }
    }
    assert_eq!(tally.hits, tally.rays, "{tally:?}");
}

#[test]
fn huge_triangles_underfoot() {
    let mut tally = Tally::default();
    for size in [1e2, 1e4, 1e6] {
        for below in [1e-6, 1e-3, 0.1, 1.8] {
            for (k, mesh) in
                [grid(1, |_, _| 0.0), grid(3, |_, _| 0.0), grid(2, |x, y| 0.01 * x * y)].into_iter().enumerate()
            {
                let ground = primitive(Shape::Mesh(mesh), [0.3, -0.2, -below], [size; 3]);
                let plane = primitive(Shape::Plane, [0.0, 0.0, -below], [size, size, 0.0]);
                let slab = primitive(Shape::Box, [0.0, 0.0, -below - 1.0], [size, size, 2.0]);
                for (other, ground) in [ground, plane, slab].into_iter().enumerate() {
                    let scene = scene(vec![ground]);
                    let tilt = Pose { rotation: DMat3::from_rotation_y(0.01), ..Pose::IDENTITY };
                    for pose in [Pose::IDENTITY, at(size / 6.0, size / 6.0, 0.0), tilt] {
                        let name =
                            format!("{size} m, {below} m below, mesh {k}, kind {other}, from {}", pose.translation);
                        tally.compare(name, &scene, &wide(), &[pose]);
                    }
                }
            }
        }
    }
    assert!(tally.hits > tally.rays / 3, "{tally:?}");
}

#[test]
fn slivers_and_triangles_without_area() {
    let mut tally = Tally::default();
    let mut random = Random(51);
    for round in 0..60 {
        let width = random.pick(&[1e-6, 1e-9, 1e-3]);
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for _ in 0..40 {
            let (a, b) = (random.vector(-0.5, 0.5), random.vector(-0.5, 0.5));
            let first = vertices.len() as u32;
            let third = [a + random.direction() * width, (a + b) / 2.0, a][random.between(0.0, 3.0) as usize];
            vertices.extend([a, b, third].map(|v| v.to_array()));
            faces.push([first, first + 1, first + 2]);
        }
        // A fan of slivers around one corner.
        let first = vertices.len() as u32;
        vertices.push([0.0; 3]);
        vertices.extend((0..100).map(|k| [0.5, (f64::from(k) - 50.0) * width, 0.3]));
        faces.extend((1..100).map(|k| [first, first + k, first + k + 1]));
        let mesh = primitive(Shape::Mesh(TriangleMesh::new(vertices, faces).unwrap()), [3.0, 0.0, 0.0], [10.0; 3]);
        let scene = scene(vec![mesh]);
        tally.compare(format!("round {round}"), &scene, &wide(), &[random.pose(3.0)]);
        // Straight at the fan.
        let mut narrow = spec(linear(0.01, -0.01, 21), 21);
        (narrow.azimuth_start, narrow.azimuth_span) = (1e-2, 2e-2);
        tally.compare(format!("round {round}, narrow"), &scene, &pattern(narrow), &[at(-10.0, 0.0, 1.5)]);
    }
    assert!(tally.hits > 100, "{tally:?}");
}

#[test]
fn the_lower_index_wins_in_every_order() {
    let mut tally = Tally::default();
    let coplanar = |shape: Shape, size: [f64; 3]| {
        let one =
            |k: u8| Primitive { label: k, instance: u32::from(k), ..primitive(shape.clone(), [1.0, 2.0, -1.5], size) };
        (1..20).map(one).collect::<Vec<_>>()
    };
    let stacked =
        |k: u8| Primitive { label: k + 1, ..primitive(Shape::Box, [5.0, 0.0, f64::from(k)], [2.0, 2.0, 1.0]) };
    let wall = |k: u8| {
        let size = [1.0, 4.0 - f64::from(k), 3.0];
        Primitive { label: k + 1, ..primitive(Shape::Box, [5.0, 0.0, 0.0], size) }
    };
    let scenes = [
        coplanar(Shape::Plane, [30.0, 30.0, 0.0]),
        coplanar(Shape::Box, [30.0, 30.0, 1.0]),
        coplanar(Shape::Mesh(box_mesh()), [30.0, 30.0, 1.0]),
        coplanar(Shape::Mesh(grid(5, |x, y| x * y)), [30.0, 30.0, 1.0]),
        coplanar(Shape::Ellipsoid, [3.0, 3.0, 1.0]),
        coplanar(Shape::Cylinder, [3.0, 3.0, 1.0]),
        (0..4).map(stacked).collect(),
        (0..4).map(wall).collect(),
        (0..4).rev().map(wall).collect(),
    ];
    for (k, primitives) in scenes.into_iter().enumerate() {
        let mut mixed = primitives.clone();
        mixed.push(Primitive { label: 99, ..primitive(Shape::Plane, [1.0, 2.0, -1.0], [30.0, 30.0, 0.0]) });
        for scene in [scene(primitives), scene(mixed)] {
            for pose in [Pose::IDENTITY, at(-3.0, 0.5, 0.3), at(5.0, 3.0, -0.1)] {
                tally.compare(format!("scene {k} from {}", pose.translation), &scene, &wide(), &[pose]);
            }
        }
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

#[test]
fn one_triangle_and_none() {
    let mut tally = Tally::default();
    tally.compare("empty", &scene(vec![]), &wide(), &[Pose::IDENTITY]);
    assert_eq!(tally.hits, 0);
    let mut random = Random(52);
    for round in 0..200 {
        let reach = random.pick(&[0.5, 10.0, 1e3]);
        let corners = [(); 3].map(|()| random.vector(-reach, reach).to_array());
        let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let center = random.vector(-5.0, 5.0).to_array();
        let scene = scene(vec![primitive(Shape::Mesh(mesh), center, [1.0; 3])]);
        tally.compare(format!("round {round}"), &scene, &wide(), &[random.pose(3.0)]);
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

/// One body around everything, in steps of more triangles than a block or a group holds.
#[test]
fn blocks_and_groups_that_are_not_full() {
    let mut tally = Tally::default();
    let mut random = Random(53);
    for count in [1, 2, 7, 8, 9, 15, 16, 17, 255, 256, 257, 300, 1000] {
        let near = |random: &mut Random| {
            let middle = random.vector(-0.5, 0.5);
            [(); 3].map(|()| middle + random.vector(-0.1, 0.1))
        };
        let vertices: Vec<DVec3> = (0..count).flat_map(|_| near(&mut random)).collect();
        let faces = (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = TriangleMesh::new(vertices.iter().map(|v| v.to_array()).collect(), faces).unwrap();
        let soup = primitive(Shape::Mesh(mesh), [0.0; 3], [20.0; 3]);
        let scene = scene(vec![soup]);
        for _ in 0..3 {
            tally.compare(format!("{count} triangles"), &scene, &wide(), &[random.pose(10.0)]);
        }
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

#[test]
fn straight_up_and_down() {
    let mut tally = Tally::default();
    let steep = FRAC_PI_2.next_down();
    let spec = spec(vec![steep, steep - 1e-9, 1.57, 1.5, 0.0, -1.0, 1e-3 - FRAC_PI_2, -1.5706, -steep], 24);
    let pattern = pattern(spec);
    let mut random = Random(54);
    for round in 0..40 {
        let bodies = super::random::bodies(&mut random, 60);
        tally.compare(format!("round {round}"), &bodies, &pattern, &[random.pose(20.0)]);
        tally.compare(format!("round {round}, level"), &bodies, &pattern, &[at(0.1, 0.2, 0.3)]);
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

/// Faces that look away are left out where a mesh is proven to hide them: not for a sensor within it, nor one that drives
/// through its wall, nor of a mesh that is inside out.
#[test]
fn closed_meshes_from_outside_and_within() {
    let (mut tally, mut random) = (Tally::default(), Random(31));
    let whole = box_mesh();
    let turned = whole.faces().iter().map(|&[a, b, c]| [c, b, a]).collect();
    let turned = TriangleMesh::new(whole.vertices().to_vec(), turned).unwrap();
    let pattern = pattern(spec(linear(1.2, -1.2, 25), 70));
    for round in 0..30 {
        let body = |mesh: &TriangleMesh, x: f64, random: &mut Random| Primitive {
            yaw: random.between(-4.0, 4.0),
            instance: x as u32,
            ..primitive(Shape::Mesh(mesh.clone()), [x, 0.5, 0.0], random.vector(0.5, 4.0).to_array())
        };
        let bodies = [(&whole, 0.0), (&turned, 4.0), (&whole, 9.0)];
        let bodies = scene(bodies.map(|(mesh, x)| body(mesh, x, &mut random)).to_vec());
        let pose = Pose { rotation: random.rotation(), translation: random.vector(-0.3, 0.3) };
        for x in [0.0, 0.25, 2.0, 4.0, 6.5] {
            let pose = Pose { translation: pose.translation + DVec3::X * x, ..pose };
            tally.compare(format!("round {round}, {x}"), &bodies, &pattern, &[pose]);
            let drive: Vec<Pose> = (0..70)
                .map(|k| Pose { translation: pose.translation + DVec3::Y * 0.05 * f64::from(k), ..pose })
                .collect();
            tally.compare(format!("round {round}, {x}, driving"), &bodies, &pattern, &drive);
        }
    }
    assert!(tally.hits > tally.rays / 10, "{tally:?}");
}
