//! Every backend against the reference: the same surface on every ray, at the same range.

mod bits;
mod corners;
mod fuzz;
mod media;
mod meshes;
mod random;
mod rolling;
mod rooms;
mod solids;

use std::fmt::Display;

use glam::{DMat3, DVec3};

use super::{Random, box_mesh, grid, linear, pattern, primitive, random_scene, spec};
use crate::{Backend, Images, Pose, Primitive, Scene, SensorPattern, Shape, scan};

/// How much was compared.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: usize,
    hits: usize,
    /// The largest error of a range, as a share of what is allowed.
    worst: f32,
}

impl Tally {
    /// Compares a scan of every backend with the reference; `name` tells which one it was.
    fn compare(&mut self, name: impl Display, scene: &Scene, pattern: &SensorPattern, poses: &[Pose]) {
        let expected = seen(scene, pattern, poses, Backend::Reference, 1);
        for backend in fast() {
            let found = seen(scene, pattern, poses, backend, 1);
            let wrong: Vec<usize> = (0..found.depth.len()).filter(|&i| !same(&found, &expected, i)).collect();
            if let Some(&i) = wrong.first() {
                let (row, column) = (i / pattern.columns(), i % pattern.columns());
                let pixel =
                    |images: &Images| (images.depth[i], images.primitive[i], images.label[i], images.instance[i]);
                panic!(
                    "{name}, {}: {} of {} pixels; row {row}, column {column} is {:?}, not {:?}",
                    backend.name(),
                    wrong.len(),
                    found.depth.len(),
                    pixel(&found),
                    pixel(&expected)
                );
            }
            let error = |(&a, &b): (&f32, &f32)| (a - b).abs() / tolerance(b);
            self.worst = found.depth.iter().zip(&expected.depth).map(error).fold(self.worst, f32::max);
            self.rays += found.depth.len();
            self.hits += expected.depth.iter().filter(|&&depth| depth > 0.0).count();
        }
    }

    #[expect(clippy::print_stdout, reason = "shown on request")]
    fn print(self, name: &str) {
        let Tally { rays, hits, worst } = self;
        println!("{name}: {rays} rays, {hits} hits, ranges off by up to {worst:.3} of what is allowed");
    }
}

/// How far a range may be off [m].
fn tolerance(range: f32) -> f32 {
    2e-3 + 1e-5 * range
}

/// Whether two scans have the same return at a pixel.
fn same(a: &Images, b: &Images, i: usize) -> bool {
    (a.depth[i] > 0.0) == (b.depth[i] > 0.0)
        && (a.depth[i] - b.depth[i]).abs() <= tolerance(b.depth[i])
        && (a.primitive[i], a.label[i], a.instance[i]) == (b.primitive[i], b.label[i], b.instance[i])
}

/// The backends that this machine has besides the reference.
fn fast() -> impl Iterator<Item = Backend> {
    Backend::available().into_iter().filter(|&backend| backend != Backend::Reference)
}

fn seen(scene: &Scene, pattern: &SensorPattern, poses: &[Pose], backend: Backend, threads: usize) -> Images {
    let mut images = Images::new(pattern.rows(), pattern.columns());
    scan(scene, pattern, poses, 0, &mut images.as_mut(), Some(backend), threads).unwrap();
    images
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose { translation: DVec3::new(x, y, z), ..Pose::IDENTITY }
}

fn scene(primitives: Vec<Primitive>) -> Scene {
    Scene::new(primitives).unwrap()
}

/// The five shapes.
fn shapes() -> [Shape; 5] {
    [Shape::Box, Shape::Ellipsoid, Shape::Cylinder, Shape::Plane, Shape::Mesh(box_mesh())]
}

/// A shape of these extents; a plane is flat.
fn solid(shape: &Shape, center: [f64; 3], [x, y, z]: [f64; 3]) -> Primitive {
    primitive(shape.clone(), center, if *shape == Shape::Plane { [x, y, 0.0] } else { [x, y, z] })
}

impl Random {
    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.between(0.0, from.len() as f64) as usize]
    }

    /// A number between two positive ones, its logarithm uniform.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn rotation(&mut self) -> DMat3 {
        self.pose(0.0).rotation
    }
}

/// All kernels once, in little time: for processors that are emulated.
#[test]
fn smoke() {
    let mut random = Random(21);
    let mut tally = Tally::default();
    let mut primitives = random_scene(&mut random, 40, DVec3::ZERO);
    primitives.push(primitive(Shape::Box, [0.0; 3], [50.0, 60.0, 20.0]));
    primitives.push(primitive(Shape::Ellipsoid, [0.0; 3], [90.0, 90.0, 70.0]));
    let scene = scene(primitives);
    let level = pattern(spec(linear(1.2, -1.2, 9), 70));
    let turn = Pose { rotation: random.rotation(), translation: DVec3::new(1.0, 2.0, 3.0) };
    let apart = crate::SensorSpec { origins: vec![[0.1, -0.2, 0.3]; 9], ..level.spec().clone() };
    let poses: Vec<Pose> = (0..70).map(|k| at(0.01 * f64::from(k), 0.3, 0.1)).collect();
    tally.compare("level", &scene, &level, &[Pose::IDENTITY]);
    tally.compare("turned", &scene, &level, &[turn]);
    tally.compare("apart", &scene, &pattern(apart), &[turn]);
    tally.compare("rolling", &scene, &level, &poses);
    assert!(tally.hits > tally.rays / 2, "{tally:?}");
    let names: Vec<&str> = fast().map(Backend::name).collect();
    tally.print(&names.join(", "));
}
