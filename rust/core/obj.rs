//! Wavefront OBJ files in.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::{Error, Result};

/// The library of all materials, named at the start of the text for `tobj`.
const LIBRARY: &str = "lidardraft names";

/// A named part of an OBJ file: the faces of one object (`o` or `g`) with one material (`usemtl`).
#[derive(Clone, Debug, PartialEq)]
pub struct ObjMesh {
    /// The name of the object; "unnamed_object" for faces before the first one.
    pub object: String,
    /// The name of the material as in the file; "" if it uses none.
    pub material: String,
    /// The positions that the faces refer to; every coordinate is finite.
    pub vertices: Vec<[f64; 3]>,
    /// The vertex numbers of all faces, in order.
    pub corners: Vec<u32>,
    /// The number of corners of each face, 3 or more.
    pub counts: Vec<u32>,
}

/// The objects of a Wavefront OBJ file, those with several materials as several entries.
///
/// Positions shared within an entry stay shared. Points, lines, normals and texture coordinates are ignored, and
/// material libraries are not opened: the names come from the OBJ file itself.
///
/// # Errors
/// [`Error::ObjUnreadable`], [`Error::ObjBroken`], [`Error::ObjMesh`] or [`Error::ObjWithoutFaces`]. A face with a
/// missing vertex is noticed at the end of its object, and that is the line in the message.
pub fn read_obj(path: &Path) -> Result<Vec<ObjMesh>> {
    let mut text = Vec::new();
    File::open(path)
        // no more than its size: some system files are regular, empty and endless
        .and_then(|file| file.metadata().map(|data| file.take(data.len())))
        .and_then(|mut file| file.read_to_end(&mut text))
        .map_err(|error| Error::ObjUnreadable { path: path.into(), reason: error.to_string() })?;
    let text = plain(&text);
    let materials = material_names(&text);
    let models = parse(&text, &materials).map_err(|(line, error)| Error::ObjBroken {
        path: path.into(),
        line,
        reason: error.to_string(),
    })?;
    let with_faces = models.into_iter().filter(|model| !model.mesh.indices.is_empty());
    let meshes: Vec<ObjMesh> = with_faces.map(|model| named_mesh(path, model, &materials)).collect::<Result<_>>()?;
    if meshes.is_empty() {
        return Err(Error::ObjWithoutFaces { path: path.into() });
    }
    Ok(meshes)
}

/// The text for `tobj`, after a line that names `LIBRARY`, with as many lines. Lines that end in a backslash continue
/// in the next one, unless they are comments. A `usemtl` without a name, as Rhino writes it, names a material of no
/// library.
fn plain(text: &[u8]) -> Vec<u8> {
    let (mut plain, mut joined) = (format!("mtllib {LIBRARY}\n").into_bytes(), 0);
    plain.reserve(text.len());
    for line in text.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii) {
        let begun = line.strip_suffix(b"\\").filter(|_| !line.starts_with(b"#"));
        plain.extend_from_slice(match line {
            b"usemtl" => b"usemtl /",
            b"f" => b"f nothing", // which it would take for a face
            _ => begun.unwrap_or(line),
        });
        joined += 1;
        plain.extend(std::iter::repeat_n(b'\n', if begun.is_some() { 0 } else { std::mem::take(&mut joined) }));
        plain.extend(begun.map(|_| b' '));
    }
    plain.pop(); // the text ends at its original end
    plain
}

/// The material names that the faces use, in order of their first use.
fn material_names(text: &[u8]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for line in String::from_utf8_lossy(text).lines() {
        let name = line.strip_prefix("usemtl ").unwrap_or_default().trim();
        if !["", "/"].contains(&name) && !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }
    names
}

/// The models of a `plain` text, or the line of the error: the last one that was read.
///
/// `tobj` forgets the name of a material that no library defines. So `LIBRARY` has all materials of the text, and the
/// libraries of the text have none.
fn parse(text: &[u8], materials: &[String]) -> std::result::Result<Vec<tobj::Model>, (usize, tobj::LoadError)> {
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let mut left = text;
    let library = |path: &Path| {
        let known = if path == Path::new(LIBRARY) { materials } else { &[] };
        let named = |name: &String| tobj::Material { name: name.clone(), ..Default::default() };
        let index: HashMap<String, usize> = known.iter().cloned().zip(0..).collect();
        Ok((known.iter().map(named).collect(), index))
    };
    match tobj::load_obj_buf(&mut left, &options, library) {
        Ok((models, _)) => Ok(models),
        Err(error) => {
            let ended = text[..text.len() - left.len()].iter().filter(|&&byte| byte == b'\n').count();
            Err((ended.saturating_sub(1).max(1), error))
        }
    }
}

fn named_mesh(path: &Path, model: tobj::Model, materials: &[String]) -> Result<ObjMesh> {
    let (vertices, corners) = (model.mesh.positions.as_chunks().0.to_vec(), model.mesh.indices);
    if let Some(vertex) = vertices.iter().position(|place: &[f64; 3]| !place.iter().all(|x| x.is_finite())) {
        let source = Box::new(Error::VertexNotFinite { vertex, position: vertices[vertex] });
        return Err(Error::ObjMesh { path: path.into(), object: model.name, source });
    }
    let mut counts = model.mesh.face_arities;
    counts.retain(|&count| count > 0);
    if counts.is_empty() {
        counts = vec![3; corners.len() / 3];
    }
    let material = model.mesh.material_id.and_then(|id| materials.get(id));
    let material = material.cloned().unwrap_or_default();
    Ok(ObjMesh { object: model.name, material, vertices, corners, counts })
}
