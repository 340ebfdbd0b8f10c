//! Labelled points become shapes: clusters, boxes around them, the ground under them, and their agreement with the
//! rays.
//!
//! Points are in a frame with z up whose z axis passes through the sensor, so that "away from the sensor" is away from
//! x = y = 0. Nothing here uses more than one thread.

mod clusters;
mod fitting;
mod ground;
mod rays;
mod refinement;

use glam::DVec3;

pub use clusters::cluster;
pub use fitting::{FittedBox, fit_box};
pub use ground::HeightField;
pub use refinement::{Detail, Piece};

use rays::Rays;

/// The points of a scan, and the rays to them.
pub struct Cloud {
    points: Vec<DVec3>,
    rays: Rays,
    /// Evenly chosen ones.
    some: Rays,
}

impl Cloud {
    /// A cloud of finite points seen from `origin`; agreement is measured with at most `most_rays` of its rays.
    pub fn new(points: &[[f64; 3]], origin: [f64; 3], most_rays: usize) -> Cloud {
        let points: Vec<DVec3> = points.iter().map(|&point| point.into()).collect();
        let step = points.len().div_ceil(most_rays.max(1)).max(1);
        let [rays, some] = [1, step].map(|step| Rays::new(&points, origin.into(), step));
        Cloud { points, rays, some }
    }

    /// The number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}
