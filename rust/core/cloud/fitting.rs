//! Boxes and crowns around points.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::Shape;
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Ray};

/// The least extent of a box [m].
const MIN_EXTENT: f64 = 0.1;
/// The least extent of a crown [m].
const MIN_CROWN: f64 = 0.3;
/// Closer to an edge than this [m] counts as on it.
const NOISE: f32 = 0.05;
/// The most points for the heading of a box.
const SAMPLE: usize = 200;
/// Tried headings, one a degree.
const HEADINGS: usize = 90;

/// An upright box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedBox {
    /// Its middle [m].
    pub center: DVec3,
    /// Its extents along its yaw, across and up [m].
    pub size: DVec3,
    /// Its turn about z [rad].
    pub yaw: f64,
}

impl FittedBox {
    /// Its middle, extents and yaw as one row.
    pub fn row(&self) -> [f64; 7] {
        let [(x, y, z), (length, width, height)] = [self.center, self.size].map(Into::into);
        [x, y, z, length, width, height, self.yaw]
    }

    /// The box of a row.
    pub fn from_row(&[x, y, z, length, width, height, yaw]: &[f64; 7]) -> FittedBox {
        FittedBox { center: DVec3::new(x, y, z), size: DVec3::new(length, width, height), yaw }
    }

    /// The map from points into the frame of the box, with its middle at the origin.
    pub(super) fn local(&self) -> impl Fn(DVec3) -> DVec3 {
        let (center, along) = (self.center, DVec2::from_angle(self.yaw));
        move |point| back(along, (point - center).truncate()).extend(point.z - center.z)
    }

    /// The shape that fills the box, for rays from one place. Planes and meshes count as their boxes.
    pub(super) fn target(&self, shape: &Shape, origin: DVec3) -> Target {
        let scale = 2.0 / self.size;
        let origin = self.local()(origin) * scale;
        Target { shape: shape.clone(), origin, along: DVec2::from_angle(self.yaw), scale }
    }
}

/// A shape for queries of rays from one place. It is as wide as the unit ball in its own frame.
pub(super) struct Target {
    shape: Shape,
    /// The start of the rays, in its frame.
    origin: DVec3,
    along: DVec2,
    scale: DVec3,
}

impl Target {
    /// The distance to it along a ray in a direction.
    pub(super) fn distance(&self, direction: DVec3) -> Option<f64> {
        let direction = back(self.along, direction.truncate()).extend(direction.z) * self.scale;
        let ray = Ray { origin: self.origin, direction };
        match self.shape {
            Shape::Ellipsoid => Ellipsoid { radii: DVec3::ONE }.intersect(&ray, 0.0),
            Shape::Cylinder => Cylinder { half: DVec3::ONE }.intersect(&ray, 0.0),
            _ => Cuboid { half: DVec3::ONE }.intersect(&ray, 0.0),
        }
    }
}

/// The box whose sides fit points most closely, by search over its heading, -90 to 90 degrees. `outliers` are the
/// shares of the points at either end of an extent that are strays.
///
/// Closeness criterion of Zhang et al., "Efficient L-Shape Fitting for Vehicle Detection Using Laser Scanners", IV 2017.
pub fn fit_box(points: &[DVec3], outliers: f64) -> FittedBox {
    let yaw = heading(points);
    let along = DVec2::from_angle(yaw);
    let frame = |point: &DVec3| back(along, point.truncate()).extend(point.z);
    let (low, high) = extents(points.iter().map(frame), [outliers; 3]);
    let middle = (low + high) / 2.0;
    let center = along.rotate(middle.truncate()).extend(middle.z);
    FittedBox { center, size: (high - low).max(DVec3::splat(MIN_EXTENT)), yaw }
}

/// The box of the ellipsoid of the points' apparent size, around the middle half of them along the line of sight.
///
/// Rays pass through foliage: its points are scattered behind the side that faces the sensor.
pub(super) fn fit_crown(points: &[DVec3]) -> FittedBox {
    let mean = points.iter().map(|p| p.truncate()).sum::<DVec2>() / points.len() as f64;
    let away = mean / mean.length().max(1e-6);
    let frame = |point: &DVec3| back(away, point.truncate()).extend(point.z);
    let (low, high) = extents(points.iter().map(frame), [0.25, 0.02, 0.02]);
    let middle = (low + high) / 2.0;
    // An ellipse this much larger than the rectangle around it has the same area.
    let wider = (4.0 / PI).sqrt();
    let size = ((high - low) * DVec3::new(1.0, wider, wider)).max(DVec3::splat(MIN_CROWN));
    FittedBox { center: away.rotate(middle.truncate()).extend(middle.z), size, yaw: away.to_angle() }
}

/// A vector relative to an axis of length 1.
fn back(axis: DVec2, vector: DVec2) -> DVec2 {
    DVec2::new(axis.dot(vector), axis.perp_dot(vector))
}

/// The ends of points along each axis, without the shares `outliers` at either end.
fn extents(points: impl Iterator<Item = DVec3> + Clone, outliers: [f64; 3]) -> (DVec3, DVec3) {
    let ends = [0, 1, 2].map(|axis| {
        let mut values: Vec<f64> = points.clone().map(|point| point[axis]).collect();
        [outliers[axis], 1.0 - outliers[axis]].map(|share| quantile(&mut values, share))
    });
    (DVec3::from(ends.map(|[low, _]| low)), DVec3::from(ends.map(|[_, high]| high)))
}

/// A quantile, interpolated between the two nearest values.
pub(super) fn quantile(values: &mut [f64], share: f64) -> f64 {
    let at = (values.len() - 1) as f64 * share;
    let (_, &mut below, rest) = values.select_nth_unstable_by(at as usize, f64::total_cmp);
    let above = rest.iter().copied().min_by(f64::total_cmp).unwrap_or(below);
    below + (at - at.floor()) * (above - below)
}

/// The heading [rad], 0 to 90 degrees, of the box whose sides fit points most closely.
fn heading(points: &[DVec3]) -> f64 {
    let sample = || points.iter().step_by(points.len().div_ceil(SAMPLE)).map(|p| (*p - points[0]).as_vec3());
    let (mut cos, mut sin) = ([0.0_f32; HEADINGS], [0.0_f32; HEADINGS]);
    for degrees in 0..HEADINGS {
        let (s, c) = (degrees as f32).to_radians().sin_cos();
        (cos[degrees], sin[degrees]) = (c, s);
    }
    // Loops over headings of each point, and not over points of each heading: the compiler vectorises these.
    let mut along = Ends::default();
    let mut across = Ends::default();
    let mut count = 0.0;
    for point in sample() {
        count += 1.0;
        for k in 0..HEADINGS {
            along.add(k, cos[k] * point.x + sin[k] * point.y);
            across.add(k, cos[k] * point.y - sin[k] * point.x);
        }
    }
    let (along, across) = (along.closer(count), across.closer(count));
    let mut closeness = [0.0_f32; HEADINGS];
    for point in sample() {
        for k in 0..HEADINGS {
            let ahead = along.0[k] + along.1[k] * (cos[k] * point.x + sin[k] * point.y);
            let aside = across.0[k] + across.1[k] * (cos[k] * point.y - sin[k] * point.x);
            let nearest = if ahead < aside { ahead } else { aside };
            closeness[k] += 1.0 / if nearest > NOISE { nearest } else { NOISE };
        }
    }
    let best = (0..HEADINGS).rev().max_by(|&a, &b| closeness[a].total_cmp(&closeness[b]));
    (best.unwrap_or_default() as f64).to_radians()
}

/// The least, the greatest and the sum of the positions of points, for each heading.
struct Ends([f32; HEADINGS], [f32; HEADINGS], [f32; HEADINGS]);

impl Default for Ends {
    fn default() -> Self {
        Ends([f32::INFINITY; HEADINGS], [f32::NEG_INFINITY; HEADINGS], [0.0; HEADINGS])
    }
}

impl Ends {
    fn add(&mut self, heading: usize, position: f32) {
        let Ends(low, high, sum) = self;
        low[heading] = if position < low[heading] { position } else { low[heading] };
        high[heading] = if position > high[heading] { position } else { high[heading] };
        sum[heading] += position;
    }

    /// Offset and sign for each heading: `offset + sign * position` is the distance to the closer end.
    fn closer(&self, count: f32) -> ([f32; HEADINGS], [f32; HEADINGS]) {
        let Ends(low, high, sum) = self;
        let (mut offset, mut sign) = ([0.0; HEADINGS], [1.0; HEADINGS]);
        for k in 0..HEADINGS {
            let to_high = 2.0 * sum[k] > count * (low[k] + high[k]);
            (offset[k], sign[k]) = if to_high { (high[k], -1.0) } else { (-low[k], 1.0) };
        }
        (offset, sign)
    }
}
