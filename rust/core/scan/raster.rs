//! The fast path: a scan as views that are painted.
//!
//! All rays of a scan start close together and lie on a grid, so it is not a walk through a hierarchy for every ray but a
//! picture in angles: bodies are bounded, sorted by distance and drawn on the pixels they may cover. What f32 cannot decide,
//! some pixels in a scan, is cast anew by the [`reference`], so that both agree on every hit.

use std::cell::RefCell;
use std::ops::Range;

use super::incidence::Faces;
use super::paint::Painter;
use super::reference;
use super::resolve::{Doubts, Owners};
use super::view::View;
use crate::packed::Band;
use crate::simd::{self, Kernel, Lanes, WIDEST};
use crate::threads::spread;
use crate::{Backend, ImagesMut, Pose, Scene, SensorPattern};

/// The columns that share bounds when each has a pose of its own, at most and at least: by how far the sensor moves
/// meanwhile [m], and the fewest if it turns.
const ROLLING: usize = 256;
const TURNING: usize = 64;
const MOVING: f64 = 0.3;
/// A thread is not woken for fewer columns.
const FEWEST: usize = 128;
/// More pixels than this, of 8 bytes each, leave the second fastest cache of many processors.
const MOST: usize = 1 << 16;

/// A view to be painted, and where to.
struct Job<'a> {
    band: &'a Band,
    columns: Range<usize>,
    /// The rows of the band, in these columns.
    images: Vec<ImagesMut<'a>>,
}

/// What all views of a scan share.
struct Scan<'a> {
    scene: &'a Scene,
    pattern: &'a SensorPattern,
    /// From the world, and from the origin of the scene.
    poses: &'a [Pose],
    local: Vec<Pose>,
    seed: u64,
    backend: Backend,
}

/// Casts a scan as views: bands of rows, cut into stretches of columns.
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
    let scan = Scan { scene, pattern, poses, local: poses.iter().map(local).collect(), seed, backend };
    let width = if poses.len() > 1 { rolling(poses) } else { stretch(pattern, threads) };
    spread(threads, jobs(pattern, images, width), |job| scan.run(job));
}

/// How many columns are painted at once: those of a thread, but no more than stay in its cache.
fn stretch(pattern: &SensorPattern, threads: usize) -> usize {
    let threads = if threads == 0 { rayon::current_num_threads() } else { threads };
    let parts = threads.max((pattern.rows() * pattern.columns()).div_ceil(MOST));
    pattern.columns().div_ceil(parts).next_multiple_of(WIDEST).max(FEWEST)
}

/// How many columns are painted at once that have a pose each.
fn rolling(poses: &[Pose]) -> usize {
    let turns = |pair: &[Pose]| !pair[0].rotation.abs_diff_eq(pair[1].rotation, 1e-12);
    let step = poses.windows(2).map(|pair| pair[0].translation.distance(pair[1].translation)).fold(0.0, f64::max);
    if poses.windows(2).any(turns) {
        return TURNING;
    }
    ((MOVING / step.max(1e-9)) as usize / TURNING * TURNING).clamp(TURNING, ROLLING)
}

fn jobs<'a>(pattern: &'a SensorPattern, images: &'a mut ImagesMut<'_>, width: usize) -> Vec<Job<'a>> {
    let mut rows: Vec<Option<ImagesMut<'a>>> = images.pieces(pattern.columns()).into_iter().map(Some).collect();
    let mut jobs = Vec::new();
    for start in (0..pattern.columns()).step_by(width) {
        let columns = start..pattern.columns().min(start + width);
        for band in pattern.bands() {
            // Each row is in one band, and what is right of these columns goes back for the next ones.
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
    static PAINTER: RefCell<Painter> = RefCell::default();
}

/// A view on its way to its images, for vectors of any width.
struct Painting<'s, 'v, 'i> {
    scan: &'s Scan<'s>,
    view: &'v View<'v>,
    painter: &'v mut Painter,
    images: &'v mut [ImagesMut<'i>],
    doubts: &'v mut Doubts,
}

impl Kernel for Painting<'_, '_, '_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Painting { scan, view, painter, images, doubts } = self;
        let (scene, table) = (scan.scene, scan.scene.body_table());
        let surfaces = images.first().is_some_and(|image| image.incidence.is_some() || image.normal.is_some());
        painter.paint::<L>(scene, view, scan.seed, surfaces);
        let owners = Owners { surfaces: surfaces.then_some(table), semantics: scene.semantics() };
        painter.canvas.resolve::<L>(view, &owners, images, doubts);
        if surfaces {
            let mut faces = Faces::new(scene, view);
            for (row, image) in images.iter_mut().enumerate() {
                let ids = &painter.canvas.id[row * painter.canvas.stride..][..view.width()];
                faces.write(row, ids, image);
            }
        }
    }
}

impl Scan<'_> {
    fn run(&self, mut job: Job<'_>) {
        let view = View::new(job.band, job.columns.clone(), &self.local, self.pattern);
        let (mut doubts, images) = (Vec::new(), &mut job.images);
        // Taken, so that a panic leaves no half a view behind.
        let mut painter = PAINTER.take();
        let painting = Painting { scan: self, view: &view, painter: &mut painter, images, doubts: &mut doubts };
        simd::run(self.backend, painting);
        PAINTER.set(painter);
        for (row, column) in doubts {
            let (beam, ray) = (job.band.rows[row] as usize, job.columns.start + column);
            let found = reference::cast_pixel(self.scene, self.pattern, self.poses, self.seed, [beam, ray]);
            job.images[row].set(column, found.as_ref());
        }
    }
}
