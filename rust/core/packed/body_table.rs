//! The bodies of a scene as columns of numbers: the boxes around them, and the numbers of their surfaces.

use super::{Obb, ObbTable, Outline};

/// The places of the bodies of a scene, and the numbers of their surfaces.
#[derive(Debug)]
pub(crate) struct BodyTable {
    /// One for each outline.
    pub(crate) obbs: [ObbTable; 3],
    /// The number of the first surface of each body: a mesh has one for each triangle.
    surfaces: Vec<u32>,
    /// The body of each surface.
    owners: Vec<u32>,
}

impl BodyTable {
    /// The table of bodies, from the box around each and its number of surfaces.
    pub(crate) fn new(bodies: impl Iterator<Item = (Obb, usize)>) -> BodyTable {
        let mut obbs = [Outline::Box, Outline::Cylinder, Outline::Ellipsoid].map(ObbTable::new);
        let (mut next, mut surfaces, mut owners) = (0_usize, Vec::new(), Vec::new());
        // Numbers are u32, far more than fit in memory; the last one marks unresolved pixels.
        let number = |surface: usize| u32::try_from(surface).unwrap_or(u32::MAX);
        for (body, (obb, count)) in bodies.enumerate() {
            obbs.iter_mut()
                .filter(|table| table.outline == obb.outline)
                .for_each(|table| table.push(body as u32, &obb));
            surfaces.push(number(next));
            next += count;
            owners.resize(next, body as u32);
        }
        obbs.iter_mut().for_each(ObbTable::pad);
        BodyTable { obbs, surfaces, owners }
    }

    /// The number of the first surface of a body.
    pub(crate) fn surface(&self, body: usize) -> u32 {
        self.surfaces[body]
    }

    /// The body of a surface.
    #[inline(always)]
    pub(crate) fn body_of(&self, surface: u32) -> usize {
        self.owners[surface as usize] as usize
    }
}
