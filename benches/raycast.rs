//! Rays per second: `cargo bench`, or `cargo bench -- scan/street` for some of it.
//!
//! Four scenes: a ground with 30 boxes; with 200 boxes and 100 ellipsoids, kept as they are or as triangles; a terrain of
//! 720,000 triangles with 220 ellipsoids of 1,280. Each is compiled (`build`), scanned with a new pose each time (`scan`),
//! from 16 poses in one call (`batch`), with a pose for each column (`rolling`), and asked for as many rays without any
//! order (`cast`); all but the first for three sensors. On all cores; `RAYON_NUM_THREADS` sets how many.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DMat3, DVec3};
use lidardraft_core::{
    Images, ImagesMut, Pose, Primitive, Scene, SensorPattern, SensorSpec, Shape, TriangleMesh, cast, scan, scan_batch,
};

/// Scans of a batch.
const SCANS: usize = 16;
/// Squares along a side of the terrain.
const CELLS: usize = 600;
/// Names of the scenes.
const SCENES: [&str; 4] = ["small", "street", "street_triangles", "heavy"];

/// A pattern of equal steps around the car, and its name; elevations in degrees.
fn pattern(rows: usize, columns: usize, high: f64, low: f64) -> (String, SensorPattern) {
    let elevation = |h: usize| (high + (low - high) * h as f64 / (rows - 1) as f64).to_radians();
    let pattern = SensorPattern::new(SensorSpec {
        elevations: (0..rows).map(elevation).collect(),
        azimuth_offsets: vec![0.0; rows],
        origins: vec![[0.0; 3]; rows],
        columns,
        azimuth_start: PI,
        azimuth_span: TAU,
        min_range: 0.5,
        max_range: 120.0,
    });
    (format!("{rows}x{columns}"), pattern.expect("the pattern is valid"))
}

/// Three sensors.
fn patterns() -> [(String, SensorPattern); 3] {
    [pattern(64, 1024, 3.0, -25.0), pattern(32, 1024, 10.67, -30.67), pattern(128, 2048, 22.5, -22.5)]
}

fn rays(pattern: &SensorPattern) -> usize {
    pattern.rows() * pattern.columns()
}

/// A golden-ratio sequence in [low, high): the same scene on every machine.
fn spread(k: usize, step: f64, low: f64, high: f64) -> f64 {
    low + (high - low) * (k as f64 * step).fract()
}

/// The primitives of a scene.
fn primitives(scene: &str) -> Vec<Primitive> {
    match scene {
        "small" => bodies(ground(), 30, 0, &Shape::Ellipsoid),
        "street" => bodies(ground(), 200, 100, &Shape::Ellipsoid),
        "street_triangles" => bodies(ground(), 200, 100, &icosphere(2)),
        _ => bodies(terrain(), 0, 220, &icosphere(3)),
    }
}

/// A ground, and bodies of 1 to 5 m between 6 and 80 m from the middle.
fn bodies(ground: Primitive, boxes: usize, balls: usize, ball: &Shape) -> Vec<Primitive> {
    let body = |k: usize| {
        let (angle, radius) = (k as f64 * 2.399_963, 6.0 + 74.0 * spread(k, 0.618_034, 0.0, 1.0));
        let size = [0.754_878, 0.569_840, 0.430_160].map(|step| spread(k + 1, step, 1.0, 5.0));
        Primitive {
            shape: if k < boxes { Shape::Box } else { ball.clone() },
            center: [radius * angle.cos(), radius * angle.sin(), size[2] / 2.0],
            size,
            yaw: angle,
            label: if k < boxes { 2 } else { 3 },
            instance: k as u32 + 1,
            extinction: None,
        }
    };
    std::iter::once(ground).chain((0..boxes + balls).map(body)).collect()
}

fn ground() -> Primitive {
    Primitive {
        shape: Shape::Plane,
        center: [0.0; 3],
        size: [400.0, 400.0, 0.0],
        yaw: 0.0,
        label: 1,
        instance: 0,
        extinction: None,
    }
}

/// Hills that are flat where the car drives, rough everywhere: [`CELLS`]^2 squares of two triangles in 300 m by 300 m.
fn terrain() -> Primitive {
    let size = [300.0, 300.0, 20.0];
    let side = CELLS + 1;
    let height = |x: f64, y: f64, k: usize| {
        let hills: f64 = (1..=12)
            .map(|i| {
                let (along, across) = (spread(i, 0.754_878, -0.1, 0.1), spread(i, 0.569_840, -0.1, 0.1));
                0.25 * (along * x + across * y + i as f64).sin()
            })
            .sum();
        hills * (x.hypot(y) / 30.0).min(1.0) + spread(k, 0.618_034, -0.02, 0.02)
    };
    let vertex = |k: usize| {
        let (u, v) = ((k % side) as f64 / CELLS as f64 - 0.5, (k / side) as f64 / CELLS as f64 - 0.5);
        [u, v, height(size[0] * u, size[1] * v, k) / size[2]]
    };
    let square = |k: usize| {
        let corner = k / CELLS * side + k % CELLS;
        let [a, b, c, d] = [corner, corner + 1, corner + side + 1, corner + side].map(|k| k as u32);
        [[a, b, c], [a, c, d]]
    };
    let mesh = TriangleMesh::new((0..side * side).map(vertex).collect(), (0..CELLS * CELLS).flat_map(square).collect());
    let shape = Shape::Mesh(mesh.expect("the terrain is a mesh"));
    Primitive { shape, center: [0.0; 3], size, yaw: 0.0, label: 1, instance: 0, extinction: None }
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
fn pose(step: f64) -> Pose {
    let along = step * 0.37;
    Pose {
        rotation: DMat3::from_rotation_z(along),
        translation: DVec3::new(3.0 * along.cos(), 3.0 * along.sin(), 1.73),
    }
}

/// The poses of the columns of one scan: the car gets a tenth of a step further.
fn column_poses(step: f64, columns: usize) -> Vec<Pose> {
    (0..columns).map(|column| pose(step + 0.1 * column as f64 / columns as f64)).collect()
}

/// Rays from around the car in all directions between +3 and -25 degrees, in no order.
fn loose_rays(count: usize) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let origin = |k: usize| [0.754_878, 0.569_840, 0.430_160].map(|step| spread(k, step, 1.0, 2.0));
    let direction = |k: usize| {
        let (azimuth, elevation) = (spread(k, 0.618_034, 0.0, TAU), spread(k, 0.430_160, -25.0, 3.0).to_radians());
        [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()]
    };
    ((0..count).map(origin).collect(), (0..count).map(direction).collect())
}

fn build(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("build");
    for name in SCENES {
        let primitives = primitives(name);
        group.throughput(Throughput::Elements(primitives.len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter_batched(
                || primitives.clone(),
                |primitives| Scene::new(primitives).expect("the scene is valid"),
                BatchSize::LargeInput,
            );
        });
    }
}

fn scans(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("scan");
    for (name, scene) in SCENES.map(|name| (name, compiled(name))) {
        for (size, pattern) in patterns() {
            let mut images = Images::new(pattern.rows(), pattern.columns());
            let mut step = 0.0;
            group.throughput(Throughput::Elements(rays(&pattern) as u64));
            group.bench_function(BenchmarkId::new(name, size), |bencher| {
                bencher.iter(|| {
                    step += 1.0;
                    scan(&scene, &pattern, &[pose(step)], 0, &mut three(&mut images), None, 0).expect("the images fit")
                });
            });
        }
    }
}

fn batch(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("batch");
    for (name, scene) in SCENES.map(|name| (name, compiled(name))) {
        for (size, pattern) in patterns() {
            let pixels = rays(&pattern);
            let mut images = Images::new(SCANS * pattern.rows(), pattern.columns());
            let mut step = 0.0;
            group.throughput(Throughput::Elements((SCANS * pixels) as u64));
            group.bench_function(BenchmarkId::new(name, size), |bencher| {
                bencher.iter(|| {
                    step += SCANS as f64;
                    let poses: Vec<[Pose; 1]> = (0..SCANS).map(|k| [pose(step + k as f64)]).collect();
                    let poses: Vec<&[Pose]> = poses.iter().map(|pose| &pose[..]).collect();
                    let mut images = three(&mut images);
                    scan_batch(&scene, &pattern, &poses, 0, &mut images.pieces(pixels), None, 0)
                        .expect("the images fit")
                });
            });
        }
    }
}

fn rolling(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("rolling");
    for (name, scene) in SCENES.map(|name| (name, compiled(name))) {
        for (size, pattern) in patterns() {
            let mut images = Images::new(pattern.rows(), pattern.columns());
            let mut step = 0.0;
            group.throughput(Throughput::Elements(rays(&pattern) as u64));
            group.bench_function(BenchmarkId::new(name, size), |bencher| {
                bencher.iter_batched(
                    || {
                        step += 1.0;
                        column_poses(step, pattern.columns())
                    },
                    |poses| {
                        scan(&scene, &pattern, &poses, 0, &mut three(&mut images), None, 0).expect("the images fit")
                    },
                    BatchSize::SmallInput,
                );
            });
        }
    }
}

fn casts(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cast");
    for (name, scene) in SCENES.map(|name| (name, compiled(name))) {
        for (size, pattern) in patterns() {
            let (origins, directions) = loose_rays(rays(&pattern));
            group.throughput(Throughput::Elements(origins.len() as u64));
            group.bench_function(BenchmarkId::new(name, size), |bencher| {
                bencher
                    .iter(|| cast(&scene, black_box(&origins), &directions, 120.0, 0, 0).expect("the rays are valid"));
            });
        }
    }
}

fn compiled(scene: &str) -> Scene {
    Scene::new(primitives(scene)).expect("the scene is valid")
}

/// Depth, label and instance, to be written.
fn three(images: &mut Images) -> ImagesMut<'_> {
    ImagesMut { primitive: None, incidence: None, normal: None, ..images.as_mut() }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .sample_size(10);
    targets = build, scans, batch, rolling, casts
}
criterion_main!(benches);
