//! The fast path: a scan cut into views, each of which is rasterized.
//!
//! All rays of a scan start close together and lie on a grid, so it is not a walk through a hierarchy for every ray but a
//! picture in angles: bodies are bounded, sorted by distance and rasterized on the pixels they may cover. What f32 cannot
//! resolve, some pixels in a scan, is cast anew by the [`reference`], so that both agree on every hit.

use std::cell::RefCell;
use std::ops::Range;

use super::incidence::IncidenceWriter;
use super::rasterizer::Rasterizer;
use super::reference;
use super::view::View;
use super::visibility_buffer::VisibilityBuffer;
use super::write_images::{Owners, Unresolved};
use crate::medium::ScanKey;
use crate::packed::Band;
use crate::simd::{self, Kernel, Lanes, WIDEST};
use crate::threads::{spread, thread_count};
use crate::{Backend, ImagesMut, Pose, Scene, SensorPattern};

/// The most columns that share bounds if each has its own pose, and the fewest, which apply if the sensor turns.
const MOST_ROLLING: usize = 256;
const FEWEST_ROLLING: usize = 64;
/// Between those, as many as the sensor takes to move this far [m].
const ROLLING_DISTANCE: f64 = 0.3;
/// The fewest columns for another thread.
const FEWEST_COLUMNS: usize = 128;
/// More pixels than this, of 8 bytes each, leave the second fastest cache of many processors.
const MOST_PIXELS: usize = 1 << 16;

/// A view to be rasterized, and its images.
struct Job<'a> {
    band: &'a Band,
    columns: Range<usize>,
    /// The rows of the band, in these columns.
    images: Vec<ImagesMut<'a>>,
}

/// The properties shared by all views of a scan.
struct Scan<'a> {
    scene: &'a Scene,
    pattern: &'a SensorPattern,
    /// From the world, and from the origin of the scene.
    poses: &'a [Pose],
    local: Vec<Pose>,
    key: ScanKey,
    backend: Backend,
}

/// Casts a scan as views: bands of rows over some of the columns.
pub(super) fn scan(
    scene: &Scene,
    pattern: &SensorPattern,
    poses: &[Pose],
    seed: u64,
    images: &mut ImagesMut<'_>,
    backend: Backend,
    threads: usize,
) {
    let local = |pose: &Pose| Pose { translation: pose.translation - scene.origin(), ..*pose };
    let key = reference::scan_key(scene, pattern, poses, seed);
    let scan = Scan { scene, pattern, poses, local: poses.iter().map(local).collect(), key, backend };
    let width = if poses.len() > 1 { rolling_width(poses) } else { still_width(pattern, threads) };
    spread(threads, jobs(pattern, images, width), |job| scan.run(job));
}

/// The number of columns rasterized at once: those of a thread, but no more than stay in its cache.
fn still_width(pattern: &SensorPattern, threads: usize) -> usize {
    let parts = thread_count(threads).max((pattern.rows() * pattern.columns()).div_ceil(MOST_PIXELS));
    pattern.columns().div_ceil(parts).next_multiple_of(WIDEST).max(FEWEST_COLUMNS)
}

/// The number of columns rasterized at once if each has its own pose.
fn rolling_width(poses: &[Pose]) -> usize {
    let turns = |pair: &[Pose]| !pair[0].rotation.abs_diff_eq(pair[1].rotation, 1e-12);
    let step = poses.windows(2).map(|pair| pair[0].translation.distance(pair[1].translation)).fold(0.0, f64::max);
    if poses.windows(2).any(turns) {
        return FEWEST_ROLLING;
    }
    ((ROLLING_DISTANCE / step.max(1e-9)) as usize / FEWEST_ROLLING * FEWEST_ROLLING).clamp(FEWEST_ROLLING, MOST_ROLLING)
}

fn jobs<'a>(pattern: &'a SensorPattern, images: &'a mut ImagesMut<'_>, width: usize) -> Vec<Job<'a>> {
    let mut rows: Vec<Option<ImagesMut<'a>>> = images.pieces(pattern.columns()).into_iter().map(Some).collect();
    let mut jobs = Vec::new();
    for start in (0..pattern.columns()).step_by(width) {
        let columns = start..pattern.columns().min(start + width);
        for band in pattern.bands() {
            // Each row is in one band, and the rest to the right of these columns goes back for the next ones.
            let cut = |&row: &u32| {
                let (left, right) = rows[row as usize].take()?.split_at(columns.len());
                rows[row as usize] = Some(right);
                Some(left)
            };
            jobs.push(Job { band, columns: columns.clone(), images: band.rows.iter().filter_map(cut).collect() });
        }
    }
    jobs
}

thread_local! {
    static RASTERIZER: RefCell<Rasterizer> = RefCell::default();
}

/// The first half of a job, for vectors of any width: a scene onto the pixels of a view.
struct RasterizeView<'a> {
    scan: &'a Scan<'a>,
    view: &'a View<'a>,
    surfaces: bool,
    rasterizer: &'a mut Rasterizer,
}

impl Kernel for RasterizeView<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.rasterizer.rasterize::<L>(self.scan.scene, self.view, &self.scan.key, self.surfaces);
    }
}

/// The second half: those pixels into images.
struct WriteView<'a, 'i> {
    scene: &'a Scene,
    view: &'a View<'a>,
    surfaces: bool,
    buffer: &'a mut VisibilityBuffer,
    images: &'a mut [ImagesMut<'i>],
    unresolved: &'a mut Unresolved,
}

impl Kernel for WriteView<'_, '_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let WriteView { scene, view, surfaces, buffer, images, unresolved } = self;
        let owners = Owners { surfaces: surfaces.then_some(scene.body_table()), semantics: scene.semantics() };
        buffer.write_images::<L>(view, &owners, images, unresolved);
        if surfaces {
            let mut incidence = IncidenceWriter::new(scene, view);
            for (row, image) in images.iter_mut().enumerate() {
                let ids = &buffer.id[row * buffer.stride..][..buffer.stride];
                incidence.write::<L>(row, ids, image);
            }
        }
    }
}

impl Scan<'_> {
    fn run(&self, mut job: Job<'_>) {
        let (scene, images) = (self.scene, &mut job.images);
        let view = View::new(job.band, job.columns.clone(), &self.local, self.pattern);
        let surfaces = images.first().is_some_and(|image| image.incidence.is_some() || image.normal.is_some());
        let mut unresolved = Vec::new();
        // Taken, so that a panic leaves no half of a view behind.
        let mut rasterizer = RASTERIZER.take();
        simd::run(self.backend, RasterizeView { scan: self, view: &view, surfaces, rasterizer: &mut rasterizer });
        let (buffer, view) = (&mut rasterizer.buffer, &view);
        simd::run(self.backend, WriteView { scene, view, surfaces, buffer, images, unresolved: &mut unresolved });
        RASTERIZER.set(rasterizer);
        for (row, column) in unresolved {
            let (beam, ray) = (job.band.rows[row] as usize, job.columns.start + column);
            let found = reference::cast_pixel(scene, self.pattern, self.poses, &self.key, [beam, ray]);
            job.images[row].set(column, found.as_ref());
        }
    }
}
