//! Each way in which the input can be wrong, and its message.

use std::f64::consts::FRAC_PI_2;

use super::{box_mesh, pattern, primitive, spec};
use crate::{
    Backend, Images, Pose, Primitive, PrimitiveTables, Scene, SensorPattern, SensorSpec, Shape, TriangleMesh, cast,
    scan, scan_batch,
};

fn says<T>(result: crate::Result<T>, message: &str) {
    match result {
        Ok(_) => panic!("accepted instead of: {message}"),
        Err(error) => assert_eq!(error.to_string(), message),
    }
}

#[test]
fn meshes() {
    let triangle = vec![[0.0; 3]; 3];
    says(TriangleMesh::new(vec![], vec![]), "the mesh has 0 vertices and 0 faces; it needs at least one of each");
    says(
        TriangleMesh::new(vec![[0.0; 3], [0.0, f64::NAN, 1.0]], vec![[0, 0, 0]]),
        "vertex 1 is [0.0, NaN, 1.0]; coordinates must be finite",
    );
    says(
        TriangleMesh::new(triangle, vec![[0, 1, 2], [2, 1, 40]]),
        "face 1 refers to vertex 40; the mesh has 3 vertices",
    );
}

fn sensor(change: impl Fn(&mut SensorSpec), message: &str) {
    let mut spec = spec(vec![0.1, 0.0, -0.1], 10);
    change(&mut spec);
    says(SensorPattern::new(spec), message);
}

#[test]
fn beams() {
    sensor(|s| s.elevations.clear(), "elevations has 0 entries; a sensor needs at least one beam");
    sensor(|s| s.azimuth_offsets.truncate(2), "azimuth_offsets has 2 entries; the sensor has 3 beams");
    sensor(|s| s.origins.push([0.0; 3]), "origins has 4 entries; the sensor has 3 beams");
    sensor(|s| s.elevations[1] = f64::NAN, "elevations[1] is NaN; it must be finite");
    sensor(|s| s.azimuth_offsets[2] = f64::INFINITY, "azimuth_offsets[2] is inf; it must be finite");
    let far = "m; every coordinate must be finite and at most 1e9 in size";
    sensor(|s| s.origins[0][1] = f64::NAN, &format!("origins[0] is [0.0, NaN, 0.0] {far}"));
    sensor(|s| s.origins[2][2] = -2e9, &format!("origins[2] is [0.0, 0.0, -2000000000.0] {far}"));
    sensor(
        |s| s.elevations[0] = FRAC_PI_2,
        "elevations[0] is 1.5707963267948966 rad; it must be between -pi/2 and pi/2, both excluded",
    );
    sensor(|s| s.elevations[2] = 0.0, "elevations[2] is 0 rad after 0 rad; elevations must strictly decrease");
}

#[test]
fn limits() {
    sensor(|s| s.columns = 0, "columns is 0; it must be 1 to 8388608");
    sensor(|s| s.columns = usize::MAX, "columns is 9223372036854775807; it must be 1 to 8388608");
    sensor(|s| s.azimuth_start = f64::NAN, "azimuth_start is NaN; it must be finite");
    for span in [0.0, -1.0, 6.3, f64::NAN] {
        let message = format!("azimuth_span is {span} rad; it must be greater than 0 and at most 2 pi");
        sensor(|s| s.azimuth_span = span, &message);
    }
    for (min, max) in [(-1.0, 9.0), (9.0, 9.0), (f64::NAN, 9.0), (1.0, f64::NAN), (0.0, f64::INFINITY)] {
        let message =
            format!("min_range is {min} m and max_range is {max} m; it must be 0 <= min_range < max_range <= 1e9");
        sensor(|s| (s.min_range, s.max_range) = (min, max), &message);
    }
}

#[test]
fn images() {
    let pattern = pattern(spec(vec![0.1, 0.0], 3));
    let message = "the image has 3 x 2 pixels; the sensor has 2 beams and 3 columns";
    says(pattern.points(&[0.0; 6], [3, 2]), message);
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        let message = format!("depth[1, 2] is {bad}; it must be finite and >= 0");
        says(pattern.points(&[0.0, 0.0, 0.0, 0.0, 0.0, bad], [2, 3]), &message);
    }
}

fn scene(change: impl Fn(&mut Primitive), message: &str) {
    let mut last = primitive(Shape::Box, [0.0; 3], [1.0; 3]);
    change(&mut last);
    says(Scene::new(vec![primitive(Shape::Box, [0.0; 3], [1.0; 3]), last]), message);
}

#[test]
fn primitives() {
    let far = "m; every coordinate must be finite and at most 1e9 in size";
    scene(|p| p.center[1] = f64::NAN, &format!("centers[1] is [0.0, NaN, 0.0] {far}"));
    scene(|p| p.center[0] = -2e9, &format!("centers[1] is [-2000000000.0, 0.0, 0.0] {far}"));
    let positive = "every extent must be > 0, and none may exceed 1e9";
    scene(|p| p.size[2] = 0.0, &format!("sizes[1] is [1.0, 1.0, 0.0] m; {positive}"));
    scene(|p| p.size[0] = f64::INFINITY, &format!("sizes[1] is [inf, 1.0, 1.0] m; {positive}"));
    scene(|p| p.size[0] = f64::NAN, &format!("sizes[1] is [NaN, 1.0, 1.0] m; {positive}"));
    let flat = "a plane has x > 0, y > 0 and z = 0, and none may exceed 1e9";
    scene(|p| p.shape = Shape::Plane, &format!("sizes[1] is [1.0, 1.0, 1.0] m; {flat}"));
    let extent = "extents of a mesh are >= 0 and not all 0, and none may exceed 1e9";
    let mesh = |size| move |p: &mut Primitive| (p.shape, p.size) = (Shape::Mesh(box_mesh()), size);
    scene(mesh([0.0; 3]), &format!("sizes[1] is [0.0, 0.0, 0.0] m; {extent}"));
    scene(mesh([1.0, -1.0, 1.0]), &format!("sizes[1] is [1.0, -1.0, 1.0] m; {extent}"));
    scene(|p| p.yaw = f64::NEG_INFINITY, "yaws[1] is -inf; it must be finite");
    let rule = "it must be finite and greater than 0, or 0 for a solid";
    for bad in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        scene(|p| p.extinction = Some(bad), &format!("extinctions[1] is {bad} per metre; {rule}"));
    }
    scene(
        |p| (p.shape, p.size, p.extinction) = (Shape::Plane, [1.0, 1.0, 0.0], Some(1.0)),
        "primitive 1 is a plane with an extinction; only what has a volume can be a medium",
    );
    let whole = box_mesh();
    let open = |faces: &[[u32; 3]]| TriangleMesh::new(whole.vertices().to_vec(), faces.to_vec()).unwrap();
    let mut turned = whole.faces().to_vec();
    turned[3].swap(0, 1);
    for faces in [&whole.faces()[1..], &turned, &[whole.faces(), &whole.faces()[..1]].concat()] {
        let last = Primitive { extinction: Some(1.0), ..primitive(Shape::Mesh(open(faces)), [0.0; 3], [1.0; 3]) };
        let message = Scene::new(vec![last]).err().unwrap().to_string();
        assert!(message.starts_with("primitive 0 is an open mesh with an extinction: no triangle runs"), "{message}");
    }
    let closed = Primitive { extinction: Some(1.0), ..primitive(Shape::Mesh(whole.clone()), [0.0; 3], [1.0; 3]) };
    assert!(Scene::new(vec![closed]).is_ok());
    let huge = TriangleMesh::new(vec![[0.0; 3], [1e12, 0.0, 0.0]], vec![[0, 0, 1]]).unwrap();
    scene(
        |p| p.shape = Shape::Mesh(huge.clone()),
        "vertex 1 of the mesh of primitive 1 is [1000000000000.0, 0.0, 0.0] m from its center; the limit is 1e9",
    );
}

#[test]
fn tables() {
    let tables = PrimitiveTables {
        shapes: &[0, 4],
        centers: &[[0.0; 3]; 2],
        sizes: &[[1.0; 3]; 2],
        yaws: &[0.0; 2],
        labels: &[1; 2],
        instances: &[0; 2],
        extinctions: &[],
    };
    assert_eq!(tables.primitives(vec![box_mesh()]).unwrap().len(), 2);
    let media = PrimitiveTables { extinctions: &[0.0, 2.0], ..tables }.primitives(vec![box_mesh()]).unwrap();
    assert_eq!(media.iter().map(|p| p.extinction).collect::<Vec<_>>(), [None, Some(2.0)]);
    says(tables.primitives(vec![]), "there are 0 meshes; 1 primitives have the shape mesh");
    says(tables.primitives(vec![box_mesh(); 2]), "there are 2 meshes; 1 primitives have the shape mesh");
    let unknown = PrimitiveTables { shapes: &[0, 7], ..tables };
    says(unknown.primitives(vec![]), "shapes[1] is 7; it must be 0 box, 1 ellipsoid, 2 cylinder, 3 plane or 4 mesh");
    let cases = [
        (PrimitiveTables { centers: &[], ..tables }, "centers has 0"),
        (PrimitiveTables { sizes: &[[1.0; 3]], ..tables }, "sizes has 1"),
        (PrimitiveTables { yaws: &[0.0; 3], ..tables }, "yaws has 3"),
        (PrimitiveTables { labels: &[], ..tables }, "labels has 0"),
        (PrimitiveTables { instances: &[], ..tables }, "instances has 0"),
        (PrimitiveTables { extinctions: &[1.0], ..tables }, "extinctions has 1"),
    ];
    for (tables, start) in cases {
        says(tables.primitives(vec![]), &format!("{start} entries; there are 2 primitives"));
    }
}

#[test]
fn poses() {
    let pose = |change: &dyn Fn(&mut [[f64; 4]; 4]), message: &str| {
        let mut rows = [[1.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 6.0], [0.0, 0.0, 1.0, 7.0], [0.0, 0.0, 0.0, 1.0]];
        assert_eq!(Pose::from_rows(rows).unwrap().translation.to_array(), [5.0, 6.0, 7.0]);
        change(&mut rows);
        says(Pose::from_rows(rows), message);
    };
    let finite = "it must be finite and at most 1e9 in size";
    pose(&|r| r[1][3] = f64::NAN, &format!("entry [1, 3] of the pose is NaN; {finite}"));
    pose(&|r| r[0][3] = 1e10, &format!("entry [0, 3] of the pose is 10000000000; {finite}"));
    pose(&|r| r[3][0] = 1.0, "the last row of the pose is [1.0, 0.0, 0.0, 1.0]; it must be [0, 0, 0, 1]");
    pose(&|r| r[0][0] = 2.0, "the rotation of the pose is off R^T R = 1 by 3e0; the limit is 1e-6");
    pose(&|r| r[2][2] = -1.0, "the rotation of the pose has the determinant -1; a mirrored pose is not rigid");
}

#[test]
fn moves() {
    let scene = Scene::new(vec![primitive(Shape::Box, [0.0; 3], [1.0; 3]); 3]).unwrap();
    let moved = |primitives: &[u32], message: &str| says(scene.moved(primitives, &[Pose::IDENTITY; 2]), message);
    moved(&[1], "primitives has 1 entries and world_from_primitive has 2; it must be one pose for each");
    moved(&[0, 3], "primitives[1] is 3; the scene has 3 primitives");
    moved(&[2, 2], "primitives[1] is 2, as is primitives[0]; a primitive can be moved once");
}

#[test]
fn scans_that_write_nothing() {
    let scene = Scene::new(vec![primitive(Shape::Box, [0.0; 3], [1.0; 3])]).unwrap();
    let pattern = pattern(spec(vec![0.1, 0.0], 3));
    let one = &[Pose::IDENTITY][..];
    for count in [0, 2, 4] {
        let mut images = Images::new(2, 3);
        let message = format!("there are {count} poses for a scan; it must be 1, or 3, one for each column");
        says(scan(&scene, &pattern, &[Pose::IDENTITY; 4][..count], 0, &mut images.as_mut(), None, 1), &message);
        says(
            scan_batch(&scene, &pattern, &[one], 0, &mut [], None, 1),
            "there are poses for 1 scans and images for 0; there must be as many",
        );
        assert_eq!(images, Images::new(2, 3));
    }
    let cut = |change: &dyn Fn(&mut Images), image: &str| {
        let mut images = Images::new(2, 3);
        change(&mut images);
        let before = images.clone();
        let message = format!("the {image} image has 5 pixels; the sensor has 2 beams and 3 columns");
        says(scan(&scene, &pattern, one, 0, &mut images.as_mut(), None, 1), &message);
        says(scan_batch(&scene, &pattern, &[one], 0, &mut [images.as_mut()], None, 1), &message);
        assert_eq!(images, before);
    };
    cut(&|images| images.depth.truncate(5), "depth");
    cut(&|images| images.label.truncate(5), "label");
    cut(&|images| images.instance.truncate(5), "instance");
    cut(&|images| images.primitive.truncate(5), "primitive");
    cut(&|images| images.incidence.truncate(5), "incidence");
    cut(&|images| images.normal.truncate(5), "normal");
}

#[test]
fn backends() {
    for backend in Backend::available() {
        assert_eq!(backend.name().parse(), Ok(backend));
    }
    let error = "fastest".parse::<Backend>().unwrap_err().to_string();
    assert!(error.starts_with("backend is \"fastest\"; it must be one of "), "{error}");
    assert!(error.ends_with("reference"), "{error}");
}

#[test]
fn rays() {
    let scene = Scene::new(vec![]).unwrap();
    let (zero, x) = ([0.0; 3], [1.0, 0.0, 0.0]);
    let rays =
        |origin, direction, message: &str| says(cast(&scene, &[zero, origin], &[x, direction], 9.0, 0, 1), message);
    says(cast(&scene, &[zero], &[x, x], 9.0, 0, 1), "there are 1 origins and 2 directions; there must be as many");
    let far = "m; every coordinate must be finite and at most 1e9 in size";
    rays([f64::NAN, 0.0, 0.0], x, &format!("origins[1] is [NaN, 0.0, 0.0] {far}"));
    rays([0.0, 2e9, 0.0], x, &format!("origins[1] is [0.0, 2000000000.0, 0.0] {far}"));
    rays(zero, [0.0, f64::INFINITY, 0.0], "directions[1] is [0.0, inf, 0.0]; it must be finite and not 0");
    rays(zero, [0.0, -0.0, 0.0], "directions[1] is [0.0, -0.0, 0.0]; it must be finite and not 0");
    for range in [0.0, -1.0, f64::NAN] {
        let message = format!("max_range is {range} m; it must be greater than 0");
        says(cast(&scene, &[zero], &[x], range, 0, 1), &message);
    }
}

#[test]
fn borders_of_the_border_are_named() {
    let shape = crate::Error::TableShape { table: "centers".into(), shape: vec![4, 2], expected: "[P, 3]".into() };
    assert_eq!(shape.to_string(), "centers has the shape [4, 2]; it must be [P, 3]");
    let source = TriangleMesh::new(vec![], vec![]).unwrap_err();
    let mesh = crate::Error::Mesh { mesh: 3, source: Box::new(source) };
    assert!(mesh.to_string().starts_with("meshes[3]: the mesh has 0 vertices"));
    let source = Box::new(crate::Error::PoseMirrored { determinant: -1.0 });
    let pose = crate::Error::PoseOfTable { table: "world_from_sensor", index: vec![2, 7], source };
    assert!(pose.to_string().starts_with("world_from_sensor[2, 7]: the rotation of the pose has"));
    let seed = crate::Error::Seed { seed: -1 };
    assert_eq!(seed.to_string(), "seed is -1; it must be 0 or more");
    let threads = crate::Error::Threads { threads: -1, limit: 1024 };
    assert_eq!(threads.to_string(), "threads is -1; it must be 0 (all cores) to 1024");
}
