//! The reference of all faster backends: every ray through the hierarchies of the scene, in f64.

use glam::DVec3;

use crate::image::Return;
use crate::medium::ScanKey;
use crate::threads::spread;
use crate::{FreePathKey, ImagesMut, Pose, Scene, SensorPattern};

/// The closest return of every ray, one ray at a time; rows are spread over threads.
pub(super) fn scan(
    scene: &Scene,
    pattern: &SensorPattern,
    poses: &[Pose],
    seed: u64,
    images: &mut ImagesMut<'_>,
    threads: usize,
) {
    let key = scan_key(scene, pattern, poses, seed);
    let rows = images.pieces(pattern.columns()).into_iter().enumerate().collect();
    spread(threads, rows, |(row, mut pixels): (usize, ImagesMut<'_>)| {
        for column in 0..pattern.columns() {
            pixels.set(column, cast_pixel(scene, pattern, poses, &key, [row, column]).as_ref());
        }
    });
}

/// The return of one pixel. A surface nearer than the minimum range is not reported, but occludes others.
pub(super) fn cast_pixel(
    scene: &Scene,
    pattern: &SensorPattern,
    poses: &[Pose],
    key: &ScanKey,
    [row, column]: [usize; 2],
) -> Option<Return> {
    let (origin, direction) = ray(pattern, poses, row, column);
    let key = FreePathKey { scan: *key, row: pattern.spec().row_key(row), column };
    let hit = scene.closest(origin, direction, key)?;
    let depth = pattern.reported(hit.distance)?;
    Some(Return::new(scene, origin, direction, &hit, depth))
}

/// The key of the free paths of a scan.
pub(super) fn scan_key(scene: &Scene, pattern: &SensorPattern, poses: &[Pose], seed: u64) -> ScanKey {
    ScanKey::new(seed, pattern.spec().column_width(), poses[0].translation - scene.origin())
}

/// The origin and direction of a pixel's ray in the world; `poses` are one, or one for each column.
fn ray(pattern: &SensorPattern, poses: &[Pose], row: usize, column: usize) -> (DVec3, DVec3) {
    let pose = &poses[if poses.len() == 1 { 0 } else { column }];
    (pose.point(pattern.origin(row, column)), pose.vector(pattern.direction(row, column)))
}
