//! Scenes and sensor patterns as the scan kernel reads them: columns of numbers, padded to whole vectors.

mod band;
mod body_table;
mod meshlets;
mod obb_table;

pub(crate) use band::{Band, SWEEPS, padded};
pub(crate) use body_table::BodyTable;
pub(crate) use meshlets::{Blocks, Boxes, Large, SIDE};
pub(crate) use obb_table::{Obb, ObbTable, Outline};
