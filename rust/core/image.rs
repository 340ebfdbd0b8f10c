//! The images that a scan writes.

use rayon::prelude::*;

/// What one ray brings back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Return {
    /// The distance along the ray [m].
    pub depth: f32,
    /// The class of the primitive.
    pub label: u8,
    /// The instance of the primitive.
    pub instance: u32,
    /// The index of the primitive in the scene.
    pub primitive: i32,
    /// The cosine of the angle between the ray and the surface normal, 0 to 1.
    pub incidence: f32,
}

/// The images of one scan, row by row; a pixel without return is 0 in all of them and -1 in `primitive`.
#[derive(Clone, Debug, PartialEq)]
pub struct Images {
    /// Beams.
    pub rows: usize,
    /// Rays of each beam.
    pub columns: usize,
    /// Distances along the rays [m].
    pub depth: Vec<f32>,
    /// Classes.
    pub label: Vec<u8>,
    /// Instances.
    pub instance: Vec<u32>,
    /// Indices of the primitives.
    pub primitive: Vec<i32>,
    /// Cosines of incidence.
    pub incidence: Vec<f32>,
}

/// One row of all images, to be written.
pub(crate) struct RowMut<'a> {
    depth: &'a mut [f32],
    label: &'a mut [u8],
    instance: &'a mut [u32],
    primitive: &'a mut [i32],
    incidence: &'a mut [f32],
}

impl Images {
    /// Images without any return.
    pub fn new(rows: usize, columns: usize) -> Images {
        let pixels = rows * columns;
        Images {
            rows,
            columns,
            depth: vec![0.0; pixels],
            label: vec![0; pixels],
            instance: vec![0; pixels],
            primitive: vec![-1; pixels],
            incidence: vec![0.0; pixels],
        }
    }

    /// The return of one pixel, if it has one.
    pub fn get(&self, row: usize, column: usize) -> Option<Return> {
        let pixel = row * self.columns + column;
        (self.depth[pixel] > 0.0).then(|| Return {
            depth: self.depth[pixel],
            label: self.label[pixel],
            instance: self.instance[pixel],
            primitive: self.primitive[pixel],
            incidence: self.incidence[pixel],
        })
    }

    /// All rows at once; no two threads get the same one.
    pub(crate) fn par_rows_mut(&mut self) -> impl IndexedParallelIterator<Item = RowMut<'_>> {
        let width = self.columns;
        (
            self.depth.par_chunks_mut(width),
            self.label.par_chunks_mut(width),
            self.instance.par_chunks_mut(width),
            self.primitive.par_chunks_mut(width),
            self.incidence.par_chunks_mut(width),
        )
            .into_par_iter()
            .map(|(depth, label, instance, primitive, incidence)| RowMut {
                depth,
                label,
                instance,
                primitive,
                incidence,
            })
    }
}

impl RowMut<'_> {
    /// Writes the return of one column.
    pub(crate) fn set(&mut self, column: usize, value: Return) {
        self.depth[column] = value.depth;
        self.label[column] = value.label;
        self.instance[column] = value.instance;
        self.primitive[column] = value.primitive;
        self.incidence[column] = value.incidence;
    }
}
