//! A scene as the scan kernel wants it: bodies as columns of numbers, for the bounds of many at once.

use glam::DVec3;

use super::bounds::Outline;
use super::lanes::WIDEST;
use crate::body::{Body, Solid};

/// So many surfaces share an entry of a table.
const STEP: usize = 8;

/// Where the bodies of a scene are.
#[derive(Debug)]
pub(crate) struct Stage {
    pub(super) hulls: [Hulls; 3],
    /// The number of the first surface of each body: a mesh has one for each triangle. And that of none.
    surfaces: Vec<u32>,
    /// The body of each `STEP`-th surface.
    steps: Vec<u32>,
}

/// Boxes around the bodies of one outline, padded to whole vectors.
#[derive(Debug)]
pub(super) struct Hulls {
    pub(super) outline: Outline,
    pub(super) bodies: Vec<u32>,
    /// By coordinate.
    pub(super) center: [Vec<f64>; 3],
    /// Half axes: axis, coordinate.
    pub(super) axes: [[Vec<f32>; 3]; 3],
}

impl Stage {
    pub(crate) fn new(bodies: &[Body]) -> Stage {
        let (mut next, mut surfaces, mut steps) = (0_usize, Vec::with_capacity(bodies.len() + 1), Vec::new());
        // Numbers are u32, as many as fit in memory by far; the last one says that a pixel is in doubt.
        let number = |surface: usize| u32::try_from(surface).unwrap_or(u32::MAX);
        for (i, body) in bodies.iter().enumerate() {
            surfaces.push(number(next));
            next += body.solid.surfaces();
            steps.resize(next.div_ceil(STEP), i as u32);
        }
        surfaces.push(u32::MAX);
        let hulls = [Outline::Box, Outline::Cylinder, Outline::Ellipsoid].map(|outline| Hulls::new(outline, bodies));
        Stage { hulls, surfaces, steps }
    }

    /// The number of the first surface of a body.
    pub(super) fn surface(&self, body: usize) -> u32 {
        self.surfaces[body]
    }

    /// The body of a surface, and which of its surfaces it is.
    #[inline(always)]
    pub(super) fn body_of(&self, surface: u32) -> (usize, u32) {
        let mut body = self.steps[surface as usize / STEP] as usize;
        while self.surfaces[body + 1] <= surface {
            body += 1;
        }
        (body, surface - self.surfaces[body])
    }
}

impl Solid {
    fn surfaces(&self) -> usize {
        if let Solid::Mesh(mesh) = self { mesh.faces.len() } else { 1 }
    }

    /// Middle and half extents of the box around the solid, in its frame, and how it fills that.
    fn hull(&self) -> (DVec3, DVec3, Outline) {
        match self {
            Solid::Cuboid(shape) => (DVec3::ZERO, shape.half, Outline::Box),
            Solid::Rectangle(shape) => (DVec3::ZERO, shape.half.extend(0.0), Outline::Box),
            Solid::Ellipsoid(shape) => (DVec3::ZERO, shape.radii, Outline::Ellipsoid),
            Solid::Cylinder(shape) => (DVec3::ZERO, shape.half, Outline::Cylinder),
            Solid::Mesh(mesh) => (mesh.bounds.center(), (mesh.bounds.max - mesh.bounds.min) / 2.0, Outline::Box),
        }
    }
}

impl Hulls {
    fn new(outline: Outline, bodies: &[Body]) -> Hulls {
        let mut hulls = Hulls { outline, bodies: Vec::new(), center: Default::default(), axes: Default::default() };
        for (i, body) in bodies.iter().enumerate() {
            let (center, half, filled) = body.solid.hull();
            if filled != outline {
                continue;
            }
            hulls.bodies.push(i as u32);
            let center = body.place.outward(center);
            hulls.center.iter_mut().zip(center.to_array()).for_each(|(table, x)| table.push(x));
            for (axis, half) in half.to_array().into_iter().enumerate() {
                let vector = body.place.rotation.col(axis) * half;
                hulls.axes[axis].iter_mut().zip(vector.to_array()).for_each(|(table, x)| table.push(x as f32));
            }
        }
        let padded = hulls.bodies.len().next_multiple_of(WIDEST);
        hulls.center.iter_mut().for_each(|table| table.resize(padded, 0.0));
        hulls.axes.iter_mut().flatten().for_each(|table| table.resize(padded, 0.0));
        hulls
    }
}
