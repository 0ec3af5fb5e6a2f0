//! `freeform info`: the driver and its limits.

use super::say;
use freeform_surface::{Backend, Headless, Result};

/// Prints the driver that the backend gives.
pub(super) fn print(backend: Backend) -> Result<()> {
    let context = Headless::new(backend)?;
    let info = context.info();
    for (name, value) in [
        ("backend", context.backend().to_string()),
        ("renderer", info.renderer.clone()),
        ("vendor", info.vendor.clone()),
        ("version", info.version.clone()),
        ("GLSL version", info.glsl_version.clone()),
        ("patch vertices", format!("{} (25 needed)", info.max_patch_vertices)),
        ("tessellation level", format!("{} (64 needed)", info.max_tess_level)),
        (
            "storage blocks in the fragment stage",
            format!("{} (2 needed)", info.max_fragment_storage_blocks),
        ),
        ("largest picture", format!("{0} × {0} pixels", info.max_size)),
        ("largest texture", format!("{0} × {0} texels", info.max_texture_size)),
        ("samples a pixel", info.max_samples.to_string()),
    ] {
        say(format_args!("{name:36} {value}"))?;
    }
    Ok(())
}
