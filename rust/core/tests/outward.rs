//! Meshes whose faces all look outwards: what is proven, and what is left out because of it.

use glam::DVec3;

use super::{box_mesh, grid};
use crate::TriangleMesh;

/// Meshes side by side in one, each moved and scaled.
fn joined(parts: &[(&TriangleMesh, DVec3, f64)]) -> TriangleMesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (mesh, offset, scale) in parts {
        let first = vertices.len() as u32;
        vertices.extend(mesh.vertices().iter().map(|&v| (DVec3::from(v) * *scale + *offset).to_array()));
        faces.extend(mesh.faces().iter().map(|face| face.map(|v| first + v)));
    }
    TriangleMesh::new(vertices, faces).unwrap()
}

fn with_faces(mesh: &TriangleMesh, faces: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh::new(mesh.vertices().to_vec(), faces).unwrap()
}

/// A prism over a closed line that goes around its middle `turns` times in five steps.
fn star_prism(turns: u32) -> TriangleMesh {
    let corner = |k: u32, z: f64| {
        let angle = f64::from(turns * k) * std::f64::consts::TAU / 5.0;
        [angle.cos(), angle.sin(), z]
    };
    let ring = |z: f64| (0..5).map(move |k| corner(k, z));
    let vertices = ring(-0.5).chain(ring(0.5)).chain([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]).collect();
    let side = |k: u32| {
        let next = (k + 1) % 5;
        [[k, next, next + 5], [k, next + 5, k + 5], [10, next, k], [11, k + 5, next + 5]]
    };
    TriangleMesh::new(vertices, (0..5).flat_map(side).collect()).unwrap()
}

#[test]
fn bodies_seen_from_their_middle_are_proven() {
    for offset in [DVec3::ZERO, DVec3::new(1e6, -3e5, 20.0)] {
        assert!(joined(&[(&box_mesh(), offset, 0.01)]).is_proven_outward());
        assert!(joined(&[(&star_prism(1), offset, 3.0)]).is_proven_outward());
    }
}

#[test]
fn nothing_else_is_proven() {
    let whole = box_mesh();
    let open = with_faces(&whole, whole.faces()[1..].to_vec());
    let inside_out = with_faces(&whole, whole.faces().iter().map(|&[a, b, c]| [c, b, a]).collect());
    let mut one_turned = whole.faces().to_vec();
    one_turned[4].swap(0, 1);
    let twice = with_faces(&whole, [whole.faces(), whole.faces()].concat());
    let meshes = [
        ("open", open),
        ("inside out", inside_out),
        ("one face turned", with_faces(&whole, one_turned)),
        ("every face twice", twice),
        ("one within another", joined(&[(&whole, DVec3::ZERO, 1.0), (&whole, DVec3::ZERO, 0.5)])),
        ("two that cut each other", joined(&[(&whole, DVec3::ZERO, 1.0), (&whole, DVec3::splat(0.1), 1.0)])),
        ("two apart", joined(&[(&whole, DVec3::ZERO, 1.0), (&whole, DVec3::X * 3.0, 1.0)])),
        ("around twice", star_prism(2)),
        ("a sheet", grid(3, |x, y| x * y)),
    ];
    for (name, mesh) in meshes {
        assert!(!mesh.is_proven_outward(), "{name}");
    }
}
