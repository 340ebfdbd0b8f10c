//! Scenes that are joined from others.

use std::sync::Arc;

use glam::DVec3;

use super::{Random, box_mesh, linear, pattern, primitive, random_scene, scanned, spec};
use crate::body::Solid;
use crate::{Error, Pose, Primitive, Scene, Shape};

/// The scene with the numbers of another as its media.
fn keyed(primitives: Vec<Primitive>, first: u32) -> Scene {
    let count = primitives.len() as u32;
    Scene::new(primitives).unwrap().with_media((first..first + count).collect()).unwrap()
}

#[test]
fn as_if_compiled_of_all() {
    for middle in [DVec3::ZERO, DVec3::new(4e5, -5e6, 130.0)] {
        let all = random_scene(&mut Random(47), 60, middle);
        let pattern = pattern(spec(linear(1.2, -1.2, 48), 256));
        let pose = Pose { translation: middle, ..Pose::IDENTITY };
        let whole = keyed(all.clone(), 0);
        let built = scanned(&whole, &pattern, &pose);
        // Of two scenes whose origins differ from that of the whole, and from each other.
        let (low, high) = (keyed(all[..20].to_vec(), 0), keyed(all[20..].to_vec(), 20));
        let (first, last): (Vec<u32>, Vec<u32>) = ((0..20).collect(), (0..40).collect());
        let joined = Scene::joined(&[(&low, &first), (&high, &last)], None).unwrap();
        assert_eq!(joined.origin(), whole.origin());
        assert_eq!(scanned(&joined, &pattern, &pose), built);
        // In pieces, and by way of another origin.
        let elsewhere = Scene::joined(&[(&whole, &first)], Some(DVec3::new(1.0, 2.0, 3.0) + middle)).unwrap();
        let rest: Vec<u32> = (20..60).collect();
        let again = Scene::joined(&[(&elsewhere, &first), (&whole, &rest)], Some(whole.origin())).unwrap();
        assert_eq!(scanned(&again, &pattern, &pose), built);
    }
}

#[test]
fn where_things_were_moved_to() {
    let all = random_scene(&mut Random(53), 30, DVec3::ZERO);
    let scene = Scene::new(all).unwrap();
    let pattern = pattern(spec(linear(1.2, -1.2, 32), 128));
    let poses: Vec<Pose> = (0..3).map(|_| Random(59).pose(9.0)).collect();
    let moved = scene.moved(&[3, 8, 2], &poses).unwrap();
    let every: Vec<u32> = (0..30).collect();
    let joined = Scene::joined(&[(&moved, &every)], Some(DVec3::splat(0.7))).unwrap();
    let back = Scene::joined(&[(&joined, &every)], Some(scene.origin())).unwrap();
    let seen = scanned(&moved, &pattern, &Pose::IDENTITY);
    assert_eq!(scanned(&back, &pattern, &Pose::IDENTITY), seen);
    // What decides the origin is where things were made.
    assert_eq!(Scene::joined(&[(&moved, &every)], None).unwrap().origin(), scene.origin());
}

#[test]
fn meshes_are_shared_and_indices_checked() {
    let scene = Scene::new(vec![primitive(Shape::Mesh(box_mesh()), [0.0; 3], [2.0; 3])]).unwrap();
    let twice = Scene::joined(&[(&scene, &[0]), (&scene, &[0])], Some(DVec3::X)).unwrap();
    match (&scene.bodies()[0].solid, &twice.bodies()[1].solid) {
        (Solid::Mesh(a), Solid::Mesh(b)) => assert!(Arc::ptr_eq(a, b)),
        _ => panic!("a mesh became something else"),
    }
    let error = Scene::joined(&[(&scene, &[0, 1])], None).err().unwrap();
    assert!(matches!(error, Error::MovedIndex { entry: 1, primitive: 1, count: 1 }), "{error}");
    assert_eq!(Scene::joined(&[], None).unwrap().origin(), DVec3::ZERO);
}
