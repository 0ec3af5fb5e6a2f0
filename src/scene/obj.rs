//! Wavefront OBJ: triangle meshes with their materials, and Bézier and B-spline surfaces with their trims.
//!
//! The parser is our own because tobj 4.0.5 has several problems. Its errors have no line. It accepts NaN, index 0 of
//! a normal, and faces of two corners. It panics on some indices and reads lines of any length into memory. It
//! numbers positions group by group, which tears meshes of several groups apart.

mod freeform;
mod material;
mod polygon;
mod reader;
mod write;

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::file::{check_is_file, unreadable};
use super::{Material, Paint, Surface};
use crate::error::Result;
use crate::mesh::{Corner, CreaseAngle, Mesh, SharedBorders, Smoothing, weld};
use crate::scene::MeshModel;
use material::Materials;
use reader::Obj;
pub(super) use write::surface_text;

/// The content of a file.
pub(super) struct ObjScene {
    /// Its free-form surfaces. Bézier patches of the same degree share a surface; they come first.
    pub(super) surfaces: Vec<Surface>,
    /// Its faces.
    pub(super) model: Option<MeshModel>,
    /// The file itself, its material libraries and their pictures.
    pub(super) files: Vec<PathBuf>,
}

/// Reads a file's surfaces and faces; a file without any of them is refused.
pub(super) fn load(path: &Path, crease: CreaseAngle, smoothing: Smoothing) -> Result<ObjScene> {
    scene_of(open(path)?, path, crease, smoothing)
}

/// The same for a text; `path` appears in error messages, and material libraries are searched for beside it.
pub(super) fn parse(
    text: &str,
    path: &Path,
    crease: CreaseAngle,
    smoothing: Smoothing,
) -> Result<ObjScene> {
    scene_of(Obj::read(text.as_bytes(), path)?, path, crease, smoothing)
}

/// Whether a text begins with a statement of OBJ, after any comments.
pub(super) fn is_obj(text: &str) -> bool {
    const KEYWORDS: [&str; 14] =
        ["v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl", "cstype", "deg"];
    let mut lines = text.lines().map(str::trim);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or_default();
    let mut words = first.split_whitespace();
    // A key of TOML is followed by an equals sign.
    words.next().is_some_and(|word| KEYWORDS.contains(&word))
        && words.next().is_none_or(|word| !word.starts_with('='))
}

fn scene_of(
    mut obj: Obj,
    path: &Path,
    crease: CreaseAngle,
    smoothing: Smoothing,
) -> Result<ObjScene> {
    let mut materials = Materials::default();
    for library in std::mem::take(&mut obj.libraries) {
        materials.read(&material::beside(path, &library));
    }
    let names = std::mem::take(&mut obj.material_names);
    let surfaces = obj.take_surfaces(path)?;
    let mut files = vec![path.to_owned()];
    files.append(&mut materials.files);
    if obj.triangles.is_empty() && !surfaces.is_empty() {
        return Ok(ObjScene { surfaces, model: None, files });
    }
    let (mesh, of_triangles) = mesh_of(obj, path, crease)?;
    let mut model = MeshModel::new(mesh, smoothing);
    if !model.mesh().mesh().colors().is_empty() {
        model.paint = Paint::Color([1.0; 3]);
    }
    // Counting them takes time.
    if log::log_enabled!(log::Level::Info) {
        let shared = model.mesh().shared_borders();
        if shared != SharedBorders::default() {
            log::info!("{}: {shared}; they are borders", path.display());
        }
    }
    let unknown: Vec<&str> = names
        .iter()
        .filter(|name| !name.is_empty() && materials.paint(name).is_none())
        .map(String::as_str)
        .collect();
    if !unknown.is_empty() && !materials.files.is_empty() {
        let path = path.display();
        log::warn!("{path}: no material library has {}; it is grey", unknown.join(", "));
    }
    for run in of_triangles.chunk_by(|a, b| a.material == b.material) {
        let name = &names[run[0].material as usize];
        let Some(paint) = materials.paint(name) else { continue };
        let last = run[run.len() - 1];
        let triangles = run[0].first..last.first + last.count;
        model.materials.push(Material { name: name.clone(), paint: paint.clone(), triangles });
    }
    Ok(ObjScene { surfaces, model: Some(model), files })
}

/// Reads a file's free-form surfaces; a file without any is refused.
pub(super) fn load_surfaces(path: &Path) -> Result<Vec<Surface>> {
    let surfaces = open(path)?.take_surfaces(path)?;
    if surfaces.is_empty() {
        return Err(unreadable(
            path,
            "it has no free-form surface; expected the file of a [[mesh]]",
        ));
    }
    Ok(surfaces)
}

/// Consecutive triangles of one material.
#[derive(Debug, Clone, Copy)]
struct Run {
    material: u32,
    first: usize,
    count: usize,
}

fn open(path: &Path) -> Result<Obj> {
    check_is_file(path)?;
    let file = std::fs::File::open(path).map_err(|error| unreadable(path, error))?;
    Obj::read(BufReader::with_capacity(1 << 16, file), path)
}

/// The mesh of the faces that were read, with its triangles in the order of their materials.
fn mesh_of(obj: Obj, path: &Path, crease: CreaseAngle) -> Result<(Mesh, Vec<Run>)> {
    if obj.triangles.is_empty() {
        return Err(unreadable(path, obj.without_faces()));
    }
    let Obj { mut positions, normals, coordinates, colors, mut triangles, mut runs, .. } = obj;
    positions.shrink_to_fit();
    let dropped = weld(&positions, &mut triangles);
    if !dropped.is_empty() {
        let path = path.display();
        let count = counted(dropped.len(), "triangle");
        log::info!("{path}: {count} with the same position twice left out");
    }
    if triangles.is_empty() {
        let reason =
            format!("of {} each has the same position twice", counted(dropped.len(), "triangle"));
        return Err(unreadable(path, reason));
    }
    // A triangle that is dropped shortens the range of its material.
    let mut gone = dropped.iter().map(|triangle| *triangle as usize).peekable();
    let mut next = 0;
    for run in &mut runs {
        let end = run.first + run.count;
        while gone.next_if(|triangle| *triangle < end).is_some() {
            run.count -= 1;
        }
        run.first = next;
        next += run.count;
    }
    runs.retain(|run| run.count > 0);
    if !runs.is_sorted_by_key(|run| run.material) {
        runs.sort_by_key(|run| run.material);
        let sorted = runs.iter().flat_map(|run| &triangles[run.first..run.first + run.count]);
        triangles = sorted.copied().collect();
        let mut next = 0;
        for run in &mut runs {
            run.first = next;
            next += run.count;
        }
    }
    triangles.shrink_to_fit();
    let mesh = Mesh::new(positions, normals, coordinates, triangles, crease)
        .and_then(|mesh| mesh.with_colors(colors))
        .map_err(|error| unreadable(path, error))?;
    Ok((mesh, runs))
}

/// A count with its noun: "1 line", "3 surfaces".
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

impl Mesh {
    /// Reads the faces of a Wavefront OBJ file; see [`Mesh::read_obj`].
    ///
    /// # Errors
    /// A file that cannot be read or is not a mesh; with the line.
    pub fn load_obj(path: &Path, crease: CreaseAngle) -> Result<Self> {
        mesh_of(open(path)?, path, crease).map(|(mesh, _)| mesh)
    }

    /// Reads the faces of Wavefront OBJ, without their materials. `path` appears in error messages.
    ///
    /// Faces of more than three corners may be concave; they are cut into triangles that keep the edges of the face.
    /// Equal positions are merged; triangles that have the same position twice are left out. Missing normals are
    /// computed up to creases, as in [`Mesh::new`]. A byte order mark is skipped. A line that ends in `\` continues
    /// on the next line. Indices may refer to elements further down in the file.
    ///
    /// # Errors
    /// With the line: a line of more than 1 MiB, a number that is malformed or not finite, a position beyond 1e15, a
    /// face of fewer than three corners, an index of 0 or of an element that does not exist, too many faces, a
    /// malformed free-form curve or surface. Without the line: no face, too many vertices.
    pub fn read_obj(text: impl BufRead, path: &Path, crease: CreaseAngle) -> Result<Self> {
        mesh_of(Obj::read(text, path)?, path, crease).map(|(mesh, _)| mesh)
    }

    /// Writes Wavefront OBJ that reads back as exactly the same values.
    ///
    /// # Errors
    /// The errors of `out`.
    pub fn write_obj(&self, out: &mut impl Write) -> std::io::Result<()> {
        for (position, DVec3 { x, y, z }) in self.positions().iter().enumerate() {
            match self.colors().get(position) {
                Some([red, green, blue]) => writeln!(out, "v {x} {y} {z} {red} {green} {blue}")?,
                None => writeln!(out, "v {x} {y} {z}")?,
            }
        }
        for DVec2 { x, y } in self.coordinates() {
            writeln!(out, "vt {x} {y}")?;
        }
        for DVec3 { x, y, z } in self.normals() {
            writeln!(out, "vn {x} {y} {z}")?;
        }
        for corners in self.triangles() {
            out.write_all(b"f")?;
            for Corner { position, normal, coordinate } in corners {
                // Indices in files start at 1.
                let (position, normal) = (position + 1, normal + 1);
                if *coordinate == Corner::NONE {
                    write!(out, " {position}//{normal}")?;
                } else {
                    write!(out, " {position}/{}/{normal}", coordinate + 1)?;
                }
            }
            out.write_all(b"\n")?;
        }
        Ok(())
    }
}
