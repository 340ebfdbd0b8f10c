//! Scenes and sensor patterns in the form of the scan kernel: columns of numbers, padded to whole vectors.

mod aabb_table;
mod band;
mod body_table;
mod meshlets;
mod obb_table;
mod row_lookup;

pub(crate) use aabb_table::AabbTable;
pub(crate) use band::{Band, PHASES, padded};
pub(crate) use body_table::BodyTable;
pub(crate) use meshlets::{GROUP_SIZE, LargeTriangle, Meshlets};
pub(crate) use obb_table::{Obb, ObbTable, Outline};
