//! Media: free paths and what comes of them, against closed forms.

use glam::{DMat3, DVec3};

use super::{Random, box_mesh, linear, pattern, primitive, spec};
use crate::medium::{FreePaths, QUANTILES, RowKey};
use crate::{Backend, FreePathKey, Images, Pose, Primitive, Scene, SceneHit, Shape, TriangleMesh, cast, scan};

/// How far the mean of so many numbers of deviation 1 may be off: 4 standard errors.
fn error(count: usize) -> f64 {
    4.0 / (count as f64).sqrt()
}

fn medium(shape: Shape, center: [f64; 3], size: [f64; 3], extinction: f64) -> Primitive {
    Primitive { extinction: Some(extinction), ..primitive(shape, center, size) }
}

/// What many rays of the same origin and direction meet, each with a key of its own.
fn rays(scene: &Scene, origin: DVec3, direction: DVec3, count: usize) -> Vec<Option<SceneHit>> {
    (0..count).map(|k| scene.closest(origin, direction, FreePathKey::of_ray(9, k))).collect()
}

/// The share of rays that pass through primitive 0 is that of Beer and Lambert for so many mean free paths.
fn transmits(scene: &Scene, origin: DVec3, direction: DVec3, depth: f64) {
    let count = 40_000;
    let met = rays(scene, origin, direction, count);
    let passed = met.iter().filter(|hit| hit.is_none_or(|hit| !scene.is_medium(hit.primitive))).count();
    let (share, expected) = (passed as f64 / count as f64, (-depth).exp());
    let off = (share - expected).abs() / (expected * (1.0 - expected)).sqrt();
    assert!(off < error(count), "{share} of the rays pass, not {expected}");
}

/// Free paths of 64 rows of 1024 columns in one body, so many mean free paths apart, for rows and columns that are equally wide.
fn paths(seed: u64, body: u32, apart: f64) -> Vec<f64> {
    let of_row = |row| {
        let place = RowKey::new(row, row as f64, 0.0, 1.0);
        (0..1024).map(move |column| f64::from(FreePaths::new(seed, body, apart).at(place, column)))
    };
    (0..64).flat_map(of_row).collect()
}

#[test]
fn free_paths_are_exponential() {
    for apart in [0.02, 0.2, 2.0, f64::INFINITY] {
        let many = (0..60).flat_map(|body| paths(u64::from(body) % 7, body, apart).into_iter().step_by(61));
        let mut found: Vec<f64> = many.collect();
        // Rays near each other are alike: what counts are the bodies.
        let count = if apart < 5.0 { 60 } else { found.len() };
        let mean = |f: &dyn Fn(f64) -> f64| found.iter().map(|&x| f(x)).sum::<f64>() / found.len() as f64;
        assert!((mean(&|x| x) - 1.0).abs() < error(count));
        // The second moment is 2, and its deviation sqrt(24 - 4).
        assert!((mean(&|x| x * x) - 2.0).abs() < 20_f64.sqrt() * error(count));
        found.sort_by(f64::total_cmp);
        let all = found.len() as f64;
        let gap = |(k, x): (usize, &f64)| (1.0 - (-x).exp() - (k as f64 + 0.5) / all).abs();
        let gap = found.iter().enumerate().map(gap).fold(0.0, f64::max);
        // Kolmogorov and Smirnov's test, at 1 in 1000.
        assert!(gap < 1.95 / (count as f64).sqrt(), "{gap}");
        assert!(found[0] > 0.0);
    }
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - 1.0) * (b - 1.0)).sum::<f64>() / a.len().min(b.len()) as f64
}

#[test]
fn rays_far_apart_have_independent_free_paths() {
    let one = paths(5, 3, 5.0);
    for lag in [1, 2, 3, 7, 16, 1023, 1024, 1025, 2048, 8192] {
        let found = correlation(&one, &one[lag..]);
        assert!(found.abs() < error(one.len() - lag), "{found} at a lag of {lag}");
    }
    for (seed, body) in [(5, 2), (5, 4), (4, 3), (6, 3), (3, 5)] {
        let found = correlation(&one, &paths(seed, body, 5.0));
        assert!(found.abs() < error(one.len()), "{found} with body {body} of seed {seed}");
    }
}

#[test]
fn rays_near_each_other_get_nearly_as_far() {
    // In both directions, and less the further they are apart.
    for direction in [1, 1024] {
        let found = [1, 2, 4, 8, 16, 32, 64, 128].map(|apart| {
            let all: Vec<Vec<f64>> = (0..40).map(|body| paths(1, body, 0.03 * f64::from(apart))).collect();
            all.iter().map(|one| correlation(one, &one[direction..])).sum::<f64>() / all.len() as f64
        });
        assert!(found.is_sorted_by(|near, far| near > far), "{found:?}");
        assert!(found[0] > 0.4 && found[7] < 0.1, "{found:?}");
    }
    // Half as far apart and a step of two are one distance.
    let steps = |apart, lag: usize| {
        let all = (0..40).map(|body| paths(2, body, apart));
        all.map(|one| correlation(&one, &one[lag..])).sum::<f64>() / 40.0
    };
    assert!((steps(0.12, 2) - steps(0.24, 1)).abs() < 0.05);
}

#[test]
fn a_row_of_more_columns_than_paths() {
    let (paths, level) = (FreePaths::new(2, 3, 0.1), RowKey::new(4, 0.0, 0.0, 1.0));
    let (a, b) = (paths.at(level, 5), paths.at(level, 5 + QUANTILES));
    assert_eq!(a, b);
}

#[test]
fn the_mean_free_path() {
    for (extinction, length) in [(0.5, 1.0), (4.0, 1.0), (2.0, 3.0)] {
        let fog = Scene::new(vec![medium(Shape::Box, [0.0; 3], [1e4; 3], extinction)]).unwrap();
        for origin in [DVec3::ZERO, DVec3::new(-6e3, 0.0, 0.0)] {
            let direction = DVec3::X * length;
            let met = rays(&fog, origin, direction, 20_000);
            let from = if origin.x < -5e3 { 1e3 } else { 0.0 };
            let sum: f64 = met.iter().map(|hit| hit.unwrap().distance * length - from).sum();
            let mean = sum / met.len() as f64 * extinction;
            assert!((mean - 1.0).abs() < error(met.len()), "{mean}");
        }
    }
}

#[test]
fn transmittance() {
    let shapes = [Shape::Box, Shape::Ellipsoid, Shape::Cylinder, Shape::Mesh(box_mesh())];
    let size = [4.0, 2.0, 6.0];
    // Chords along x at a height of 0.9 and half a metre to the left.
    let ball = 4.0 * (1.0_f64 - 0.25 - 0.09).sqrt();
    let chords = [4.0, ball, 4.0 * 0.75_f64.sqrt(), 4.0];
    for (shape, chord) in shapes.into_iter().zip(chords) {
        for extinction in [0.05, 0.4, 1.0] {
            let scene = Scene::new(vec![medium(shape.clone(), [10.0, 1.0, -2.0], size, extinction)]).unwrap();
            let through = DVec3::new(0.0, 1.5, -1.1);
            transmits(&scene, through, DVec3::X, extinction * chord);
            transmits(&scene, through + DVec3::X * 20.0, -DVec3::X, extinction * chord);
            // From the middle, half of it is left.
            transmits(&scene, through + DVec3::X * 10.0, DVec3::X, extinction * chord / 2.0);
            let pose = Pose { rotation: DMat3::from_rotation_y(1.1), translation: DVec3::new(7.0, 8.0, 9.0) };
            let moved = scene.moved(&[0], &[pose]).unwrap();
            transmits(&moved, pose.point(DVec3::new(-9.0, 0.5, 0.9)), pose.vector(DVec3::X), extinction * chord);
        }
    }
}

#[test]
fn nested_overlapping_and_before_a_wall() {
    let wall = Primitive { label: 7, ..primitive(Shape::Box, [20.0, 0.0, 0.0], [2.0, 9.0, 9.0]) };
    let scene = Scene::new(vec![
        medium(Shape::Box, [10.0, 0.0, 0.0], [6.0; 3], 0.1),
        medium(Shape::Ellipsoid, [10.0, 0.0, 0.0], [2.0; 3], 0.3),
        medium(Shape::Cylinder, [13.0, 0.0, 0.0], [4.0; 3], 0.2),
        wall,
    ]);
    let scene = scene.unwrap();
    transmits(&scene, DVec3::ZERO, DVec3::X, 0.1 * 6.0 + 0.3 * 2.0 + 0.2 * 4.0);
    for hit in rays(&scene, DVec3::ZERO, DVec3::X, 2000) {
        let hit = hit.unwrap();
        let (from, to) = [(7.0, 13.0), (9.0, 11.0), (11.0, 15.0), (19.0, 19.0)][hit.primitive];
        assert!((from - 1e-9..=to + 1e-9).contains(&hit.distance), "{hit:?}");
    }
    // A wall within a medium ends it.
    let scene = Scene::new(vec![medium(Shape::Box, [19.0, 0.0, 0.0], [10.0; 3], 0.1), scene_wall()]).unwrap();
    transmits(&scene, DVec3::ZERO, DVec3::X, 0.1 * 5.0);
}

fn scene_wall() -> Primitive {
    primitive(Shape::Box, [19.5, 0.0, 0.0], [1.0, 9.0, 9.0])
}

/// A box with a hollow: the inner shell is turned inside out.
fn hollow() -> TriangleMesh {
    let (outer, inner) = (box_mesh(), box_mesh());
    let shrunk = inner.vertices().iter().map(|v| v.map(|x| 0.5 * x));
    let vertices = outer.vertices().iter().copied().chain(shrunk).collect();
    let turned = inner.faces().iter().map(|&[a, b, c]| [a + 8, c + 8, b + 8]);
    TriangleMesh::new(vertices, outer.faces().iter().copied().chain(turned).collect()).unwrap()
}

#[test]
fn meshes_are_crossed_where_they_are() {
    let scene = Scene::new(vec![medium(Shape::Mesh(hollow()), [0.0; 3], [4.0; 3], 0.3)]).unwrap();
    transmits(&scene, DVec3::new(-9.0, 0.2, 0.1), DVec3::X, 0.3 * 2.0);
    transmits(&scene, DVec3::new(0.0, 0.2, 0.1), DVec3::X, 0.3 * 1.0);
    for hit in rays(&scene, DVec3::new(-9.0, 0.2, 0.1), DVec3::X, 2000).into_iter().flatten() {
        assert!(!(8.0..10.0).contains(&hit.distance), "{hit:?} in the hollow");
    }
}

/// Through edges and corners, and from places of round numbers: as if it were a box.
#[test]
fn a_mesh_is_its_box() {
    let turned = {
        let mesh = box_mesh();
        let faces = mesh.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        TriangleMesh::new(mesh.vertices().to_vec(), faces).unwrap()
    };
    let scene = |shape| Scene::new(vec![medium(shape, [0.0; 3], [2.0; 3], 0.4)]).unwrap();
    let (cuboid, meshes) = (scene(Shape::Box), [box_mesh(), turned].map(|mesh| scene(Shape::Mesh(mesh))));
    let mut random = Random(3);
    let compare = |origin: DVec3, aim: DVec3, k: u32| {
        let key = FreePathKey::of_ray(1, k as usize);
        let expected = cuboid.closest(origin, aim - origin, key).map(|hit| hit.distance);
        for mesh in &meshes {
            let found = mesh.closest(origin, aim - origin, key).map(|hit| hit.distance);
            let same = match (found, expected) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-9,
                (a, b) => a == b,
            };
            assert!(same, "{found:?} is not {expected:?} from {origin} to {aim}");
        }
    };
    let grid = [-0.5, -0.25, 0.0, 0.25, 0.5];
    let mut k = 0;
    for y in grid {
        for z in grid {
            for from in [DVec3::new(-3.0, y, z), DVec3::new(-3.0, 0.0, 0.0), DVec3::ZERO, DVec3::new(0.5, 0.5, 0.5)] {
                for axis in 0..3 {
                    let turn = |v: DVec3| DVec3::from_array(std::array::from_fn(|i| v[(i + axis) % 3]));
                    let aim = DVec3::new(1.0, y, z);
                    if aim != from {
                        k += 1;
                        compare(turn(from), turn(aim), k);
                    }
                }
            }
        }
    }
    for _ in 0..5000 {
        k += 1;
        compare(random.vector(-3.0, 3.0), random.vector(-0.9, 0.9), k);
    }
}

#[test]
fn returns_face_the_ray() {
    let scene = Scene::new(vec![medium(Shape::Ellipsoid, [6.0, 0.0, 0.0], [8.0; 3], 0.3)]).unwrap();
    let pattern = pattern(spec(linear(0.4, -0.4, 9), 180));
    for backend in Backend::available() {
        let mut images = Images::new(9, 180);
        scan(&scene, &pattern, &[Pose::IDENTITY], 3, &mut images.as_mut(), Some(backend), 1).unwrap();
        let mut hits = 0;
        for i in (0..9 * 180).filter(|&i| images.depth[i] > 0.0) {
            hits += 1;
            assert!((images.incidence[i] - 1.0).abs() < 1e-6);
            let normal = DVec3::from(images.normal[i].map(f64::from));
            assert!((normal + pattern.direction(i / 180, i % 180)).length() < 1e-6);
        }
        assert!(hits > 100, "{hits}");
    }
    let hits = cast(&scene, &[[0.0; 3]; 50], &[[9.0, 0.0, 0.0]; 50], 99.0, 3, 1).unwrap();
    assert!(hits.distance.iter().zip(&hits.normal).all(|(&d, n)| (d == 0.0) == (*n == [0.0; 3])));
    assert!(hits.normal.contains(&[-1.0, 0.0, 0.0]));
    assert_ne!(hits, cast(&scene, &[[0.0; 3]; 50], &[[9.0, 0.0, 0.0]; 50], 99.0, 4, 1).unwrap());
}

/// A medium nearer than the minimum range is not reported, and occludes what is behind it.
#[test]
fn range_limits() {
    let mut narrow = spec(vec![0.0], 1);
    (narrow.azimuth_start, narrow.azimuth_span) = (0.01, 0.02);
    (narrow.min_range, narrow.max_range) = (2.0, 20.0);
    let fog = medium(Shape::Box, [2.0, 0.0, 0.0], [4.0; 3], 0.5);
    let wall = Primitive { label: 7, ..primitive(Shape::Box, [10.0, 0.0, 0.0], [1.0, 9.0, 9.0]) };
    let (scene, pattern) = (Scene::new(vec![fog, wall]).unwrap(), pattern(narrow));
    let pixel = |seed| {
        let mut images = Images::new(1, 1);
        scan(&scene, &pattern, &[Pose::IDENTITY], seed, &mut images.as_mut(), None, 1).unwrap();
        (images.depth[0], images.label[0])
    };
    let found: Vec<(f32, u8)> = (0..2000).map(pixel).collect();
    let share = |f: &dyn Fn(&(f32, u8)) -> bool| found.iter().filter(|&one| f(one)).count() as f64 / 2000.0;
    let near = |expected: f64, found: f64| assert!((expected - found).abs() < 0.05, "{found} is not {expected}");
    near(1.0 - (-1.0_f64).exp(), share(&|pixel| pixel.0 == 0.0));
    near((-1.0_f64).exp() - (-2.0_f64).exp(), share(&|pixel| (2.0..4.1).contains(&pixel.0)));
    near((-2.0_f64).exp(), share(&|pixel| pixel.1 == 7));
}

#[test]
fn a_medium_that_keeps_its_number_keeps_its_paths() {
    let bush = || medium(Shape::Ellipsoid, [10.0, 0.0, 0.0], [4.0; 3], 0.5);
    let wall = primitive(Shape::Box, [0.0, 0.0, 40.0], [1.0; 3]);
    let distances = |scene: &Scene| {
        rays(scene, DVec3::ZERO, DVec3::X, 500).iter().map(|hit| hit.map(|hit| hit.distance)).collect::<Vec<_>>()
    };
    let numbered = |primitives: Vec<Primitive>, numbers: &[u32]| {
        distances(&Scene::new(primitives).unwrap().with_media(numbers.to_vec()).unwrap())
    };
    let alone = numbered(vec![bush()], &[77]);
    assert_eq!(alone, numbered(vec![wall.clone(), bush()], &[3, 77]));
    assert_ne!(alone, numbered(vec![bush()], &[78]));
    assert_eq!(numbered(vec![bush()], &[0]), distances(&Scene::new(vec![bush()]).unwrap()));
    let error = Scene::new(vec![wall, bush()]).unwrap().with_media(vec![1]).err().unwrap();
    assert_eq!(error.to_string(), "media has 1 entries; there are 2 primitives");
}
