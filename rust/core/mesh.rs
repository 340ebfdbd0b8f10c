//! Triangle meshes.

use glam::DVec3;

use crate::{Bounds, Error, Result};

/// Volumes, as shares of the box around a mesh, whose sign rounding cannot change.
const SURE: f64 = 1e-9;

/// Triangles that share vertices; every coordinate is finite and every index in range.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    vertices: Vec<[f64; 3]>,
    faces: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// A mesh of at least one triangle. Triangles without area are allowed; no ray hits them.
    ///
    /// # Errors
    /// [`Error::EmptyMesh`], [`Error::VertexNotFinite`] or [`Error::FaceIndex`].
    pub fn new(vertices: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> Result<TriangleMesh> {
        if vertices.is_empty() || faces.is_empty() {
            return Err(Error::EmptyMesh { vertices: vertices.len(), faces: faces.len() });
        }
        if let Some(vertex) = vertices.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(Error::VertexNotFinite { vertex, position: vertices[vertex] });
        }
        for (face, corners) in faces.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices.len()) {
                return Err(Error::FaceIndex { face, vertex, vertices: vertices.len() });
            }
        }
        Ok(TriangleMesh { vertices, faces })
    }

    /// The positions that the faces refer to.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// The vertex numbers of each triangle.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// An edge of a triangle that is not shared with exactly one other triangle of the opposite direction; `None` if
    /// the mesh is closed.
    pub(crate) fn open_edge(&self) -> Option<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = self.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        let count = |edge: &[u32; 2]| {
            let first = edges.partition_point(|other| other < edge);
            edges[first..].iter().take_while(|&other| other == edge).take(2).count()
        };
        edges.iter().copied().find(|&[a, b]| count(&[a, b]) != 1 || count(&[b, a]) != 1)
    }

    /// Whether it is proven that the mesh encloses one body, does not intersect itself, and has faces that are
    /// counterclockwise from outside. Many such meshes are not proven.
    ///
    /// If every face points away from the middle, directions from there meet no face from behind. A closed surface is
    /// then met equally often in all directions. If that is once in one of them, no two faces cover the same direction,
    /// and so none touches another.
    pub(crate) fn is_proven_outward(&self) -> bool {
        let vertex = |v: u32| DVec3::from(self.vertices[v as usize]);
        let bounds = self
            .faces
            .iter()
            .flatten()
            .fold(Bounds::EMPTY, |all, &v| all.union(Bounds { min: vertex(v), max: vertex(v) }));
        let (middle, sure) = (bounds.center(), SURE * (bounds.max - bounds.min).element_product());
        let corners = |face: &[u32; 3]| face.map(|v| vertex(v) - middle);
        let volume = |a: DVec3, b: DVec3, c: DVec3| a.dot(b.cross(c));
        let looks_away = |face: &[u32; 3]| {
            let [a, b, c] = corners(face);
            volume(a, b, c) > sure
        };
        if !self.faces.iter().all(looks_away) {
            return false;
        }
        let [a, b, c] = corners(&self.faces[0]);
        let through = 0.5 * a + 0.3 * b + 0.2 * c;
        let may_meet = |face: &&[u32; 3]| {
            let [a, b, c] = corners(face);
            [(a, b), (b, c), (c, a)].into_iter().all(|(a, b)| volume(through, a, b) >= -sure)
        };
        self.faces.iter().filter(may_meet).count() == 1 && self.open_edge().is_none()
    }

    /// The vertices and faces, without a copy.
    pub fn into_parts(self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        (self.vertices, self.faces)
    }
}
