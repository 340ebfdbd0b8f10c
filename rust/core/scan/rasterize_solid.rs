//! Bodies other than meshes onto pixels: by the test for the start of the rays.

use glam::DVec3;

use super::pixel_rect::PixelRect;
use super::rasterize_medium::{Medium, rasterize_medium};
use super::rasterize_shape::{rasterize_shape, rasterize_unresolved};
use super::ray_tests::{self, MediumTest, ShapeFrame, ShapeInView};
use super::view::View;
use super::visibility_buffer::VisibilityBuffer;
use crate::Pose;
use crate::body::Solid;
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Rectangle};
use crate::simd::{Lanes, rows};

/// Rasterizes a body, if f32 can decide its hits by rays from near the view's origin.
#[inline(always)]
pub(super) fn rasterize_solid<L: Lanes>(
    solid: &Solid,
    pose: &Pose,
    (medium, id): (Option<Medium>, u32),
    rect: &PixelRect,
    view: &View,
    buffer: &mut VisibilityBuffer,
) {
    let shift = view.motion.as_ref().map_or(0.0, |motion| f64::from(motion.shift));
    let origin = pose.inverse_point(view.origin);
    let axes = rows(&(pose.rotation.transpose() * view.rotation));
    let frame = |half: DVec3| ShapeFrame {
        axes,
        origin: origin.as_vec3().to_array(),
        half: half.as_vec3().to_array(),
        rounding: view.rounding,
        shift: shift as f32,
    };
    // Whether all rays start beyond the planes of two faces, or all between them.
    let slack = |x: f64, size: f64| 2e-6 * (x.abs() + size) + 4.0 * shift;
    let beyond = |x: f64, size: f64| x.abs() - size > slack(x, size);
    let between = |x: f64, size: f64| size - x.abs() > slack(x, size);
    // Shapes too thin for f32: their scale overflows, or drowns the direction across them.
    let too_thin = |half: DVec3| {
        let thin = half.min_element();
        thin < 1e-4 * half.max_element() || thin < 1e-15 * f64::from(view.band.longest_ray)
    };
    match solid {
        Solid::Cuboid(Cuboid { half }) if half.min_element() < 1e-30 => rasterize_unresolved::<L>(rect, view, buffer),
        Solid::Ellipsoid(Ellipsoid { radii: half }) | Solid::Cylinder(Cylinder { half }) if too_thin(*half) => {
            rasterize_unresolved::<L>(rect, view, buffer);
        }
        Solid::Cuboid(Cuboid { half }) if (0..3).all(|k| between(origin[k], half[k])) => {
            rasterize_either::<L, _>(&ray_tests::Cuboid::<true>(frame(*half)), (medium, id), rect, view, buffer);
        }
        Solid::Cuboid(Cuboid { half }) if (0..3).any(|k| beyond(origin[k], half[k])) => {
            rasterize_either::<L, _>(&ray_tests::Cuboid::<false>(frame(*half)), (medium, id), rect, view, buffer);
        }
        Solid::Ellipsoid(Ellipsoid { radii }) if !touches_unit(origin / *radii, 4.0 * shift / radii.min_element()) => {
            rasterize_either::<L, _>(&ray_tests::Ellipsoid(frame(*radii)), (medium, id), rect, view, buffer);
        }
        Solid::Cylinder(Cylinder { half }) => {
            let across = (origin / *half).with_z(0.0);
            // Rays start over or under it, or in it.
            let known =
                across.length() > 1.0 || beyond(origin.z, half.z) || medium.is_some() && between(origin.z, half.z);
            if known && !touches_unit(across, 4.0 * shift / half.x.min(half.y)) {
                rasterize_either::<L, _>(&ray_tests::Cylinder(frame(*half)), (medium, id), rect, view, buffer);
            } else {
                rasterize_unresolved::<L>(rect, view, buffer);
            }
        }
        Solid::Rectangle(Rectangle { half }) if origin.z.abs() > 1e-6 * half.max_element() + 4.0 * shift => {
            rasterize_shape::<L>(&ray_tests::Rectangle(frame(half.extend(0.0))), id, rect, view, buffer);
        }
        _ => rasterize_unresolved::<L>(rect, view, buffer),
    }
}

/// Rasterizes a shape, solid or a medium.
#[inline(always)]
fn rasterize_either<L: Lanes, S: ShapeInView>(
    shape: &S,
    (medium, id): (Option<Medium>, u32),
    rect: &PixelRect,
    view: &View,
    buffer: &mut VisibilityBuffer,
) where
    S::Test<L>: MediumTest<L>,
{
    match medium {
        Some(medium) => rasterize_medium::<L, S>(shape, medium, id, rect, view, buffer),
        None => rasterize_shape::<L>(shape, id, rect, view, buffer),
    }
}

/// Whether rays may start on the unit ball; near it, roots cancel.
fn touches_unit(start: DVec3, shift: f64) -> bool {
    (start.length() - 1.0).abs() <= 1e-3 + shift
}
