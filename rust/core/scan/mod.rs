//! A whole scan: every ray of a sensor pattern, cast from one pose.

use rayon::prelude::*;

use crate::image::RowMut;
use crate::{Images, Pose, Return, Scene, SensorPattern};

/// The closest return of every ray of a pattern, one ray at a time; rows run in parallel.
///
/// A surface nearer than the minimum range is not reported, and hides what is behind it. The images are the same for any
/// number of threads.
pub fn scan(scene: &Scene, pattern: &SensorPattern, world_from_sensor: &Pose) -> Images {
    let mut images = Images::new(pattern.rows(), pattern.columns());
    images
        .par_rows_mut()
        .enumerate()
        .for_each(|(row, mut pixels)| cast_row(scene, pattern, world_from_sensor, row, &mut pixels));
    images
}

fn cast_row(scene: &Scene, pattern: &SensorPattern, pose: &Pose, row: usize, pixels: &mut RowMut<'_>) {
    let origin = pose.point(pattern.origin(row));
    for column in 0..pattern.columns() {
        let direction = pose.vector(pattern.direction(row, column));
        let Some(found) = scene.closest(origin, direction) else {
            continue;
        };
        let Some(depth) = pattern.reported(found.hit.distance) else {
            continue;
        };
        let cosine = found.hit.normal.dot(direction).abs() / direction.length();
        pixels.set(
            column,
            Return {
                depth,
                label: found.label,
                instance: found.instance,
                primitive: found.primitive as i32,
                incidence: cosine.min(1.0) as f32,
            },
        );
    }
}
