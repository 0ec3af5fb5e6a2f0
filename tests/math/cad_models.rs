//! Models from CAD files: every face is drawn, its edges lie on the curves in space, and its area is that of OCCT.

use std::path::{Path, PathBuf};
use std::process::Command;

use freeform_surface::model::{DrawnFace, Model};

/// Largest distances are shares of the diagonal of the model.
const MAX_DISTANCE: f64 = 1e-6;
/// Of the area of a model.
const MAX_AREA_ERROR: f64 = 1e-4;
/// Of the area of a face. Faces may also be off by a millionth of the area of the model.
const MAX_FACE_ERROR: f64 = 1e-3;

/// The files in the folder of CAD data, and the reader of CAD files. `None` where one is missing.
fn files() -> Option<(PathBuf, Vec<PathBuf>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let reader = root.join("cad/build/freeform-occt");
    let folders = [root.join("shared/data/cad"), root.join("../shared/data/cad")];
    let folder = folders.iter().find(|folder| folder.is_dir());
    let (true, Some(folder)) = (reader.is_file(), folder) else {
        println!("skipped: no CAD files or no {}", reader.display());
        return None;
    };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    Some((reader, files))
}

/// What the reader prints about a file. `None` if it cannot read it.
fn read(reader: &Path, file: &Path, areas: bool) -> Option<String> {
    let mut command = Command::new(reader);
    if areas {
        command.arg("--area");
    }
    let output = command.arg(file).output().unwrap();
    let is_read = output.status.success() && !output.stdout.is_empty();
    is_read.then(|| String::from_utf8(output.stdout).unwrap())
}

/// All faces of a model.
fn drawn(model: &Model, name: &str) -> Vec<DrawnFace> {
    let faces = model.drawn_faces().into_iter();
    faces.map(|face| face.unwrap_or_else(|error| panic!("{name}: {error}"))).collect()
}

/// Checks the edges of faces. Where a curve is off its surface, so is the edge.
fn check_edges(model: &Model, faces: &[DrawnFace], name: &str) {
    let diagonal = model.diagonal();
    for (number, face) in faces.iter().enumerate() {
        for deviation in model.deviations(number, face, diagonal) {
            let most = MAX_DISTANCE * diagonal + deviation.surface;
            assert!(
                deviation.drawn <= most,
                "{name}: face {number}: {deviation:?}, size {diagonal}"
            );
        }
    }
}

#[test]
fn faces_of_cad_files() {
    let Some((reader, files)) = files() else { return };
    let mut read_files = 0;
    for file in files {
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        let Some(text) = read(&reader, &file, false) else {
            println!("{name}: not read");
            continue;
        };
        read_files += 1;
        let mut model = Model::from_text(&text, &file).unwrap();
        let faces = drawn(&model, &name);
        check_edges(&model, &faces, &name);

        let areas = read(&reader, &file, true).unwrap();
        let areas = areas.lines().map(|line| line.split_whitespace().last().unwrap());
        let areas: Vec<f64> = areas.map(|area| area.parse().unwrap()).take(faces.len()).collect();
        let total: f64 = areas.iter().sum();
        let (mut own, mut other) = (0.0, 0.0);
        for (number, (face, area)) in faces.iter().zip(&areas).enumerate() {
            let found = face.area();
            // OCCT takes areas from its p-curves, which may be wrong.
            let refused = |edge: &freeform_surface::model::DrawnEdge| {
                edge.source == freeform_surface::model::PcurveSource::Refused
            };
            if face.edges.iter().any(refused) {
                continue;
            }
            own += found;
            other += area;
            assert!(
                (found - area).abs() <= (MAX_FACE_ERROR * area).max(1e-6 * total),
                "{name}: face {number}: {found}, not {area}"
            );
        }
        assert!((own - other).abs() <= MAX_AREA_ERROR * other, "{name}: {own}, not {other}");

        // The same without any p-curve, as most files are.
        for coedge in model.faces.iter_mut().flat_map(|face| face.loops.iter_mut().flatten()) {
            coedge.pcurve = None;
        }
        let projected = drawn(&model, &name);
        check_edges(&model, &projected, &name);
        for (number, (one, other)) in faces.iter().zip(&projected).enumerate() {
            let (one, other) = (one.area(), other.area());
            assert!(
                (one - other).abs() <= (MAX_FACE_ERROR * one).max(1e-6 * total),
                "{name}: face {number} without p-curves: {other}, not {one}"
            );
        }
    }
    assert!(read_files > 0);
}
