//! Media: how far a ray travels in a crown, a hedge or a fence before it meets a leaf, a blade or a wire.
//!
//! The free path in a medium of extinction k is exponential with mean 1 / k: Beer and Lambert's law. Here it is counted in
//! mean free paths, and is a pure function of seed, medium, row and column.
//!
//! Every pixel gets one of [`QUANTILES`] quantiles of that distribution. Which one is the sum, modulo their number, of two
//! permutations of them, each read from an offset that is a hash of seed, medium and row, and on from there column by column:
//! tables that a vector of columns can load, and numbers without rounding, so that every way of casting has the same bits.
//! Two rows have the same paths a few columns apart only if both offsets happen to agree, one in 2^28.

use std::sync::OnceLock;

use crate::simd::WIDEST;

/// How many different free paths there are.
pub(crate) const QUANTILES: usize = 1 << 14;

/// What decides the free paths of a ray in media: equal keys, equal paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FreePathKey {
    /// Of the scan.
    pub seed: u64,
    /// The row of the ray.
    pub row: u32,
    /// The column of the ray.
    pub column: u32,
}

impl FreePathKey {
    /// The free path within a medium of that number, in mean free paths.
    pub(crate) fn path(&self, medium: u32) -> f32 {
        FreePaths::new(self.seed, medium, self.row).at(self.column as usize)
    }
}

/// The free paths of a row of rays within one medium.
#[derive(Clone, Copy)]
pub(crate) struct FreePaths {
    offsets: [usize; 2],
    tables: &'static Tables,
}

struct Tables {
    /// Two permutations of 0..QUANTILES, and as many of their first entries again as a vector holds.
    ranks: [Vec<f32>; 2],
    /// -ln(1 - p) in the middle of each of QUANTILES equal steps of p.
    quantiles: Vec<f32>,
}

impl FreePaths {
    pub(crate) fn new(seed: u64, medium: u32, row: u32) -> FreePaths {
        let hash = mix(mix(seed) ^ (u64::from(medium) << 32 | u64::from(row)));
        FreePaths { offsets: [hash as usize, (hash >> 32) as usize], tables: tables() }
    }

    /// The path of one column, in mean free paths.
    pub(crate) fn at(&self, column: usize) -> f32 {
        let [a, b] = self.ranks(column);
        self.quantiles()[(a[0] + b[0]) as usize % QUANTILES]
    }

    /// Two addends of the number of the quantile, for as many columns from this one on as a vector holds.
    pub(crate) fn ranks(&self, column: usize) -> [&'static [f32]; 2] {
        let [a, b] = &self.tables.ranks;
        [&a[(self.offsets[0] + column) % QUANTILES..], &b[(self.offsets[1] + column) % QUANTILES..]]
    }

    /// The paths, shortest first, in mean free paths.
    pub(crate) fn quantiles(&self) -> &'static [f32] {
        &self.tables.quantiles
    }
}

fn tables() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    TABLES.get_or_init(|| Tables {
        ranks: [1, 2].map(permutation),
        quantiles: (0..QUANTILES)
            .map(|k| -((QUANTILES - k) as f64 - 0.5).ln() + (QUANTILES as f64).ln())
            .map(|x| x as f32)
            .collect(),
    })
}

/// A random order of 0..QUANTILES: Fisher and Yates.
fn permutation(seed: u64) -> Vec<f32> {
    let mut ranks: Vec<f32> = (0..QUANTILES).map(|k| k as f32).collect();
    for k in (1..QUANTILES).rev() {
        ranks.swap(k, (mix(seed << 32 | k as u64) % (k as u64 + 1)) as usize);
    }
    ranks.extend_from_within(..WIDEST);
    ranks
}

/// A hash of 64 bits: Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014 (SplitMix64).
pub(crate) fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
