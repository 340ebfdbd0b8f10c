//! The map from pixels to rays and back.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Random, linear, pattern, spec};
use crate::{SensorPattern, SensorSpec};

/// Depths that f32 holds, one for each pixel.
fn depths(pattern: &SensorPattern, random: &mut Random) -> Vec<f32> {
    let pixels = pattern.rows() * pattern.columns();
    (0..pixels).map(|_| random.between(1.0, 100.0) as f32).collect()
}

pub(super) fn returns_to_its_pixels(spec: SensorSpec) {
    let pattern = pattern(spec);
    let depth = depths(&pattern, &mut Random(3));
    let points = pattern.points(&depth, [pattern.rows(), pattern.columns()]).unwrap();
    let found = pattern.project(&points);
    for pixel in 0..depth.len() {
        let (row, column) = (pixel / pattern.columns(), pixel % pattern.columns());
        let at = (found.rows[pixel], found.columns[pixel]);
        assert_eq!(at, (row as i32, column as i32), "{:?}", points[pixel]);
        assert_eq!(found.distances[pixel], depth[pixel]);
    }
}

#[test]
fn first_ray_and_cell_order() {
    let pattern = pattern(spec(vec![0.0], 4));
    let expected = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    for (ray, [x, y]) in pattern.directions().into_iter().zip(expected) {
        assert!((ray[0] - x / 2.0_f64.sqrt()).abs() < 1e-15);
        assert!((ray[1] - y / 2.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(ray[2], 0.0);
    }
}

#[test]
fn directions_follow_their_definition() {
    let mut spec = spec(linear(0.3, -0.4, 8), 90);
    spec.azimuth_offsets = (0..8).map(|h| 0.03 * f64::from(h) - 0.1).collect();
    spec.azimuth_start = 2.0;
    spec.azimuth_span = 1.5;
    let pattern = pattern(spec.clone());
    let directions = pattern.directions();
    for (pixel, ray) in directions.iter().enumerate() {
        let (h, w) = (pixel / 90, pixel % 90);
        let azimuth = 2.0 - (w as f64 + 0.5) * 1.5 / 90.0 + spec.azimuth_offsets[h];
        let elevation = spec.elevations[h];
        let expected = [elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()];
        assert!(ray.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}

#[test]
fn points_project_to_their_pixels() {
    returns_to_its_pixels(spec(linear(0.05, -0.43, 64), 1024));
    returns_to_its_pixels(spec(vec![0.0], 1));
    returns_to_its_pixels(spec(vec![0.2], 7));
    returns_to_its_pixels(spec(linear(FRAC_PI_2 - 1e-4, 1e-4 - FRAC_PI_2, 32), 36));
    for turn in 0..8 {
        let start = f64::from(turn) * PI / 4.0 - PI;
        let base = spec(linear(0.3, -0.3, 9), 100);
        returns_to_its_pixels(SensorSpec { azimuth_start: start, ..base.clone() });
        returns_to_its_pixels(SensorSpec { azimuth_start: start, azimuth_span: 2.0, ..base });
    }
}

#[test]
fn points_project_to_their_pixels_with_a_table_of_beams() {
    let mut random = Random(9);
    let mut spec = spec(linear(0.1, -0.5, 40), 500);
    spec.azimuth_offsets = (0..40).map(|_| random.between(-0.2, 0.2)).collect();
    spec.azimuth_start = 1.0;
    returns_to_its_pixels(spec.clone());
    spec.azimuth_span = 4.0;
    returns_to_its_pixels(spec.clone());
    // Higher beams start higher, so that no two of them cross.
    spec.origins = (0..40).map(|h| [0.0, 0.0, 0.3 - 0.005 * f64::from(h)]).collect();
    returns_to_its_pixels(spec);
}

#[test]
fn level_origins_and_a_table_of_them_agree() {
    let level = spec(linear(0.2, -0.4, 24), 64);
    let mut uneven = level.clone();
    uneven.origins[23][2] = 1e-15;
    let mut random = Random(13);
    let points: Vec<_> = (0..20_000).map(|_| random.vector(-20.0, 20.0).to_array()).collect();
    let (a, b) = (pattern(level).project(&points), pattern(uneven).project(&points));
    assert_eq!(a, b);
    assert!(a.rows.contains(&-1) && a.rows.contains(&0) && a.rows.contains(&23));
}

#[test]
fn outside() {
    let base = SensorSpec { min_range: 1.0, max_range: 50.0, ..spec(vec![0.1, 0.0, -0.2], 100) };
    let half = SensorSpec { azimuth_start: FRAC_PI_2, azimuth_span: PI, ..base.clone() };
    let at = |elevation: f64, azimuth: f64, distance: f64| {
        let level = elevation.cos() * distance;
        [level * azimuth.cos(), level * azimuth.sin(), elevation.sin() * distance]
    };
    let row = |spec: &SensorSpec, point| pattern(spec.clone()).project(&[point]).rows[0];
    assert_eq!(row(&base, at(0.149, 0.0, 9.0)), 0);
    assert_eq!(row(&base, at(0.151, 0.0, 9.0)), -1);
    assert_eq!(row(&base, at(-0.299, 0.0, 9.0)), 2);
    assert_eq!(row(&base, at(-0.301, 0.0, 9.0)), -1);
    assert_eq!(row(&base, at(0.049, 3.0, 9.0)), 1);
    assert_eq!(row(&base, at(0.0, 0.0, 0.999)), -1);
    assert_eq!(row(&base, at(0.0, 0.0, 1.0)), 1);
    assert_eq!(row(&base, at(0.0, 0.0, 50.0)), 1);
    assert_eq!(row(&base, at(0.0, 0.0, 50.001)), -1);
    assert_eq!(row(&half, at(0.0, FRAC_PI_2 - 1e-9, 9.0)), 1);
    assert_eq!(row(&half, at(0.0, FRAC_PI_2 + 1e-9, 9.0)), -1);
    assert_eq!(row(&half, at(0.0, 1e-9 - FRAC_PI_2, 9.0)), 1);
    assert_eq!(row(&half, at(0.0, PI, 9.0)), -1);
    assert_eq!(row(&base, [f64::NAN, 0.0, 0.0]), -1);
    assert_eq!(row(&base, [f64::INFINITY, 0.0, 0.0]), -1);
    assert_eq!(row(&base, [0.0; 3]), -1);
    let single = SensorSpec { azimuth_span: 1.0, azimuth_start: 0.5, ..spec(vec![0.0], 10) };
    assert_eq!(row(&single, at(0.049, 0.0, 9.0)), 0);
    assert_eq!(row(&single, at(0.051, 0.0, 9.0)), -1);
}

#[test]
fn the_seam() {
    let pattern = pattern(spec(vec![0.1, -0.1], 8));
    let column = |x: f64, y: f64| pattern.project(&[[x, y, 0.0]]).columns[0];
    assert_eq!(column(-9.0, 1e-12), 0);
    assert_eq!(column(-9.0, -1e-12), 7);
    assert_eq!(column(-9.0, 1e-300), 0);
    assert!([0, 7].contains(&column(-9.0, 0.0)));
    assert!([0, 7].contains(&column(-9.0, -0.0)));
    assert_eq!(column(9.0, 1e-12), 3);
    assert_eq!(column(9.0, -1e-12), 4);
}

#[test]
fn every_azimuth_of_a_turn_has_a_column() {
    let mut random = Random(21);
    for start in [0.0, PI, -PI, TAU, 100.0, random.between(-9.0, 9.0)] {
        let base = SensorSpec { azimuth_start: start, ..spec(vec![0.1, -0.1], 1000) };
        for span in [TAU, TAU + 1e-9] {
            let pattern = pattern(SensorSpec { azimuth_span: span, ..base.clone() });
            for edge in 0..1000 {
                let azimuth = start - f64::from(edge) * TAU / 1000.0;
                let point = [azimuth.cos() * 9.0, azimuth.sin() * 9.0, 0.0];
                assert!(pattern.project(&[point]).columns[0] >= 0, "{azimuth}");
            }
        }
    }
}

#[test]
fn no_distance_is_the_origin_of_the_beam() {
    let mut spec = spec(vec![0.1, -0.1], 2);
    spec.origins = vec![[0.0, 0.0, 0.25], [0.0, 0.0, -0.5]];
    let points = pattern(spec).points(&[0.0; 4], [2, 2]).unwrap();
    assert_eq!(points[0], [0.0, 0.0, 0.25]);
    assert_eq!(points[3], [0.0, 0.0, -0.5]);
}
