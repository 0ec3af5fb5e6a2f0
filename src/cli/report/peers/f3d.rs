//! F3D, a viewer that meshes CAD files, by its Python module.

use std::path::Path;
use std::process::Command;

use super::process::run;

/// Shows a file and prints times.
const SCRIPT: &str = include_str!("in_f3d.py");

/// How F3D shows a file. Times are in milliseconds.
#[derive(Debug, Clone, Copy)]
pub(in crate::cli::report) struct Shown {
    /// Reading and meshing the file.
    pub(in crate::cli::report) load: f64,
    /// The first picture after that.
    pub(in crate::cli::report) first: f64,
    /// The median of further pictures, with a moving camera.
    pub(in crate::cli::report) frame: f64,
    /// The most memory of the whole program, in bytes.
    pub(in crate::cli::report) memory: Option<u64>,
}

/// The version of F3D. The error is a text for a note.
pub(in crate::cli::report) fn version() -> Result<String, String> {
    let output =
        Command::new("python3").args(["-c", "import f3d; print(f3d.__version__)"]).output();
    let output = output.map_err(|error| format!("python3 cannot be started: {error}"))?;
    if !output.status.success() {
        return Err("the Python module f3d is not installed (pip install f3d)".into());
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Shows a file in pictures of `size`, one and then `frames` more. The error is a text for a note.
pub(in crate::cli::report) fn show(
    file: &Path,
    (width, height): (u32, u32),
    frames: usize,
) -> Result<Shown, String> {
    let mut command = Command::new("python3");
    command.args(["-c", SCRIPT]).arg(file);
    command.args([width.to_string(), height.to_string(), frames.to_string()]);
    let ended = run(&mut command)?;
    Ok(Shown {
        load: ended.value("load")?,
        first: ended.value("first")?,
        frame: ended.value("frame")?,
        memory: ended.memory,
    })
}
