//! Distances and normals in closed form.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::DVec3;

use super::Random;
use crate::Bounds;
use crate::intersect::{Cuboid, Cylinder, Ellipsoid, Hit, Ray, Rectangle, Triangle};

fn vec(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A hit at this distance on a face with this normal (to either side), or a miss.
fn expect(hit: Option<Hit>, distance: f64, normal: DVec3) {
    let hit = hit.unwrap();
    let error = (hit.distance - distance).abs();
    assert!(error <= 1e-12 * distance.max(1.0), "{} is not {distance}", hit.distance);
    assert!((hit.normal.dot(normal.normalize()).abs() - 1.0).abs() < 1e-9, "{}", hit.normal);
}

#[test]
fn box_from_outside_and_inside() {
    let shape = Cuboid::new(vec(10.0, 0.0, 0.0), vec(2.0, 4.0, 6.0), 0.0);
    let towards = |origin, direction| shape.intersect(&Ray::new(origin, direction));
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
    let shape = Cuboid::new(DVec3::ZERO, DVec3::splat(2.0), 0.0);
    let towards = |origin, direction| shape.intersect(&Ray::new(origin, direction));
    // The ray runs within a face, along an edge, and through two opposite corners.
    expect(towards(vec(-3.0, 1.0, 0.0), DVec3::X), 2.0, DVec3::X);
    expect(towards(vec(-3.0, 1.0, 1.0), DVec3::X), 2.0, DVec3::X);
    assert!((towards(DVec3::splat(-3.0), DVec3::ONE).unwrap().distance - 2.0).abs() < 1e-12);
    // It starts on a face, which is grown by rounding: it looks in, or it looks out.
    assert!(towards(vec(-1.0, 0.0, 0.0), DVec3::X).unwrap().distance > 1.9);
    let out = towards(vec(-1.0, 0.0, 0.0), DVec3::NEG_X);
    assert!(out.is_none_or(|hit| hit.distance < 1e-12));
}

#[test]
fn turned_box() {
    let shape = Cuboid::new(vec(5.0, 0.0, 0.0), DVec3::splat(2.0), FRAC_PI_4);
    let corner = shape.intersect(&Ray::new(vec(0.0, 1e-7, 0.0), DVec3::X));
    expect(corner, 5.0 - 2.0_f64.sqrt() + 1e-7, vec(-1.0, 1.0, 0.0));
    let long = Cuboid::new(DVec3::ZERO, vec(8.0, 2.0, 2.0), FRAC_PI_2);
    expect(long.intersect(&Ray::new(vec(0.0, -9.0, 0.0), DVec3::Y)), 5.0, DVec3::Y);
}

#[test]
fn ellipsoid() {
    let shape = Ellipsoid::new(vec(10.0, 0.0, 0.0), vec(2.0, 4.0, 6.0), 0.0);
    let towards = |origin, direction| shape.intersect(&Ray::new(origin, direction));
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
    let ball = Ellipsoid::new(vec(distance, 0.0, 0.0), DVec3::splat(0.02), 0.0);
    let hit = ball.intersect(&Ray::new(vec(0.0, 0.006, 0.0), DVec3::X)).unwrap();
    assert!((hit.distance - (distance - 0.008)).abs() < 1e-9, "{}", hit.distance);
    assert!(ball.intersect(&Ray::new(vec(0.0, 0.0101, 0.0), DVec3::X)).is_none());
}

#[test]
fn cylinder() {
    let shape = Cylinder::new(vec(10.0, 0.0, 0.0), vec(2.0, 4.0, 6.0), 0.0);
    let towards = |origin, direction| shape.intersect(&Ray::new(origin, direction));
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
    let shape = Cylinder::new(DVec3::ZERO, DVec3::splat(2.0), 0.3);
    for tilt in [1e-9, 1e-17, 1e-150, 1e-300] {
        let ray = Ray::new(vec(0.5, 0.0, 9.0), vec(tilt, -tilt, -1.0));
        expect(shape.intersect(&ray), 8.0, DVec3::Z);
    }
}

#[test]
fn rectangle() {
    let shape = Rectangle::new(vec(0.0, 0.0, -2.0), vec(20.0, 10.0, 0.0), FRAC_PI_2);
    let towards = |origin, direction| shape.intersect(&Ray::new(origin, direction));
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
    let towards = |direction| shape.intersect(&Ray::new(DVec3::ZERO, direction));
    expect(towards(vec(5.0, 0.5, 0.5)), 1.0, DVec3::X);
    expect(towards(vec(5.0, 1.0, 0.0)), 1.0, DVec3::X);
    expect(towards(vec(2.5, 0.0, 1.0)), 2.0, DVec3::X);
    assert_eq!(towards(vec(5.0, 1.1, 1.1)), None);
    assert_eq!(towards(vec(-5.0, 0.5, 0.5)), None);
    assert_eq!(shape.intersect(&Ray::new(vec(5.0, -1.0, 0.5), DVec3::Y)), None);
    let flat = Triangle { corners: [DVec3::X, DVec3::X * 2.0, DVec3::X * 3.0] };
    assert_eq!(flat.intersect(&Ray::new(DVec3::ZERO, DVec3::X)), None);
    assert_eq!(flat.normal(), DVec3::ZERO);
}

/// Every hit lies on the surface, within the bounds, and is seen at the same place from the other side.
fn holds_for_random_rays(intersect: impl Fn(&Ray) -> Option<Hit>, bounds: Bounds, on_surface: impl Fn(DVec3) -> f64) {
    let mut random = Random(7);
    let mut hits = 0;
    for _ in 0..20_000 {
        let origin = random.vector(-9.0, 9.0);
        let direction = random.direction();
        let ray = Ray::new(origin, direction);
        let Some(hit) = intersect(&ray) else { continue };
        hits += 1;
        let point = ray.at(hit.distance);
        assert!(on_surface(point).abs() < 1e-9, "{point} is off the surface");
        assert!((hit.normal.length() - 1.0).abs() < 1e-9);
        let grown = bounds.grown(1e-9);
        assert!(point.cmpge(grown.min).all() && point.cmple(grown.max).all());
        let back = intersect(&Ray::new(ray.at(hit.distance + 1e-6), -direction)).unwrap();
        assert!((back.distance - 1e-6).abs() < 1e-9, "{} from behind", back.distance);
    }
    assert!(hits > 500, "only {hits} hits");
}

#[test]
fn random_rays_hit_the_surface() {
    let (center, size, yaw) = (vec(1.0, -2.0, 0.5), vec(4.0, 7.0, 2.0), 0.7);
    let local = |p: DVec3| {
        let q = p - center;
        let (sin, cos) = f64::sin_cos(-yaw);
        vec(cos * q.x - sin * q.y, sin * q.x + cos * q.y, q.z) / (size / 2.0)
    };
    let cuboid = Cuboid::new(center, size, yaw);
    let on_box = |p| local(p).abs().max_element() - 1.0;
    holds_for_random_rays(|ray| cuboid.intersect(ray), cuboid.bounds(), on_box);
    let ellipsoid = Ellipsoid::new(center, size, yaw);
    let on_ball = |p| local(p).length() - 1.0;
    holds_for_random_rays(|ray| ellipsoid.intersect(ray), ellipsoid.bounds(), on_ball);
    let cylinder = Cylinder::new(center, size, yaw);
    let on_can = |p| local(p).truncate().length().max(local(p).z.abs()) - 1.0;
    holds_for_random_rays(|ray| cylinder.intersect(ray), cylinder.bounds(), on_can);
    let rectangle = Rectangle::new(center, size, yaw);
    let on_plane = |p: DVec3| p.z - center.z;
    holds_for_random_rays(|ray| rectangle.intersect(ray), rectangle.bounds(), on_plane);
    let corners = [vec(-5.0, -4.0, 1.0), vec(6.0, -3.0, -2.0), vec(0.0, 7.0, 3.0)];
    let triangle = Triangle { corners };
    let on_triangle = |p: DVec3| (p - corners[0]).dot(triangle.normal());
    holds_for_random_rays(|ray| triangle.intersect(ray), triangle.bounds(), on_triangle);
}
