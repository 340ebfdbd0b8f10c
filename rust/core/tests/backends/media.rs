//! Media: every backend has the same free paths as the reference, to the last pixel.

use glam::DVec3;

use super::random::any_pattern;
use super::{Random, Tally, at, linear, pattern, primitive, scene, shapes, solid, spec};
use crate::{Backend, Images, Pose, Primitive, Scene, Shape, scan, scan_batch};

/// A shape that can be a medium, of any size, turned anywhere.
fn medium(random: &mut Random, k: usize, reach: f64) -> Primitive {
    // A mesh costs the reference more; one in ten is enough.
    let shape = if k % 10 == 9 { 4 } else { [0, 1, 2][k % 3] };
    let scale = random.pick(&[1.0, 1.0, 4.0]);
    let size = [(); 3].map(|()| random.magnitude(0.05, 5.0) * scale);
    let center = random.vector(-reach, reach).to_array();
    Primitive {
        yaw: random.between(-4.0, 4.0),
        label: (k % 200) as u8 + 1,
        instance: k as u32,
        extinction: Some(random.magnitude(0.05, 20.0)),
        ..primitive(shapes()[shape].clone(), center, size)
    }
}

/// Media among solids, some of both tilted.
fn mixed(random: &mut Random, count: usize, reach: f64) -> Scene {
    let mut primitives: Vec<Primitive> = (0..count).map(|k| medium(random, k, reach)).collect();
    for k in (0..count).step_by(3) {
        primitives[k].extinction = None;
    }
    primitives.push(primitive(Shape::Plane, [0.0, 0.0, -2.0], [90.0, 90.0, 0.0]));
    let tilted: Vec<u32> = (0..count as u32).filter(|_| random.between(0.0, 1.0) < 0.4).collect();
    let poses: Vec<Pose> = tilted.iter().map(|_| random.pose(reach)).collect();
    scene(primitives).moved(&tilted, &poses).unwrap()
}

fn random_media(seeds: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let mut random = Random(7000 + seed);
        let count = random.pick(&[1, 5, 20, 80]);
        let reach = random.pick(&[3.0, 12.0, 40.0]);
        let scene = mixed(&mut random, count, reach);
        for scan in 0..4 {
            let pattern = pattern(any_pattern(&mut random, 12, 120));
            let pose = random.pose(reach);
            tally.compare(format!("seed {seed}, scan {scan}"), &scene, &pattern, &[pose]);
            let poses: Vec<Pose> = (0..120)
                .map(|k| Pose { translation: pose.translation + DVec3::new(0.02, 0.003, 0.001) * f64::from(k), ..pose })
                .collect();
            tally.compare(format!("seed {seed}, drive {scan}"), &scene, &pattern, &poses);
        }
    }
    tally
}

#[test]
fn random_scenes() {
    let tally = random_media(0..60);
    assert!(tally.hits > tally.rays / 10, "{tally:?}");
    tally.print("media");
}

#[test]
#[ignore = "minutes"]
fn many_random_scenes() {
    random_media(60..4000).print("media");
}

#[test]
fn from_within_and_from_the_surface() {
    let mut tally = Tally::default();
    let around = pattern(spec(linear(1.5, -1.5, 15), 72));
    for shape in &shapes()[..3] {
        for size in [[2.0, 2.0, 2.0], [0.3, 30.0, 4.0], [60.0, 60.0, 8.0]] {
            for extinction in [0.02, 0.5, 5.0, 1e9, 1e300, 1e-300] {
                let medium = Primitive { extinction: Some(extinction), ..solid(shape, [0.0; 3], size) };
                let wall = Primitive { label: 2, ..primitive(Shape::Box, [0.0; 3], [90.0; 3]) };
                let one = scene(vec![medium, wall]);
                for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(-0.6, 0.8, 0.0)] {
                    for offset in [0.0, 0.3, 0.97, 0.9999, 1.0, 1.0001, 1.03, 3.0] {
                        let place = (axis * offset * DVec3::from(size) / 2.0).to_array();
                        let name = format!("{shape:?} of {size:?}, {extinction} per metre, from {place:?}");
                        tally.compare(name, &one, &around, &[at(place[0], place[1], place[2])]);
                    }
                }
            }
        }
    }
    assert!(tally.hits > tally.rays * 8 / 10, "{tally:?}");
    tally.print("within media");
}

/// A scan with a seed.
fn look(scene: &Scene, backend: Backend, seed: u64, threads: usize) -> Images {
    let pattern = pattern(spec(linear(0.3, -0.4, 16), 500));
    let mut images = Images::new(16, 500);
    scan(scene, &pattern, &[Pose::IDENTITY], seed, &mut images.as_mut(), Some(backend), threads).unwrap();
    images
}

#[test]
fn bits() {
    let scene = mixed(&mut Random(51), 80, 14.0);
    for backend in Backend::available() {
        let one = look(&scene, backend, 5, 1);
        assert!(one.depth == look(&scene, backend, 5, 1).depth);
        assert!(one.depth != look(&scene, backend, 6, 1).depth);
        for threads in [2, 3, 7, 0] {
            assert!(one == look(&scene, backend, 5, threads), "{}, {threads} threads", backend.name());
        }
        let pattern = pattern(spec(linear(0.3, -0.4, 16), 500));
        let poses = [&[Pose::IDENTITY][..]; 3];
        for threads in [1, 2] {
            let mut batch = vec![Images::new(16, 500); 3];
            let mut all: Vec<_> = batch.iter_mut().map(Images::as_mut).collect();
            scan_batch(&scene, &pattern, &poses, 4, &mut all, Some(backend), threads).unwrap();
            for (k, images) in batch.iter().enumerate() {
                assert!(*images == look(&scene, backend, 4 + k as u64, 1), "{}, scan {k}", backend.name());
            }
        }
    }
}
