//! One band of rays over some columns of a scan, in its own frame.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::ray_tests::Tolerance;
use crate::packed::{Band, padded};
use crate::simd::{Lanes, Vector};
use crate::{Pose, SensorPattern};

/// The rays of a band in some columns, and their starts.
///
/// A ray is `start(column) + t * (heading(phase, column) + slope(row) * up(column))`. In a view that stands still all rays start at
/// the origin, and up is z.
pub(super) struct View<'a> {
    pub(super) band: &'a Band,
    /// The columns of the pattern.
    pub(super) columns: Range<usize>,
    /// The frame: its origin in the scene's coordinates, and its axes there.
    pub(super) origin: DVec3,
    pub(super) rotation: DMat3,
    /// The error of f32 in the direction of a ray, as a share of the longest one's length.
    pub(super) rounding: f32,
    /// The precision of a resolved range.
    pub(super) tolerance: Tolerance,
    /// The limits of reported surfaces [m].
    pub(super) min_range: f32,
    pub(super) max_range: f32,
    pub(super) motion: Option<Motion>,
}

/// The difference of each column's rays from those of a static view.
pub(super) struct Motion {
    /// Phase by phase.
    heading: [Vec<f32>; 3],
    pub(super) up: [Vec<f32>; 3],
    pub(super) start: [Vec<f32>; 3],
    /// The largest distance of a ray's start from the origin [m].
    pub(super) shift: f32,
    /// The largest shift of a point at distance 1 by the rotation of a column [m].
    pub(super) twist: f32,
}

/// The rays of `L::N` columns, without their headings.
pub(super) struct Columns<L> {
    pub(super) up: Vector<L>,
    pub(super) start: Vector<L>,
}

impl<'a> View<'a> {
    /// The view from one pose, or from one for each of all columns; the poses are relative to the scene's origin.
    pub(super) fn new(band: &'a Band, columns: Range<usize>, poses: &[Pose], pattern: &SensorPattern) -> View<'a> {
        let [forward, left, up] = band.origin;
        let pose_of = |column: usize| if poses.len() == 1 { &poses[0] } else { &poses[column] };
        let middle = pose_of((columns.start + columns.end) / 2);
        let (origin, rotation) = (middle.point(DVec3::new(0.0, 0.0, up)), middle.rotation);
        let still = poses.len() == 1 && forward == 0.0 && left == 0.0;
        let motion = (!still).then(|| {
            let frame = Pose { rotation, translation: origin };
            Motion::new(band, &columns, &frame, pose_of)
        });
        let rounding = f32::EPSILON / 2.0 * band.longest_ray;
        let tolerance = Tolerance { absolute: 2e-3 / band.longest_ray };
        let (min_range, max_range) = (pattern.spec().min_range as f32, pattern.spec().max_range as f32);
        View { band, columns, origin, rotation, rounding, tolerance, min_range, max_range, motion }
    }

    /// The number of columns.
    pub(super) fn width(&self) -> usize {
        self.columns.len()
    }

    /// The start of the rays of a column, their heading in a phase and their up; a ray is heading + slope * up.
    #[inline(always)]
    pub(super) fn ray(&self, phase: usize, column: usize) -> (DVec3, DVec3, DVec3) {
        let Some(motion) = &self.motion else {
            let [cos, sin] = self.band.headings(phase);
            let column = self.columns.start + column;
            return (DVec3::ZERO, DVec3::new(f64::from(cos[column]), f64::from(sin[column]), 0.0), DVec3::Z);
        };
        let vector = |table: &[Vec<f32>; 3], at: usize| {
            DVec3::new(f64::from(table[0][at]), f64::from(table[1][at]), f64::from(table[2][at]))
        };
        let heading = vector(&motion.heading, phase * padded(self.width()) + column);
        (vector(&motion.start, column), heading, vector(&motion.up, column))
    }

    /// Headings of a phase in the columns from `at` on, counted from the view's first.
    #[inline(always)]
    pub(super) fn headings<L: Lanes>(&self, phase: usize, at: usize) -> Vector<L> {
        if let Some(motion) = &self.motion {
            return Vector::load(&motion.heading, phase * padded(self.width()) + at);
        }
        let [cos, sin] = self.band.headings(phase);
        let at = self.columns.start + at;
        Vector::new(L::load(cos, at), L::load(sin, at), L::splat(0.0))
    }
}

impl View<'_> {
    /// The headings of rays in these rows and columns, counted from the view's first.
    #[inline(always)]
    pub(super) fn heading_at<L: Lanes>(&self, row: L, column: L) -> Vector<L> {
        let phase = if self.band.phase_count == 1 { L::splat(0.0) } else { row.gather(&self.band.phase_lanes) };
        if let Some(motion) = &self.motion {
            return Vector::gather(&motion.heading, phase.mul_add(L::splat(padded(self.width()) as f32), column));
        }
        let [cos, sin] = &self.band.headings;
        let long = L::splat((cos.len() / self.band.phase_count) as f32);
        let at = phase.mul_add(long, column + L::splat(self.columns.start as f32));
        Vector::new(at.gather(cos), at.gather(sin), L::splat(0.0))
    }
}

impl Motion {
    /// The rays of the columns from `at` on.
    #[inline(always)]
    pub(super) fn columns<L: Lanes>(&self, at: usize) -> Columns<L> {
        Columns { up: Vector::load(&self.up, at), start: Vector::load(&self.start, at) }
    }

    fn new<'p>(band: &Band, columns: &Range<usize>, frame: &Pose, pose_of: impl Fn(usize) -> &'p Pose) -> Motion {
        let padded = padded(columns.len());
        let mut motion = Motion {
            heading: [(); 3].map(|()| Vec::with_capacity(band.phase_count * padded)),
            up: [(); 3].map(|()| Vec::with_capacity(padded)),
            start: [(); 3].map(|()| Vec::with_capacity(padded)),
            shift: 0.0,
            twist: 0.0,
        };
        let [forward, left, up] = band.origin;
        let into_frame = frame.rotation.transpose();
        let all = || (columns.start..columns.start + padded).map(|column| column.min(columns.end - 1));
        let heading = |phase: usize, column: usize| {
            let [cos, sin] = band.headings(phase);
            into_frame * (pose_of(column).rotation * DVec3::new(f64::from(cos[column]), f64::from(sin[column]), 0.0))
        };
        for (phase, column) in (0..band.phase_count).flat_map(|phase| all().map(move |column| (phase, column))) {
            push(&mut motion.heading, heading(phase, column));
        }
        for column in all() {
            let pose = pose_of(column);
            let turn = into_frame * pose.rotation;
            // Phases differ only if all rays start on the axis.
            let heading = heading(0, column);
            let side = turn.z_axis.cross(heading);
            let center = into_frame * (pose.translation - frame.translation);
            let start = center + heading * forward + side * left + turn.z_axis * up;
            push(&mut motion.up, turn.z_axis);
            push(&mut motion.start, start);
            // The same for all columns if they differ by their azimuth only, so that it does not depend on the cut.
            let middle = center + turn.z_axis * up;
            motion.shift = motion.shift.max((middle.length() + forward.hypot(left)) as f32 * 1.001);
            // The largest shift of a point at distance 1 by a rotation: at most the Frobenius norm of the change.
            let moved = turn - DMat3::IDENTITY;
            let norm = moved.x_axis.length_squared() + moved.y_axis.length_squared() + moved.z_axis.length_squared();
            motion.twist = motion.twist.max(norm.sqrt() as f32 * 1.001);
        }
        motion
    }
}

fn push(table: &mut [Vec<f32>; 3], vector: DVec3) {
    table.iter_mut().zip(vector.to_array()).for_each(|(table, x)| table.push(x as f32));
}
