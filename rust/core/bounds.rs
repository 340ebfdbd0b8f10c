//! Axis-aligned bounds.

use glam::DVec3;

/// The smallest axis-aligned box around something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// Bounds of nothing: the neutral element of [`Bounds::union`].
    pub const EMPTY: Bounds = Bounds { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Bounds from a centre and half extents.
    pub fn around(center: DVec3, half: DVec3) -> Bounds {
        Bounds { min: center - half, max: center + half }
    }

    /// Bounds of both.
    #[must_use]
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Bounds moved by an offset.
    #[must_use]
    pub fn moved(self, offset: DVec3) -> Bounds {
        Bounds { min: self.min + offset, max: self.max + offset }
    }

    /// Bounds grown to all sides by a margin.
    #[must_use]
    pub fn grown(self, margin: f64) -> Bounds {
        Bounds { min: self.min - margin, max: self.max + margin }
    }

    /// Whether there is nothing inside, not even a point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether a point is inside.
    pub(crate) fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// The middle.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) / 2.0
    }

    /// The length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// The distances at which a line enters and leaves; `None` if it passes by. Negative values are behind the origin.
    pub fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (low, high) = (self.min[axis] - origin[axis], self.max[axis] - origin[axis]);
            if direction[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / direction[axis], high / direction[axis]);
            enter = enter.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        (enter <= exit).then_some((enter, exit))
    }
}
