//! Rays per second on three scenes: `cargo bench`.
//!
//! `build` compiles a scene, `scan` casts one scan of 64 beams by 1024 columns with a new pose each time, on all cores
//! (`RAYON_NUM_THREADS` sets how many).

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DMat3, DVec3};
use lidardraft_core::{Pose, Primitive, Scene, SensorPattern, SensorSpec, Shape, TriangleMesh, scan};

const BEAMS: usize = 64;
const COLUMNS: usize = 1024;

/// 64 beams from +3 to -25 degrees.
fn hdl64() -> SensorPattern {
    let elevation = |h: usize| (3.0 - 28.0 * h as f64 / (BEAMS - 1) as f64).to_radians();
    let pattern = SensorPattern::new(SensorSpec {
        elevations: (0..BEAMS).map(elevation).collect(),
        azimuth_offsets: vec![0.0; BEAMS],
        origin_heights: vec![0.0; BEAMS],
        columns: COLUMNS,
        azimuth_start: PI,
        azimuth_span: TAU,
        min_range: 0.5,
        max_range: 120.0,
    });
    pattern.expect("the pattern is valid")
}

/// A golden-ratio sequence in [low, high): the same scene on every machine.
fn spread(k: usize, step: f64, low: f64, high: f64) -> f64 {
    low + (high - low) * (k as f64 * step).fract()
}

/// The ground, and bodies of 1 to 5 m between 4 and 80 m from the middle.
fn scene(boxes: usize, balls: usize, ball: &Shape) -> Vec<Primitive> {
    let ground =
        Primitive { shape: Shape::Plane, center: [0.0; 3], size: [400.0, 400.0, 0.0], yaw: 0.0, label: 1, instance: 0 };
    let body = |k: usize| {
        let (angle, radius) = (k as f64 * 2.399_963, 4.0 + 76.0 * spread(k, 0.618_034, 0.0, 1.0));
        let size = [0.754_878, 0.569_840, 0.430_160].map(|step| spread(k + 1, step, 1.0, 5.0));
        Primitive {
            shape: if k < boxes { Shape::Box } else { ball.clone() },
            center: [radius * angle.cos(), radius * angle.sin(), size[2] / 2.0],
            size,
            yaw: angle,
            label: if k < boxes { 2 } else { 3 },
            instance: k as u32 + 1,
        }
    };
    std::iter::once(ground).chain((0..boxes + balls).map(body)).collect()
}

/// The ball in the unit box as an icosahedron whose faces are split in four `splits` times.
fn icosphere(splits: usize) -> Shape {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut vertices: Vec<DVec3> = Vec::new();
    for axis in 0..3 {
        for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
            let mut vertex = [0.0; 3];
            (vertex[axis], vertex[(axis + 1) % 3]) = (a, b);
            vertices.push(DVec3::from(vertex).normalize() / 2.0);
        }
    }
    // The faces of the icosahedron are the twenty triples of vertices that are one edge apart.
    let edge = vertices[0].distance(vertices[2]);
    let joined = |a: usize, b: usize| (vertices[a].distance(vertices[b]) - edge).abs() < 1e-9;
    let mut faces: Vec<[usize; 3]> = Vec::new();
    for a in 0..12 {
        for b in (a + 1..12).filter(|&b| joined(a, b)) {
            faces.extend((b + 1..12).filter(|&c| joined(a, c) && joined(b, c)).map(|c| [a, b, c]));
        }
    }
    for _ in 0..splits {
        faces = split(&mut vertices, &faces);
    }
    let vertices = vertices.iter().map(DVec3::to_array).collect();
    let faces = faces.iter().map(|face| face.map(|v| v as u32)).collect();
    Shape::Mesh(TriangleMesh::new(vertices, faces).expect("the icosphere is a mesh"))
}

/// Four triangles for each; the new vertices lie on the ball and are shared.
fn split(vertices: &mut Vec<DVec3>, faces: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: usize, b: usize| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            vertices.push((vertices[a] + vertices[b]).normalize() / 2.0);
            vertices.len() - 1
        })
    };
    let quarters = |&[a, b, c]: &[usize; 3]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    faces.iter().flat_map(quarters).collect()
}

/// A car that drives on and turns.
fn pose(step: usize) -> Pose {
    let along = step as f64 * 0.37;
    Pose {
        rotation: DMat3::from_rotation_z(along),
        translation: DVec3::new(3.0 * along.cos(), 3.0 * along.sin(), 1.73),
    }
}

fn raycast(criterion: &mut Criterion) {
    let scenes = [
        ("small", scene(30, 0, &Shape::Ellipsoid)),
        ("street", scene(200, 100, &Shape::Ellipsoid)),
        ("street_triangles", scene(200, 100, &icosphere(2))),
    ];
    let pattern = hdl64();
    let build = |primitives| Scene::new(primitives).expect("the scene is valid");
    let mut builds = criterion.benchmark_group("build");
    for (name, primitives) in &scenes {
        builds.throughput(Throughput::Elements(primitives.len() as u64));
        builds.bench_function(*name, |bencher| {
            bencher.iter_batched(|| primitives.clone(), build, BatchSize::LargeInput);
        });
    }
    builds.finish();
    let mut scans = criterion.benchmark_group("scan");
    scans.throughput(Throughput::Elements((BEAMS * COLUMNS) as u64));
    for (name, primitives) in scenes {
        let scene = build(primitives);
        let mut step = 0;
        scans.bench_function(name, |bencher| {
            bencher.iter(|| {
                step += 1;
                black_box(scan(&scene, &pattern, &pose(step)))
            });
        });
    }
    scans.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(4))
        .sample_size(30);
    targets = raycast
}
criterion_main!(benches);
