//! Wavefront OBJ files.

use std::path::PathBuf;

use crate::{Error, ObjMesh, Result, read_obj};

/// Reads a text as an OBJ file; `name` keeps tests that run at once apart.
fn read(name: &str, text: &str) -> Result<Vec<ObjMesh>> {
    let file = format!("lidardraft-{}-{name}.obj", std::process::id());
    let path = std::env::temp_dir().join(file);
    std::fs::write(&path, text).unwrap();
    let meshes = read_obj(&path);
    std::fs::remove_file(&path).unwrap();
    meshes
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn objects_and_materials_without_a_library() {
    let text = format!(
        "mtllib missing.mtl\n{QUAD}v 0.1234567890123 0 5\no car\nusemtl dark paint\nf 1 2 3\nusemtl glass\nf 1 3 4\n\
         o tree\nf 1 2 5\n"
    );
    let meshes = read("objects", &text).unwrap();
    let names: Vec<_> = meshes.iter().map(|m| (m.object.as_str(), m.material.as_str())).collect();
    assert_eq!(names, [("car", "dark paint"), ("car", "glass"), ("tree", "glass")]);
    assert_eq!(meshes[2].vertices[2], [0.123_456_789_012_3, 0.0, 5.0]);
}

#[test]
fn shared_positions_stay_shared() {
    let seams = "vt 0 0\nvt 1 1\nvn 0 0 1\nvn 0 1 0\nf 1/1/1 2/2/1 3/1/1\nf 1/2/2 3/2/2 4/1/2\n";
    let meshes = read("shared", &format!("{QUAD}{seams}")).unwrap();
    assert_eq!((meshes[0].object.as_str(), meshes[0].material.as_str()), ("unnamed_object", ""));
    assert_eq!(meshes[0].vertices.len(), 4);
    assert_eq!((&meshes[0].corners[..], &meshes[0].counts[..]), (&[0, 1, 2, 0, 2, 3][..], &[3, 3][..]));
}

#[test]
fn polygons_stay_polygons_and_lines_are_passed_over() {
    let text = format!("{QUAD}v 0 0.5 0\nf 1 2 3 4 5\nl 1 2\nf -5 -4 -3 -2\n");
    let meshes = read("polygons", &text).unwrap();
    assert_eq!((&meshes[0].corners[..], &meshes[0].counts[..]), (&[0, 1, 2, 3, 4, 0, 1, 2, 3][..], &[5, 4][..]));
}

#[test]
fn a_line_goes_on_after_a_backslash() {
    let text =
        format!("{QUAD}g house\r\nusemtl red\r\nf 1 2 3\r\nusemtl \r\n# C:\\models\\\r\nf 1 \\\r\n3 \\\r\n 4\r\n");
    let meshes = read("continued", &text).unwrap();
    let found: Vec<_> = meshes.iter().map(|m| (m.object.as_str(), m.material.as_str(), m.counts.len())).collect();
    assert_eq!(found, [("house", "red", 1), ("house", "", 1)]);
    for (name, end, line) in [("inside", "f 1 2 x\n", 13), ("at_its_end", "f 1 2 9", 12)] {
        match read(name, &format!("{text}{end}")) {
            Err(Error::ObjBroken { line: found, .. }) => assert_eq!(found, line, "{name}"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn missing_file() {
    let error = read_obj(&PathBuf::from("/does/not/exist.obj")).unwrap_err();
    assert!(matches!(error, Error::ObjUnreadable { .. }));
    assert!(error.to_string().starts_with("/does/not/exist.obj: "));
}

#[test]
fn broken_lines_are_named() {
    for (name, text, line) in [
        ("empty_face", "v 0 0 0\nf\n", 2),
        ("vertex", "v 0 0 0\nv 1 zero 0\n", 2),
        ("face", "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 x\n", 5),
    ] {
        match read(name, text) {
            Err(Error::ObjBroken { line: found, .. }) => assert_eq!(found, line),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn face_of_a_missing_vertex() {
    for face in ["f 1 2 9\n", "f 1 2 0\n", "f 1 2 -9\n"] {
        let result = read("index", &format!("{QUAD}{face}"));
        assert!(matches!(result, Err(Error::ObjBroken { .. })), "{face}: {result:?}");
    }
}

#[test]
fn vertex_that_is_not_finite() {
    let error = read("nan", &format!("{QUAD}v nan 0 0\no car\nf 1 2 5\n")).unwrap_err();
    assert!(matches!(error, Error::ObjMesh { .. }));
    let message = error.to_string();
    assert!(message.ends_with("object \"car\": vertex 2 is [NaN, 0.0, 0.0]; coordinates must be finite"), "{message}");
}

#[test]
fn no_faces() {
    for (name, text) in [("empty", ""), ("points", QUAD), ("lines", "v 0 0 0\nv 1 0 0\nl 1 2\n")] {
        let error = read(name, text).unwrap_err();
        assert!(matches!(error, Error::ObjWithoutFaces { .. }));
        assert!(error.to_string().ends_with("has no faces; it needs at least one"));
    }
}
