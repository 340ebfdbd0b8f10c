//! Sensors inside bodies, on them, in the planes of their faces; sizes from 1 mm to 100 km.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec3};

use super::{Random, Tally, at, linear, pattern, primitive, random_scene, scene, shapes, solid, spec};
use crate::{Pose, Primitive, Scene, SensorPattern, Shape};

/// Beams along the horizon, the diagonals and the axis; columns along the axes.
fn all_around() -> SensorPattern {
    let mut spec = spec(vec![FRAC_PI_2.next_down(), 1.5, 0.785, 0.3, 1e-3, 0.0, -1e-5, -0.02, -0.785, -1.57], 40);
    spec.azimuth_start = PI + PI / 40.0;
    pattern(spec)
}

/// A few ways to be turned.
fn turns() -> [DMat3; 3] {
    let tilt = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(0.3);
    [DMat3::IDENTITY, DMat3::from_rotation_z(0.3), tilt]
}

#[test]
fn inside_and_on_the_surface() {
    let mut tally = Tally::default();
    let offsets = [0.0, 1e-30, 1e-12, 0.3, 0.99, 0.9999, 0.999_999_9, 1.0, 1.000_000_1, 1.000_01, 1.001, 1.1];
    for shape in shapes() {
        for size in [[2.0, 2.0, 2.0], [0.2, 30.0, 4.0], [200.0, 200.0, 8.0]] {
            let one = scene(vec![solid(&shape, [0.0; 3], size)]);
            for (side, axis) in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(-0.6, 0.8, 0.0)].into_iter().enumerate() {
                for offset in offsets {
                    for (turn, rotation) in turns().into_iter().enumerate() {
                        let translation = axis * offset * DVec3::from(size) / 2.0;
                        let name = format!("{shape:?} of {size:?}, {offset} along {side}, turn {turn}");
                        let name = name.chars().take(200).collect::<String>();
                        tally.compare(name, &one, &all_around(), &[Pose { rotation, translation }]);
                    }
                }
            }
        }
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
    tally.print("inside");
}

#[test]
fn in_the_planes_of_large_faces() {
    let mut tally = Tally::default();
    for shape in shapes() {
        for gap in [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1] {
            for sign in [-1.0, 1.0] {
                for (turn, rotation) in turns().into_iter().enumerate() {
                    let upright = scene(vec![solid(&shape, [0.0; 3], [200.0, 140.0, 30.0])]);
                    let place = Pose { rotation, translation: DVec3::new(3.1, 40.7, -1.3) };
                    let moved = upright.moved(&[0], &[place]).unwrap();
                    for axis in 0..3 {
                        // Beside a corner, in the plane of a face but for the gap.
                        let mut start = DVec3::new(117.3, -83.1, 15.7);
                        start[axis] = [100.0, 70.0, if shape == Shape::Plane { 0.0 } else { 15.0 }][axis] + sign * gap;
                        let name = format!("{shape:?}").chars().take(12).collect::<String>();
                        let name = format!("{name}, gap {gap} along {axis}, turn {turn}, side {sign}");
                        let narrow = looking(0.0, 0.4);
                        // Looking along the face.
                        let ahead = Pose { rotation: towards(-start), translation: start };
                        tally.compare(&name, &upright, &narrow, &[ahead]);
                        let there = Pose { rotation: rotation * ahead.rotation, translation: place.point(start) };
                        tally.compare(format!("{name}, moved"), &moved, &narrow, &[there]);
                    }
                }
            }
        }
    }
    tally.print("planes");
    assert!(tally.hits > 1000, "{tally:?}");
}

/// 33 beams and 40 columns around the x axis.
fn looking(elevation: f64, half: f64) -> SensorPattern {
    let mut spec = spec(linear(elevation + half, elevation - half, 33), 40);
    (spec.azimuth_start, spec.azimuth_span) = (half, 2.0 * half);
    pattern(spec)
}

/// A rotation that takes x to a direction.
fn towards(direction: DVec3) -> DMat3 {
    let x = direction.normalize();
    let y = DVec3::Z.cross(x).normalize();
    DMat3::from_cols(x, y, x.cross(y))
}

/// Beside one face of a long body, whose other end is far: what is left of the difference of two large numbers.
#[test]
fn at_the_near_edges_of_long_bodies() {
    let mut tally = Tally::default();
    for shape in [Shape::Box, Shape::Cylinder, Shape::Mesh(super::box_mesh())] {
        let tower = scene(vec![solid(&shape, [0.0; 3], [1.0, 1.0, 200.0])]);
        for gap in [0.01, 0.1, 0.477_668, 1.0, 3.3] {
            for side in [0.0, 1.0, 2.0, 3.0, 4.0] {
                let start = DVec3::new(0.158, 0.0, 100.0 + gap);
                // Across the edge of the top, closer and closer.
                let edge = DVec3::new(0.5 * f64::cos(side), 0.5 * f64::sin(side), 100.0);
                let edge = if shape == Shape::Cylinder { edge } else { DVec3::new(edge.x, 0.5, 100.0) };
                for half in [0.1, 1e-3, 3e-5] {
                    let pose = Pose { rotation: towards(edge - start), translation: start };
                    let name = format!("{half} around {edge} from {gap} above");
                    tally.compare(name, &tower, &looking(0.0, half), &[pose]);
                }
            }
        }
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

#[test]
fn along_a_row_of_boxes_in_their_edge_planes() {
    let mut tally = Tally::default();
    let row = |size: [f64; 3]| {
        let one = |k: i32| primitive(Shape::Box, [3.0 * f64::from(k) + 5.0, 1.0, 0.5], size);
        scene((0..50).map(one).collect())
    };
    for size in [[2.0, 2.0, 1.0], [3.0, 2.0, 1.0]] {
        let boxes = row(size);
        for y in [0.0, 1e-9, -1e-6, 1e-4, -1e-3, 2.0] {
            for z in [0.0, 1.0, 0.5, -1e-9, 1.0 + 1e-5] {
                tally.compare(format!("{size:?} from {y}, {z}"), &boxes, &all_around(), &[at(0.0, y, z)]);
                tally.compare(format!("{size:?} from {y}, {z}"), &boxes, &looking(0.0, 1e-3), &[at(0.0, y, z)]);
            }
        }
    }
    let boxes = (0..3000).map(|k| primitive(Shape::Box, [f64::from(k), 0.0, 0.0], [0.5; 3])).collect();
    let boxes = scene(boxes);
    for pose in [at(-1.0, 0.25, 0.0), at(-1.0, 0.1, 0.4), at(1000.5, 0.0, 0.0), at(700.3, 2.0, 1.0)] {
        tally.compare("3000 boxes", &boxes, &all_around(), &[pose]);
        tally.compare("3000 boxes", &boxes, &looking(0.0, 0.01), &[pose]);
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

#[test]
fn nested_spheres() {
    let mut tally = Tally::default();
    let spheres = |range: std::ops::Range<i32>| {
        scene(range.map(|k| solid(&Shape::Ellipsoid, [0.0; 3], [1.5_f64.powi(k); 3])).collect())
    };
    for spheres in [spheres(-40..40), spheres(0..20), spheres(0..1)] {
        for pose in [Pose::IDENTITY, at(0.1, 0.2, 0.3), at(1e-3, 0.0, 0.0), at(0.0, 0.0, 0.5), at(1e3, 0.0, 1.0)] {
            tally.compare(format!("from {}", pose.translation), &spheres, &all_around(), &[pose]);
        }
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

/// Bodies of any size, each seen at about its own size.
#[test]
fn extreme_sizes() {
    let mut tally = Tally::default();
    for seed in 0..60 {
        let mut random = Random(600 + seed);
        let one = |random: &mut Random, k: usize| {
            let scale = random.magnitude(1e-3, 1e5);
            let size = [(); 3].map(|()| (scale * random.magnitude(0.01, 3.0)).clamp(1e-3, 1e5));
            let center = random.direction() * scale * random.magnitude(0.3, 3.0);
            Primitive { yaw: random.between(-4.0, 4.0), ..solid(&shapes()[k % 5], center.to_array(), size) }
        };
        let bodies = scene((0..12).map(|k| one(&mut random, k)).collect());
        let pose = random.pose(random_reach(seed));
        tally.compare(format!("seed {seed}"), &bodies, &all_around(), &[pose]);
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

fn random_reach(seed: u64) -> f64 {
    [0.0, 1e-3, 1.0, 1e3][seed as usize % 4]
}

/// Flat as paper, thin as a hair.
#[test]
fn hardly_there() {
    let mut tally = Tally::default();
    for thin in [1e-3, 1e-6, 1e-9, 1e-12, 1e-20, 1e-30, 1e-45, 1e-300] {
        for shape in shapes() {
            for size in [[4.0, 4.0, thin], [thin, 4.0, 4.0], [thin, thin, 4.0], [4.0, thin, thin], [thin; 3]] {
                for center in [[5.0, 0.0, 0.0], [3.0, 0.5, -1.0], [0.0, 0.0, -2.0]] {
                    let one = scene(vec![solid(&shape, center, size)]);
                    let name = format!("{shape:?}").chars().take(12).collect::<String>();
                    tally.compare(format!("{name} of {size:?} at {center:?}"), &one, &all_around(), &[Pose::IDENTITY]);
                }
            }
        }
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

/// Scenes in map coordinates, upright and tilted.
#[test]
fn map_coordinates() {
    let mut tally = Tally::default();
    let mut random = Random(31);
    for place in [DVec3::new(1e6, -1e6, 500.0), DVec3::new(1_048_576.0, 1_048_576.0, 0.0), DVec3::splat(1e8)] {
        let primitives = random_scene(&mut random, 80, place);
        let upright = scene(primitives);
        let moved: Vec<u32> = (0..80).step_by(2).collect();
        let poses: Vec<Pose> = moved.iter().map(|_| random.pose(20.0)).collect();
        let poses: Vec<Pose> = poses.iter().map(|p| Pose { translation: p.translation + place, ..*p }).collect();
        let tilted: Scene = upright.moved(&moved, &poses).unwrap();
        for _ in 0..6 {
            let pose = random.pose(9.0);
            let pose = Pose { translation: pose.translation + place, ..pose };
            tally.compare(format!("upright at {place}"), &upright, &all_around(), &[pose]);
            tally.compare(format!("tilted at {place}"), &tilted, &all_around(), &[pose]);
        }
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}
