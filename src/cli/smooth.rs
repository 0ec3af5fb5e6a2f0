//! `freeform smooth`: reads a triangle mesh and writes a finer and smoother one.

use std::io::{BufWriter, Write as _};
use std::path::Path;

use crate::io::{Error, Result};
use freeform_surface::{Mesh, Smoothing, smooth};

use super::{SmoothArguments, SmoothMethod};
use crate::io::output::{Output, replace};
use crate::io::say;

/// Reads the mesh, smooths it and writes it.
///
/// # Errors
/// The mesh cannot be read, smoothed or written.
pub(super) fn run(arguments: &SmoothArguments) -> Result<()> {
    let SmoothArguments { input, method, alpha, steps, crease_degrees, output } = arguments;
    let smoothing = match (method, alpha) {
        (SmoothMethod::Pn, None) => Smoothing::Pn,
        (SmoothMethod::Pn, Some(_)) => {
            return Err(Error::invalid(
                "--alpha",
                "given for curved PN triangles",
                "--method phong",
            ));
        }
        (SmoothMethod::Phong, alpha) => Smoothing::Phong(alpha.unwrap_or_default()),
    };
    let to_standard = output == Path::new("-");
    if !to_standard {
        Output::File(output.clone()).check_keeps(std::slice::from_ref(input))?;
    }
    let mesh = Mesh::load_obj(input, crease_degrees.unwrap_or_default())?;
    let before = mesh.triangles().len();
    let smoothed = smooth(mesh, smoothing, *steps)
        .map_err(|error| Error::file("smooth", input.clone(), error))?;
    let written = if to_standard {
        let mut out = BufWriter::new(std::io::stdout().lock());
        smoothed.write_obj(&mut out).and_then(|()| out.flush())
    } else {
        replace(output, |file| smoothed.write_obj(file))
    };
    let place = if to_standard { Path::new("standard output") } else { output };
    written.map_err(|error| Error::file("write", place, error))?;
    let line = format!(
        "wrote {}: {before} triangles became {}",
        if to_standard { "standard output".into() } else { output.display().to_string() },
        smoothed.triangles().len(),
    );
    // Standard output carries only the mesh.
    if to_standard {
        eprintln!("{line}");
        Ok(())
    } else {
        say(line)
    }
}
