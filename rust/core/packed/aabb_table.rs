//! Axis-aligned boxes as columns of numbers: for the bounds of many at once.

use glam::DVec3;

use crate::Bounds;
use crate::simd::WIDEST;

/// Boxes as columns of numbers, by axis and padded to whole vectors.
#[derive(Debug)]
pub(crate) struct AabbTable {
    pub(crate) center: [Vec<f32>; 3],
    pub(crate) half: [Vec<f32>; 3],
    /// Lengths of the diagonals.
    pub(crate) size: Vec<f32>,
    pub(crate) count: usize,
}

impl AabbTable {
    pub(super) fn new(boxes: Vec<Bounds>) -> AabbTable {
        let padded = boxes.len().next_multiple_of(WIDEST);
        let table = |f: &dyn Fn(&Bounds) -> f32| {
            let mut table: Vec<f32> = boxes.iter().map(f).collect();
            table.resize(padded, 0.0);
            table
        };
        AabbTable {
            center: [0, 1, 2].map(|k| table(&|b| f32_center(b)[k] as f32)),
            // The middle was rounded, so the box is measured from there, and rounded upwards.
            half: [0, 1, 2].map(|k| {
                table(&|b| {
                    let center = f32_center(b)[k];
                    ((b.max[k] - center).max(center - b.min[k]) as f32).next_up()
                })
            }),
            size: table(&|b| b.diagonal() as f32),
            count: boxes.len(),
        }
    }
}

/// The middle rounded to f32.
pub(super) fn f32_center(bounds: &Bounds) -> DVec3 {
    bounds.center().as_vec3().as_dvec3()
}
