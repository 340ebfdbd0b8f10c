//! Whole scans: every ray of a sensor pattern, cast from one pose, or from one pose for each column.

mod incidence;
mod jobs;
mod pixel_bounds;
mod pixel_rect;
mod rasterize_medium;
mod rasterize_mesh;
mod rasterize_shape;
mod rasterize_solid;
mod rasterizer;
mod ray_tests;
mod reference;
mod small_triangles;
mod triangle_bounds;
mod view;
mod visibility_buffer;
mod write_images;

use crate::threads::{spread, thread_count};
use crate::{Backend, Error, ImagesMut, Pose, Result, Scene, SensorPattern};

/// Casts a scan: the closest return of every ray of a pattern.
///
/// `poses` are world_from_sensor: one, or one for each column (rolling shutter). `seed` decides the free paths of rays
/// in media: a pure function of seed, primitive, its distance, row and column. A surface nearer than the minimum range
/// is not reported, but occludes others. `backend` is by default the fastest; `threads` 0 is the number of cores. The
/// images are the same for any number of threads.
///
/// # Errors
/// [`Error::PoseCount`] or [`Error::ImageSize`], before anything is written.
pub fn scan(
    scene: &Scene,
    pattern: &SensorPattern,
    poses: &[Pose],
    seed: u64,
    images: &mut ImagesMut<'_>,
    backend: Option<Backend>,
    threads: usize,
) -> Result<()> {
    check(pattern, poses, images)?;
    cast(scene, pattern, poses, seed, images, backend, threads);
    Ok(())
}

/// Casts several scans, one list of poses and one set of images for each; threads take whole scans, or parts of them if
/// there are more threads than scans. Scan k has the seed `seed` + k.
///
/// # Errors
/// [`Error::ScanCount`], [`Error::PoseCount`] or [`Error::ImageSize`], before anything is written.
pub fn scan_batch(
    scene: &Scene,
    pattern: &SensorPattern,
    poses: &[&[Pose]],
    seed: u64,
    images: &mut [ImagesMut<'_>],
    backend: Option<Backend>,
    threads: usize,
) -> Result<()> {
    if poses.len() != images.len() {
        return Err(Error::ScanCount { scans: poses.len(), images: images.len() });
    }
    for (poses, images) in poses.iter().zip(images.iter()) {
        check(pattern, poses, images)?;
    }
    // If whole scans do not occupy all threads, their parts are spread over the same ones.
    let within = if images.len() < thread_count(threads) { threads } else { 1 };
    let scans = poses.iter().zip(images).enumerate().collect();
    spread(threads, scans, |(k, (poses, images)): (usize, (&&[Pose], _))| {
        cast(scene, pattern, poses, seed.wrapping_add(k as u64), images, backend, within);
    });
    Ok(())
}

fn check(pattern: &SensorPattern, poses: &[Pose], images: &ImagesMut<'_>) -> Result<()> {
    let (rows, columns) = (pattern.rows(), pattern.columns());
    if poses.len() != 1 && poses.len() != columns {
        return Err(Error::PoseCount { poses: poses.len(), columns });
    }
    images.check(rows, columns)
}

fn cast(
    scene: &Scene,
    pattern: &SensorPattern,
    poses: &[Pose],
    seed: u64,
    images: &mut ImagesMut<'_>,
    backend: Option<Backend>,
    threads: usize,
) {
    match backend.unwrap_or_else(Backend::fastest) {
        Backend::Reference => reference::scan(scene, pattern, poses, seed, images, threads),
        backend => jobs::scan(scene, pattern, poses, seed, images, backend, threads),
    }
}
