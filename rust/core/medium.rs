//! Media: how far a ray travels in a crown, a hedge or a fence before it meets a leaf, a blade or a wire.
//!
//! The free path in a medium of extinction k is exponential with mean 1 / k: Beer and Lambert's law. Here it is counted in
//! mean free paths, and is a pure function of seed, medium and ray.
//!
//! Leaves hang in clumps, so rays that pass near each other have similar free paths. In recorded foliage (PandaSet)
//! ranges differ by 6 cm (median) between rays 3 cm apart, by 13 cm at 12 cm and by 42 cm at half a metre. So each ray
//! gets one of [`QUANTILES`] quantiles of the distribution, read from two random **walks** round them, one along each
//! diagonal of the scan (a sum of such bands is a random field: Matheron, "The intrinsic random functions", 1973). The
//! steps are wider the further apart the rays are at the medium, in mean free paths. Rays without neighbours get
//! independent quantiles. Ranks are whole numbers, so that all backends have the same bits, in tables that a vector of
//! columns can load.

use std::sync::OnceLock;

use glam::DVec3;

use crate::simd::WIDEST;

/// The number of different free paths, and the length of a walk.
pub(crate) const QUANTILES: usize = 1 << 12;
/// The distance of rays with independent quantiles, in mean free paths (fitted to PandaSet's foliage), and the number
/// of its halvings: half the distance, half the variance.
const INDEPENDENT: f64 = 3.0;
const HALVINGS: usize = 8;
/// The share of rays that single leaves stop, independently of their neighbours.
const LEAVES: f64 = 0.2;
/// The least distance of media in the formula of steps [m].
const NEAREST: f64 = 1.0;

/// The key of the free paths in media of all rays of a scan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScanKey {
    seed: u64,
    /// The width of a column [rad], infinite if rays have no neighbours.
    width: f64,
    /// The start of the scan, in the scene's frame.
    origin: DVec3,
}

impl ScanKey {
    /// The key of a scan with columns of that width [rad] and that start in the scene's frame.
    pub(crate) fn new(seed: u64, width: f64, origin: DVec3) -> ScanKey {
        ScanKey { seed, width, origin }
    }

    /// The free paths within the medium of that number and extinction [1/m], with its center in the scene's frame.
    pub(crate) fn free_paths(&self, medium: u32, extinction: f64, center: DVec3) -> FreePaths {
        // In a medium around the sensor, no leaf is nearer.
        FreePaths::new(self.seed, medium, self.width * self.origin.distance(center).max(NEAREST) * extinction)
    }
}

/// The key of the free paths of a ray in media: equal keys, equal paths.
#[derive(Clone, Copy, Debug)]
pub struct FreePathKey {
    pub(crate) scan: ScanKey,
    pub(crate) row: RowKey,
    pub(crate) column: usize,
}

impl FreePathKey {
    /// The key of a ray by its number, which has no neighbours.
    pub fn of_ray(seed: u64, ray: usize) -> FreePathKey {
        let scan = ScanKey { seed, width: f64::INFINITY, origin: DVec3::ZERO };
        let number = (ray / QUANTILES) as u32;
        FreePathKey { scan, row: RowKey { number, diagonals: [0, number as i32] }, column: ray % QUANTILES }
    }

    /// The free path within a medium in mean free paths, see [`ScanKey::free_paths`].
    pub(crate) fn path(&self, medium: u32, extinction: f64, center: DVec3) -> f32 {
        self.scan.free_paths(medium, extinction, center).at(self.row, self.column)
    }
}

/// A row of a scan: its number, and its place on the two diagonals, in widths of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RowKey {
    number: u32,
    diagonals: [i32; 2],
}

impl RowKey {
    /// A row by its angles [rad]. Sub-rays of a beam are nearer to each other than columns; they differ by a column in
    /// proportion to their distance.
    pub(crate) fn new(row: usize, elevation: f64, azimuth_offset: f64, width: f64) -> RowKey {
        let (up, left) =
            ((elevation / width + share(row as u64)).floor() as i32, (azimuth_offset / width).round() as i32);
        let diagonals = [up.wrapping_sub(left), up.wrapping_neg().wrapping_sub(left)];
        RowKey { number: row as u32, diagonals }
    }
}

/// The free paths of the rays of a scan within one medium.
#[derive(Clone, Copy)]
pub(crate) struct FreePaths {
    hash: u64,
    /// The quantile at which the walks begin.
    start: f32,
    walks: &'static [Vec<f32>; 2],
    tables: &'static Tables,
}

struct Tables {
    /// Two walks for rays that are [`INDEPENDENT`] apart, for half of that, and so on.
    walks: Vec<[Vec<f32>; 2]>,
    /// The addends by single leaves for both: mostly 0, or any number of quantiles.
    leaves: Vec<f32>,
    /// -ln(1 - p) in the middle of each of QUANTILES equal steps of p, as often as there are addends.
    quantiles: Vec<f32>,
}

impl FreePaths {
    /// The free paths within the medium of that number, with neighbouring columns `apart` mean free paths apart.
    pub(crate) fn new(seed: u64, medium: u32, apart: f64) -> FreePaths {
        let hash = mix(mix(seed) ^ u64::from(medium));
        let halvings = (INDEPENDENT / apart).log2().round().clamp(0.0, HALVINGS as f64) as usize;
        let (tables, start) = (tables(), (mix(hash) % QUANTILES as u64) as f32);
        FreePaths { hash, start, walks: &tables.walks[halvings], tables }
    }

    /// The path of one column, in mean free paths.
    pub(crate) fn at(&self, row: RowKey, column: usize) -> f32 {
        let [a, b, leaves] = self.ranks(row, column);
        self.tables.quantiles[(a[0] + b[0] + leaves[0] + self.start) as usize]
    }

    /// Three addends of the number of the quantile, for a vector of columns from this one on; `start` is the fourth.
    pub(crate) fn ranks(&self, row: RowKey, column: usize) -> [&'static [f32]; 3] {
        let ([a, b], offsets) = (self.walks, [self.hash as u32, (self.hash >> 32) as u32]);
        let walked = |k: usize| offsets[k].wrapping_add_signed(row.diagonals[k]) as usize;
        let leaf = mix(self.hash ^ u64::from(row.number)) as u32 as usize;
        let from = |table: &'static Vec<f32>, offset: usize| &table[(offset + column) % QUANTILES..];
        [from(a, walked(0)), from(b, walked(1)), from(&self.tables.leaves, leaf)]
    }

    /// See [`FreePaths::ranks`].
    pub(crate) fn start(&self) -> f32 {
        self.start
    }

    /// The paths, shortest first, in mean free paths; again and again for sums of ranks.
    pub(crate) fn quantiles(&self) -> &'static [f32] {
        &self.tables.quantiles
    }
}

fn tables() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    TABLES.get_or_init(|| Tables {
        walks: (0..=HALVINGS).map(|halvings| [1, 2].map(|seed| walk(seed, halvings))).collect(),
        leaves: padded(
            (0..QUANTILES as u64).map(|k| if share(4 << 32 | k) < LEAVES { rank(share(3 << 32 | k)) } else { 0.0 }),
        ),
        quantiles: (0..QUANTILES)
            .map(|k| -((QUANTILES - k) as f64 - 0.5).ln() + (QUANTILES as f64).ln())
            .map(|x| x as f32)
            .collect::<Vec<f32>>()
            .repeat(4),
    })
}

/// A random walk round the quantiles that ends at its start. Its steps are uniform up to a span, which is all quantiles
/// without a halving.
fn walk(seed: u64, halvings: usize) -> Vec<f32> {
    let span = 0.5_f64.powf(halvings as f64 / 2.0);
    let step = |k: usize| span * (share(seed << 32 | k as u64) - 0.5);
    let mut places: Vec<f64> = (0..=QUANTILES).scan(0.0, |at, k| Some(std::mem::replace(at, *at + step(k)))).collect();
    let end = places.pop().unwrap_or_default();
    let drift = (end - end.round()) / QUANTILES as f64;
    padded(places.iter().enumerate().map(|(k, at)| rank((at - drift * k as f64).rem_euclid(1.0))))
}

/// The number of the quantile with that share below it.
fn rank(share: f64) -> f32 {
    (share * QUANTILES as f64).floor().min(QUANTILES as f64 - 1.0) as f32
}

/// A table, with its first entries repeated for a full vector.
fn padded(ranks: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut ranks: Vec<f32> = ranks.collect();
    ranks.extend_from_within(..WIDEST);
    ranks
}

/// A random number of 0 to 1.
fn share(seed: u64) -> f64 {
    mix(seed) as f64 / 2_f64.powi(64)
}

/// A hash of 64 bits: Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014 (SplitMix64).
pub(crate) fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
