//! Scenes of semantic shapes, cast by LiDAR sensor patterns.
//!
//! A [`Scene`] holds boxes, ellipsoids, cylinders, rectangles and triangle meshes, each with a class and an instance,
//! solid or filled with a medium. A [`SensorPattern`] gives the ray of every pixel of a scan. [`scan`] casts the
//! pattern from a [`Pose`] and
//! returns [`Images`]: distance, class, instance, primitive and incidence of the closest surface of every pixel.
//!
//! Metres and radians, f64 inside; frames are right-handed with x forward, y left and z up.
//!
//! ```
//! use lidardraft_core::{Images, Pose, Primitive, Scene, SensorPattern, SensorSpec, Shape, scan};
//!
//! let ground = Primitive {
//!     shape: Shape::Plane,
//!     center: [0.0, 0.0, -2.0],
//!     size: [100.0, 100.0, 0.0],
//!     yaw: 0.0,
//!     label: 40,
//!     instance: 0,
//!     extinction: None,
//! };
//! let scene = Scene::new(vec![ground])?;
//! let pattern = SensorPattern::new(SensorSpec {
//!     elevations: vec![0.1, -std::f64::consts::FRAC_PI_6],
//!     azimuth_offsets: vec![0.0; 2],
//!     origins: vec![[0.0; 3]; 2],
//!     columns: 360,
//!     azimuth_start: std::f64::consts::PI,
//!     azimuth_span: std::f64::consts::TAU,
//!     min_range: 0.5,
//!     max_range: 120.0,
//! })?;
//! let mut images = Images::new(pattern.rows(), pattern.columns());
//! scan(&scene, &pattern, &[Pose::IDENTITY], 0, &mut images.as_mut(), None, 0)?;
//! assert_eq!(images.depth[0], 0.0); // the upper beam sees the sky
//! assert!((images.depth[360] - 4.0).abs() < 1e-6); // 2 m below, at 30 degrees
//! assert_eq!(images.label[360], 40);
//! # Ok::<(), lidardraft_core::Error>(())
//! ```

mod backend;
mod body;
mod bounds;
mod bvh;
mod cast;
pub mod cloud;
mod error;
mod image;
pub mod intersect;
mod medium;
mod mesh;
mod obj;
mod packed;
mod pose;
mod primitive;
mod primitive_tables;
mod projection;
mod relief;
mod scan;
mod scene;
pub mod sensor_model;
mod sensor_pattern;
mod sensor_spec;
mod simd;
#[cfg(test)]
mod tests;
mod threads;

pub use backend::Backend;
pub use bounds::Bounds;
pub use cast::{Hits, cast};
pub use error::{Error, Result};
pub use image::{Images, ImagesMut};
pub use medium::FreePathKey;
pub use mesh::TriangleMesh;
pub use obj::{ObjMesh, read_obj};
pub use pose::Pose;
pub use primitive::{Primitive, Shape};
pub use primitive_tables::PrimitiveTables;
pub use projection::Projection;
pub use relief::Relief;
pub use scan::{scan, scan_batch};
pub use scene::{Scene, SceneHit};
pub use sensor_pattern::SensorPattern;
pub use sensor_spec::SensorSpec;
