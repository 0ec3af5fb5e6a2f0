//! OCCT's mesher, by the helper program `freeform-occt`.

use std::path::{Path, PathBuf};
use std::process::Command;

use freeform_surface::model::find_helper;

use super::process::run;

/// OCCT's mesh of a file.
#[derive(Debug, Clone, Copy)]
pub(in crate::cli::report) struct Meshed {
    /// The time of meshing alone, in milliseconds.
    pub(in crate::cli::report) ms: f64,
    /// The triangles in all places.
    pub(in crate::cli::report) triangles: u64,
    /// The largest distance, in the model's unit, of a surface from the planes of its triangles and of an edge from its
    /// lines. The surface is evaluated at the mean (u, v) of the corners and of the ends of the sides, the edge at the
    /// mean parameter.
    pub(in crate::cli::report) distance: f64,
}

/// The helper. The error is a text for a note.
pub(in crate::cli::report) fn helper() -> Result<PathBuf, String> {
    find_helper().ok_or_else(|| "freeform-occt is not found (sh setup.sh cad)".into())
}

/// Meshes a file with an absolute deflection in the model's unit. The error is a text for a note.
pub(in crate::cli::report) fn mesh(
    helper: &Path,
    file: &Path,
    deflection: f64,
) -> Result<Meshed, String> {
    let ended = run(Command::new(helper).arg("--mesh").arg(deflection.to_string()).arg(file))?;
    Ok(Meshed {
        ms: ended.value("milliseconds")?,
        triangles: ended.value("triangles")? as u64,
        distance: ended.value("surface")?.max(ended.value("edge")?),
    })
}
