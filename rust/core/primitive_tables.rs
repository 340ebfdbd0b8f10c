//! Primitives as columns of numbers, the form in which they cross a language border.

use crate::{Error, Primitive, Result, Shape, TriangleMesh};

/// One entry of each table for each primitive.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveTables<'a> {
    /// 0 box, 1 ellipsoid, 2 cylinder, 3 plane, 4 mesh.
    pub shapes: &'a [u8],
    /// Middles [m].
    pub centers: &'a [[f64; 3]],
    /// Full extents [m].
    pub sizes: &'a [[f64; 3]],
    /// Rotations about z [rad].
    pub yaws: &'a [f64],
    /// Classes.
    pub labels: &'a [u8],
    /// Instances.
    pub instances: &'a [u32],
    /// Extinctions [1/m], 0 for solids; empty if all are solid.
    pub extinctions: &'a [f64],
}

impl PrimitiveTables<'_> {
    /// The primitives; `meshes` are given to those of shape 4 in order.
    ///
    /// # Errors
    /// [`Error::PrimitiveTable`], [`Error::ShapeCode`] or [`Error::MeshCount`].
    pub fn primitives(&self, meshes: Vec<TriangleMesh>) -> Result<Vec<Primitive>> {
        self.check_lengths()?;
        let expected = self.shapes.iter().filter(|&&code| code == MESH).count();
        if meshes.len() != expected {
            let (meshes, primitives) = (meshes.len(), expected);
            return Err(Error::MeshCount { meshes, primitives });
        }
        let mut meshes = meshes.into_iter();
        let primitive = |i: usize| {
            Ok(Primitive {
                shape: shape(i, self.shapes[i], &mut meshes)?,
                center: self.centers[i],
                size: self.sizes[i],
                yaw: self.yaws[i],
                label: self.labels[i],
                instance: self.instances[i],
                extinction: self.extinctions.get(i).copied().filter(|&extinction| extinction != 0.0),
            })
        };
        (0..self.shapes.len()).map(primitive).collect()
    }

    fn check_lengths(&self) -> Result<()> {
        let primitives = self.shapes.len();
        let tables = [
            ("centers", self.centers.len()),
            ("sizes", self.sizes.len()),
            ("yaws", self.yaws.len()),
            ("labels", self.labels.len()),
            ("instances", self.instances.len()),
        ];
        let extinctions = (!self.extinctions.is_empty()).then_some(("extinctions", self.extinctions.len()));
        match tables.into_iter().chain(extinctions).find(|&(_, entries)| entries != primitives) {
            Some((table, entries)) => Err(Error::PrimitiveTable { table, entries, primitives }),
            None => Ok(()),
        }
    }
}

const MESH: u8 = 4;

fn shape(primitive: usize, code: u8, meshes: &mut impl Iterator<Item = TriangleMesh>) -> Result<Shape> {
    let shape = match code {
        0 => Some(Shape::Box),
        1 => Some(Shape::Ellipsoid),
        2 => Some(Shape::Cylinder),
        3 => Some(Shape::Plane),
        MESH => meshes.next().map(Shape::Mesh),
        _ => None,
    };
    shape.ok_or(Error::ShapeCode { primitive, code })
}
