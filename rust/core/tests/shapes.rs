//! Distances and normals in closed form.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::Random;
use crate::body::{Body, MeshBody, Solid};
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Ray, Rectangle, Triangle};
use crate::{Pose, TriangleMesh};

fn vec(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A distance and the normal there.
type Seen = Option<(f64, DVec3)>;

/// A body of full extents `size`, turned about z.
fn body(solid: fn(DVec3) -> Solid, center: DVec3, size: DVec3, yaw: f64) -> Body {
    Body::new(solid(size / 2.0), Pose { rotation: DMat3::from_rotation_z(yaw), translation: center }, None)
}

fn cuboid(half: DVec3) -> Solid {
    Solid::Cuboid(Cuboid { half })
}

fn ball(radii: DVec3) -> Solid {
    Solid::Ellipsoid(Ellipsoid { radii })
}

fn can(half: DVec3) -> Solid {
    Solid::Cylinder(Cylinder { half })
}

fn plate(half: DVec3) -> Solid {
    Solid::Rectangle(Rectangle { half: half.truncate() })
}

fn see(body: &Body, origin: DVec3, direction: DVec3) -> Seen {
    let ray = Ray { origin, direction };
    let hit = body.intersect(&ray, f32::INFINITY, || 0.0)?;
    Some((hit.distance, body.normal(ray.at(hit.distance), hit.part)))
}

/// A hit at this distance on a face with this normal (to either side), or a miss.
fn expect(seen: Seen, distance: f64, normal: DVec3) {
    let (found, towards) = seen.unwrap();
    assert!((found - distance).abs() <= 1e-12 * distance.max(1.0), "{found} is not {distance}");
    assert!(
        (towards.length() - 1.0).abs() < 1e-9 && (towards.dot(normal.normalize()).abs() - 1.0).abs() < 1e-9,
        "{towards}"
    );
}

#[test]
fn box_from_outside_and_inside() {
    let shape = body(cuboid, vec(10.0, 0.0, 0.0), vec(2.0, 4.0, 6.0), 0.0);
    let towards = |origin, direction| see(&shape, origin, direction);
    expect(towards(DVec3::ZERO, DVec3::X), 9.0, DVec3::X);
    expect(towards(vec(10.0, 0.5, 0.5), DVec3::X), 1.0, DVec3::X);
    expect(towards(vec(10.0, 0.0, 0.0), DVec3::Y), 2.0, DVec3::Y);
    expect(towards(vec(10.0, 0.0, 10.0), DVec3::NEG_Z), 7.0, DVec3::Z);
    expect(towards(DVec3::ZERO, vec(9.0, 1.0, 1.0)), 1.0, DVec3::X);
    assert_eq!(towards(DVec3::ZERO, DVec3::NEG_X), None);
    assert_eq!(towards(DVec3::ZERO, vec(9.0, 2.1, 0.0)), None);
    assert_eq!(towards(vec(0.0, 2.1, 0.0), DVec3::X), None);
}

#[test]
fn box_from_its_faces_edges_and_corners() {
    let shape = body(cuboid, DVec3::ZERO, DVec3::splat(2.0), 0.0);
    let towards = |origin, direction| see(&shape, origin, direction);
    // The ray runs within a face, along an edge, and through two opposite corners.
    expect(towards(vec(-3.0, 1.0, 0.0), DVec3::X), 2.0, DVec3::X);
    expect(towards(vec(-3.0, 1.0, 1.0), DVec3::X), 2.0, DVec3::X);
    assert!((towards(DVec3::splat(-3.0), DVec3::ONE).unwrap().0 - 2.0).abs() < 1e-12);
    // It starts on a face and looks in, or out.
    expect(towards(vec(-1.0, 0.0, 0.0), DVec3::X), 2.0, DVec3::X);
    assert_eq!(towards(vec(-1.0, 0.0, 0.0), DVec3::NEG_X), None);
}

#[test]
fn turned_box() {
    let shape = body(cuboid, vec(5.0, 0.0, 0.0), DVec3::splat(2.0), FRAC_PI_4);
    let corner = see(&shape, vec(0.0, 1e-7, 0.0), DVec3::X);
    expect(corner, 5.0 - 2.0_f64.sqrt() + 1e-7, vec(-1.0, 1.0, 0.0));
    let long = body(cuboid, DVec3::ZERO, vec(8.0, 2.0, 2.0), FRAC_PI_2);
    expect(see(&long, vec(0.0, -9.0, 0.0), DVec3::Y), 5.0, DVec3::Y);
}

#[test]
fn ellipsoid() {
    let shape = body(ball, vec(10.0, 0.0, 0.0), vec(2.0, 4.0, 6.0), 0.0);
    let towards = |origin, direction| see(&shape, origin, direction);
    expect(towards(DVec3::ZERO, DVec3::X), 9.0, DVec3::X);
    expect(towards(vec(10.0, 0.0, 0.0), DVec3::Z), 3.0, DVec3::Z);
    expect(towards(vec(10.0, 9.0, 0.0), DVec3::NEG_Y), 7.0, DVec3::Y);
    // Half way up, the outline is smaller by sqrt(3)/2 and the normal leans back.
    let side = 10.0 - 0.75_f64.sqrt();
    expect(towards(vec(0.0, 0.0, 1.5), DVec3::X), side, vec(-(0.75_f64.sqrt()), 0.0, 0.5 / 3.0));
    assert_eq!(towards(vec(0.0, 2.0 + 1e-9, 0.0), DVec3::X), None);
    assert!(towards(vec(0.0, 2.0 - 1e-9, 0.0), DVec3::X).is_some());
    assert_eq!(towards(vec(0.0, 0.0, 0.0), DVec3::NEG_X), None);
}

#[test]
fn small_ball_far_away() {
    let distance = 1e5;
    let shape = body(ball, vec(distance, 0.0, 0.0), DVec3::splat(0.02), 0.0);
    let (found, normal) = see(&shape, vec(0.0, 0.006, 0.0), DVec3::X).unwrap();
    assert!((found - (distance - 0.008)).abs() < 1e-9, "{found}");
    assert!((normal - vec(-0.8, 0.6, 0.0)).length() < 1e-6, "{normal}");
    assert!(see(&shape, vec(0.0, 0.0101, 0.0), DVec3::X).is_none());
}

#[test]
fn cylinder() {
    let shape = body(can, vec(10.0, 0.0, 0.0), vec(2.0, 4.0, 6.0), 0.0);
    let towards = |origin, direction| see(&shape, origin, direction);
    expect(towards(vec(0.0, 0.0, 1.0), DVec3::X), 9.0, DVec3::X);
    expect(towards(vec(10.5, 0.5, 10.0), DVec3::NEG_Z), 7.0, DVec3::Z);
    expect(towards(vec(10.5, 0.5, 0.0), DVec3::Z), 3.0, DVec3::Z);
    expect(towards(vec(10.0, 0.0, 0.0), DVec3::Y), 2.0, DVec3::Y);
    // Through the cap first, although the side is crossed as well.
    expect(towards(vec(8.0, 0.0, 4.0), vec(1.5, 0.0, -1.0)), 1.0, DVec3::Z);
    assert_eq!(towards(vec(0.0, 0.0, 3.1), DVec3::X), None);
    assert_eq!(towards(vec(10.9, 1.9, 10.0), DVec3::NEG_Z), None);
    assert_eq!(towards(vec(12.0, 0.0, 0.0), DVec3::Z), None);
}

#[test]
fn nearly_vertical_rays_and_cylinder() {
    let shape = body(can, DVec3::ZERO, DVec3::splat(2.0), 0.3);
    for tilt in [1e-9, 1e-17, 1e-150, 1e-300] {
        expect(see(&shape, vec(0.5, 0.0, 9.0), vec(tilt, -tilt, -1.0)), 8.0, DVec3::Z);
    }
}

#[test]
fn rectangle() {
    let shape = body(plate, vec(0.0, 0.0, -2.0), vec(20.0, 10.0, 0.0), FRAC_PI_2);
    let towards = |origin, direction| see(&shape, origin, direction);
    expect(towards(DVec3::ZERO, DVec3::NEG_Z), 2.0, DVec3::Z);
    expect(towards(vec(0.0, 0.0, -5.0), DVec3::Z), 3.0, DVec3::Z);
    expect(towards(DVec3::ZERO, vec(0.0, 9.9, -2.0)), 1.0, DVec3::Z);
    expect(towards(DVec3::ZERO, vec(5.0, 0.0, -2.0)), 1.0, DVec3::Z);
    assert_eq!(towards(DVec3::ZERO, vec(5.1, 0.0, -2.0)), None);
    assert_eq!(towards(DVec3::ZERO, DVec3::X), None);
    assert_eq!(towards(vec(0.0, 0.0, -2.0), DVec3::X), None);
    assert_eq!(towards(DVec3::ZERO, DVec3::Z), None);
}

#[test]
fn triangle_inside_edge_corner_and_edge_on() {
    let shape = Triangle { corners: [vec(5.0, 0.0, 0.0), vec(5.0, 2.0, 0.0), vec(5.0, 0.0, 2.0)] };
    let from = |origin, direction| shape.intersect(&Ray { origin, direction }.sheared(), 0.0);
    let towards = |direction| Some((from(DVec3::ZERO, direction)?, shape.normal()));
    expect(towards(vec(5.0, 0.5, 0.5)), 1.0, DVec3::X);
    expect(towards(vec(5.0, 1.0, 0.0)), 1.0, DVec3::X);
    expect(towards(vec(2.5, 0.0, 1.0)), 2.0, DVec3::X);
    assert_eq!(towards(vec(5.0, 1.1, 1.1)), None);
    assert_eq!(towards(vec(-5.0, 0.5, 0.5)), None);
    assert_eq!(from(vec(5.0, -1.0, 0.5), DVec3::Y), None);
    let flat = Triangle { corners: [DVec3::X, DVec3::X * 2.0, DVec3::X * 3.0] };
    assert_eq!(flat.intersect(&Ray { origin: DVec3::ZERO, direction: DVec3::X }.sheared(), 0.0), None);
    assert_eq!(flat.normal(), DVec3::ZERO);
}

#[test]
fn normals_point_outwards() {
    let shape = Cuboid { half: vec(2.0, 1.0, 1e-3) };
    assert_eq!(shape.normal(vec(2.0, 0.999, -0.999e-3)), DVec3::X);
    assert_eq!(shape.normal(vec(-1.9, -1.0, 0.0)), DVec3::NEG_Y);
    assert_eq!(shape.normal(vec(1.999, 0.0, -1e-3 - 1e-16)), DVec3::NEG_Z);
    let shape = Cylinder { half: vec(2.0, 1.0, 3.0) };
    assert_eq!(shape.normal(vec(0.5, -0.5, -3.0)), DVec3::NEG_Z);
    // On the side: x = 2 cos t, y = sin t has the tangent (-2 sin t, cos t).
    let (sin, cos) = 0.7_f64.sin_cos();
    let normal = shape.normal(vec(2.0 * cos, sin, 2.5));
    assert!((normal - vec(cos, 2.0 * sin, 0.0).normalize()).length() < 1e-15);
    let shape = Ellipsoid { radii: vec(4.0, 2.0, 1.0) };
    let normal = shape.normal(vec(4.0 * 0.6, 0.0, 0.8));
    assert!((normal - vec(0.6, 0.0, 4.0 * 0.8).normalize()).length() < 1e-15);
    let thin = Ellipsoid { radii: vec(1e-300, 1.0, 1.0) };
    assert_eq!(thin.normal(vec(1e-300, 0.0, 0.0)), DVec3::X);
}

/// Every hit of a tilted body lies on the surface and within the bounds, is seen at the same place from the other side, and
/// has the normal along which `off_surface`, a function of points of the body's frame, changes.
fn holds_for_random_rays(solid: Solid, off_surface: impl Fn(DVec3) -> f64) {
    let rotation = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_y(0.4) * DMat3::from_rotation_x(-1.1);
    let pose = Pose { rotation, translation: vec(1.0, -2.0, 0.5) };
    let body = Body::new(solid, pose, None);
    let bounds = body.bounds().grown(1e-9);
    let mut random = Random(7);
    let mut hits = 0;
    for _ in 0..20_000 {
        let (origin, direction) = (random.vector(-9.0, 9.0), random.direction());
        let Some((distance, normal)) = see(&body, origin, direction) else { continue };
        hits += 1;
        let point = origin + direction * distance;
        let local = rotation.transpose() * (point - pose.translation);
        assert!(off_surface(local).abs() < 1e-9, "{local} is off the surface");
        assert!(point.cmpge(bounds.min).all() && point.cmple(bounds.max).all());
        let (back, _) = see(&body, origin + direction * (distance + 1e-6), -direction).unwrap();
        assert!((back - 1e-6).abs() < 1e-9, "{back} from behind");
        let step = |axis: DVec3| off_surface(local + axis * 1e-6) - off_surface(local - axis * 1e-6);
        let gradient = rotation * DVec3::from_array(DVec3::AXES.map(step));
        let angle = gradient.normalize().dot(normal);
        // A step over an edge sees two faces.
        let smooth = DVec3::AXES
            .iter()
            .all(|&axis| (off_surface(local + axis * 1e-6) + off_surface(local - axis * 1e-6)).abs() < 1e-9);
        assert!(!smooth || (angle.abs() - 1.0).abs() < 1e-6, "{normal} is not {gradient}");
        assert!((normal.length() - 1.0).abs() < 1e-9);
    }
    assert!(hits > 500, "only {hits} hits");
}

#[test]
fn random_rays_hit_the_surface() {
    let half = vec(2.0, 3.5, 1.0);
    holds_for_random_rays(cuboid(half), |p| (p / half).abs().max_element() - 1.0);
    holds_for_random_rays(ball(half), |p| (p / half).length() - 1.0);
    holds_for_random_rays(can(half), |p| (p / half).truncate().length().max((p / half).z.abs()) - 1.0);
    holds_for_random_rays(plate(half), |p| p.z);
    let corners = [vec(-5.0, -4.0, 1.0), vec(6.0, -3.0, -2.0), vec(0.0, 7.0, 3.0)];
    let mesh = TriangleMesh::new(corners.map(|c| c.to_array()).into(), vec![[0, 1, 2]]).unwrap();
    let normal = Triangle { corners }.normal();
    let body = MeshBody::new(mesh, DVec3::ONE);
    holds_for_random_rays(Solid::Mesh(Arc::new(body)), |p| (p - corners[0]).dot(normal));
}
