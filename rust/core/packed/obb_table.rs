//! Boxes in any direction around bodies, as columns of numbers: for the bounds of many at once.

use glam::DVec3;

use crate::simd::WIDEST;

/// How a body fills the box around it, which decides its extent along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outline {
    Box,
    /// Round about its third axis, flat along it.
    Cylinder,
    Ellipsoid,
}

/// A box around a body, relative to the origin of the scene.
pub(crate) struct Obb {
    pub(crate) center: DVec3,
    pub(crate) half_axes: [DVec3; 3],
    pub(crate) outline: Outline,
}

/// Boxes around the bodies of one outline, padded to whole vectors.
#[derive(Debug)]
pub(crate) struct ObbTable {
    pub(crate) outline: Outline,
    pub(crate) bodies: Vec<u32>,
    /// By coordinate.
    pub(crate) center: [Vec<f64>; 3],
    /// By axis and coordinate.
    pub(crate) half_axes: [[Vec<f32>; 3]; 3],
}

impl ObbTable {
    pub(super) fn new(outline: Outline) -> ObbTable {
        ObbTable { outline, bodies: Vec::new(), center: Default::default(), half_axes: Default::default() }
    }

    pub(super) fn push(&mut self, body: u32, obb: &Obb) {
        self.bodies.push(body);
        self.center.iter_mut().zip(obb.center.to_array()).for_each(|(table, x)| table.push(x));
        for (table, axis) in self.half_axes.iter_mut().zip(obb.half_axes) {
            table.iter_mut().zip(axis.to_array()).for_each(|(table, x)| table.push(x as f32));
        }
    }

    /// Fills up the last vector.
    pub(super) fn pad(&mut self) {
        let padded = self.bodies.len().next_multiple_of(WIDEST);
        self.center.iter_mut().for_each(|table| table.resize(padded, 0.0));
        self.half_axes.iter_mut().flatten().for_each(|table| table.resize(padded, 0.0));
    }
}
