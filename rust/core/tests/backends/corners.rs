//! Patterns and poses at the limits of what is allowed.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use super::random::bodies;
use super::{Random, Tally, at, linear, pattern, primitive, scene, shapes, solid, spec};
use crate::{Pose, Primitive, Shape};

#[test]
fn across_the_seam() {
    let mut tally = Tally::default();
    let behind = |k: u32| {
        let shape = &shapes()[k as usize % 5];
        let center = [-4.0 - f64::from(k), 0.1 * f64::from(k) - 0.5, 0.0];
        Primitive { label: k as u8 + 1, ..solid(shape, center, [1.0, 1.0 + f64::from(k), 1.0]) }
    };
    let bodies = scene((0..10).map(behind).collect());
    for start in [PI, -PI, 0.0, 3.0 * PI, 3.0, -3.1, 100.0, -1e3] {
        for span in [TAU, 6.0, PI, 1.0, 0.1, TAU - 1e-12] {
            for columns in [64, 33, 1000] {
                let mut spec = spec(linear(0.2, -0.2, 3), columns);
                (spec.azimuth_start, spec.azimuth_span) = (start, span);
                for yaw in [0.0, PI, 3.0] {
                    let pose = Pose { rotation: DMat3::from_rotation_z(yaw), ..Pose::IDENTITY };
                    let name = format!("from {start} over {span}, {columns} columns, yaw {yaw}");
                    tally.compare(name, &bodies, &pattern(spec.clone()), &[pose]);
                }
            }
        }
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

/// Any number is an angle.
#[test]
fn angles_of_many_turns() {
    let mut tally = Tally::default();
    let bodies = bodies(&mut Random(71), 60);
    for turns in [1e2, -1e3, 1e5, 1e7, -1e9] {
        let mut spec = spec(linear(0.3, -0.3, 5), 200);
        spec.azimuth_start = turns;
        tally.compare(format!("start at {turns}"), &bodies, &pattern(spec.clone()), &[Pose::IDENTITY]);
        spec.azimuth_start = 1.0;
        spec.azimuth_offsets = vec![0.0, turns, -turns, 0.1, turns];
        tally.compare(format!("offset by {turns}"), &bodies, &pattern(spec), &[Pose::IDENTITY]);
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

#[test]
fn many_rows_and_many_columns() {
    let mut tally = Tally::default();
    let mut random = Random(72);
    let bodies = bodies(&mut random, 60);
    let mut uneven: Vec<f64> = (0..300).map(|_| random.between(-1.0, 1.0).powi(7)).collect();
    uneven.sort_by(|a, b| b.total_cmp(a));
    let mut beside = spec(linear(1e-4, -1e-4, 40), 50);
    (beside.azimuth_start, beside.azimuth_span) = (1e-4, 2e-4);
    let patterns = [
        spec(vec![0.0], 100_000),
        spec(vec![1.5], 20_000),
        spec(vec![1e-9, 0.0, -1e-9], 1000),
        spec(linear(1.5, -1.5, 2000), 10),
        spec(uneven, 40),
        beside,
    ];
    for (k, spec) in patterns.into_iter().enumerate() {
        let pattern = pattern(spec);
        for _ in 0..4 {
            tally.compare(format!("pattern {k}"), &bodies, &pattern, &[random.pose(20.0)]);
        }
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

/// Surfaces at the range limits, and a rounding to either side of them.
#[test]
fn at_the_range_limits() {
    let mut tally = Tally::default();
    for limit in [20.0, 120.0, 0.1] {
        for off in [0.0, 1e-9, -1e-9, 1e-6, -1e-6, 1e-4, -1e-4, 1e-3, -2e-3, 1e-2, 0.5] {
            let distance: f64 = limit * (1.0 + off);
            let sphere = solid(&Shape::Ellipsoid, [0.0; 3], [2.0 * distance; 3]);
            let room = solid(&Shape::Box, [0.0; 3], [2.0 * distance; 3]);
            let wall = solid(&Shape::Box, [distance + 1.0, 0.0, 0.0], [2.0, 9.0, 9.0]);
            let ground = primitive(Shape::Plane, [0.0, 0.0, -distance / 2.0], [1e3, 1e3, 0.0]);
            for (k, body) in [sphere, room, wall, ground].into_iter().enumerate() {
                let mut spec = spec(linear(1.5, -1.5, 9), 64);
                spec.azimuth_start = PI + PI / 64.0;
                let bodies = scene(vec![body]);
                (spec.min_range, spec.max_range) = (0.0, limit);
                tally.compare(
                    format!("body {k} {off} beyond {limit}"),
                    &bodies,
                    &pattern(spec.clone()),
                    &[Pose::IDENTITY],
                );
                (spec.min_range, spec.max_range) = (limit, 2.0 * limit);
                let name = format!("body {k} {off} before {limit}");
                tally.compare(name, &bodies, &pattern(spec), &[at(1e-3, 0.0, 0.0)]);
            }
        }
    }
    let mut random = Random(73);
    for round in 0..20 {
        let bodies = bodies(&mut random, 100);
        let mut spec = spec(linear(0.4, -0.4, 12), 90);
        (spec.min_range, spec.max_range) = (random.between(0.0, 9.0), random.between(10.0, 40.0));
        tally.compare(format!("round {round}"), &bodies, &pattern(spec), &[random.pose(30.0)]);
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

/// Rotations as float32 texts hold them, which are not quite rigid.
#[test]
fn poses_from_texts() {
    let mut tally = Tally::default();
    let mut random = Random(74);
    let pattern = pattern(spec(linear(0.4, -0.4, 12), 120));
    for round in 0..80 {
        let bodies = bodies(&mut random, 60);
        let pose = random.pose(20.0);
        let off = [0.0, 4e-7][round % 2];
        let rows = [0, 1, 2].map(|k| {
            let axis = pose.rotation.row(k).as_vec3().as_dvec3() * (1.0 + off);
            [axis.x, axis.y, axis.z, pose.translation[k]]
        });
        let read = Pose::from_rows([rows[0], rows[1], rows[2], [0.0, 0.0, 0.0, 1.0]]).unwrap();
        tally.compare(format!("round {round}"), &bodies, &pattern, &[read]);
        tally.compare(format!("round {round}, rolling"), &bodies, &pattern, &[read; 120]);
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
    tally.print("texts");
}

/// Beams that start far from the sensor.
#[test]
fn long_arms() {
    let mut tally = Tally::default();
    let mut random = Random(75);
    for round in 0..40 {
        let bodies = bodies(&mut random, 60);
        let mut spec = spec(linear(0.8, -0.8, 8), 60);
        let reach = random.pick(&[1e-9, 1e-3, 1.0, 10.0, 100.0]);
        spec.origins = (0..8).map(|_| (random.vector(-1.0, 1.0) * reach).to_array()).collect();
        tally.compare(format!("round {round}, arms of {reach}"), &bodies, &pattern(spec), &[random.pose(20.0)]);
    }
    assert!(tally.hits > tally.rays / 5, "{tally:?}");
}

/// A sensor that is far from everything, and one that everything is far from.
#[test]
fn far_away() {
    let mut tally = Tally::default();
    let mut random = Random(76);
    let bodies = bodies(&mut random, 80);
    for distance in [1e2, 1e3, 1e4, 1e5, 1e6] {
        let half = 40.0 / distance;
        let mut spec = spec(linear(half, -half, 40), 40);
        (spec.azimuth_start, spec.azimuth_span, spec.max_range) = (half, 2.0 * half, 1e8);
        let rotation = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_y(0.4);
        let pose = Pose { rotation, translation: -distance * rotation.x_axis + DVec3::new(0.1, 0.2, 0.3) };
        tally.compare(format!("from {distance} m"), &bodies, &pattern(spec), &[pose]);
    }
    assert!(tally.hits > 1000, "{tally:?}");
}
