//! Triangle meshes.

use crate::{Error, Result};

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

    /// An edge of a triangle that is not met by exactly one other triangle, which runs along it the other way; `None` if
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

    /// The vertices and faces, without a copy.
    pub fn into_parts(self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        (self.vertices, self.faces)
    }
}
