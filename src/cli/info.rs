//! `freeform info`: the driver, its limits, and a check that it draws correctly.

use super::check;
use crate::io::Result;
use crate::io::say;
use freeform_surface::inspect::Need;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{Backend, Headless};

/// Prints the driver that the backend provides.
pub(super) fn print(backend: Backend) -> Result<()> {
    let context = Headless::new(backend)?;
    let info = context.info();
    let line = |name: &str, value: &str| say(format_args!("{name:36} {value}"));
    line("backend", &context.backend().to_string())?;
    line("renderer", &info.renderer)?;
    line("vendor", &info.vendor)?;
    line("version", &info.version)?;
    line("GLSL version", &info.glsl_version)?;
    for Need { what, limit, needed } in info.needs() {
        line(what, &format!("{limit} ({needed} needed)"))?;
    }
    line("largest picture", &format!("{0} × {0} pixels", info.max_size))?;
    line("largest texture", &format!("{0} × {0} texels", info.max_texture_size))?;
    line("samples a pixel", &info.max_samples.to_string())
}

/// Draws scenes with known results, and prints in one line whether the driver draws them correctly.
pub(super) fn print_check(backend: Backend) -> Result<()> {
    let context = Headless::new(backend)?;
    let checked = check::run(&context, Sources::default())?;
    say(format_args!("right on {}: {checked}", context.info()))
}
