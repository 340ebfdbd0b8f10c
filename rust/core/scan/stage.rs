//! A scene as the scan kernel wants it: bodies as columns of numbers, for the bounds of many at once.

use super::bounds::Outline;
use super::lanes::WIDEST;
use crate::body::{Body, Solid};

/// Where the bodies of a scene are.
#[derive(Debug)]
pub(crate) struct Stage {
    pub(super) hulls: [Hulls; 3],
    /// The bodies that are meshes.
    pub(super) meshes: Vec<usize>,
    /// The number of the first surface of each body: a mesh has one for each triangle.
    surfaces: Vec<u32>,
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
        let mut next = 0_usize;
        let mut surfaces = |body: &Body| {
            let first = next;
            next += body.solid.surfaces();
            // Numbers are u32, as many as fit in memory by far; the last one says that a pixel is in doubt.
            u32::try_from(first).unwrap_or(u32::MAX)
        };
        Stage {
            hulls: [Outline::Box, Outline::Cylinder, Outline::Ellipsoid].map(|outline| Hulls::new(outline, bodies)),
            meshes: (0..bodies.len()).filter(|&i| matches!(bodies[i].solid, Solid::Mesh(_))).collect(),
            surfaces: bodies.iter().map(&mut surfaces).collect(),
        }
    }

    /// The number of the first surface of a body.
    pub(super) fn surface(&self, body: usize) -> u32 {
        self.surfaces[body]
    }

    /// The body of a surface, and which of its surfaces it is.
    pub(super) fn body_of(&self, surface: u32) -> (usize, u32) {
        let body = self.surfaces.partition_point(|&first| first <= surface) - 1;
        (body, surface - self.surfaces[body])
    }
}

impl Solid {
    fn surfaces(&self) -> usize {
        if let Solid::Mesh(mesh) = self { mesh.faces.len() } else { 1 }
    }

    /// Half extents and outline of what is no mesh.
    fn hull(&self) -> Option<([f64; 3], Outline)> {
        match self {
            Solid::Cuboid(shape) => Some((shape.half.to_array(), Outline::Box)),
            Solid::Rectangle(shape) => Some((shape.half.extend(0.0).to_array(), Outline::Box)),
            Solid::Ellipsoid(shape) => Some((shape.radii.to_array(), Outline::Ellipsoid)),
            Solid::Cylinder(shape) => Some((shape.half.to_array(), Outline::Cylinder)),
            Solid::Mesh(_) => None,
        }
    }
}

impl Hulls {
    fn new(outline: Outline, bodies: &[Body]) -> Hulls {
        let mut hulls = Hulls { outline, bodies: Vec::new(), center: Default::default(), axes: Default::default() };
        for (i, body) in bodies.iter().enumerate() {
            let Some((half, _)) = body.solid.hull().filter(|hull| hull.1 == outline) else {
                continue;
            };
            hulls.bodies.push(i as u32);
            hulls.center.iter_mut().zip(body.place.center.to_array()).for_each(|(table, x)| table.push(x));
            for (axis, half) in half.into_iter().enumerate() {
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
