//! Where scenes come from: files, or standard input.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::{Error, Result};
use clap::Args;
use freeform_surface::{Cause, CreaseAngle, LoadOptions, Scene, UpAxis};

/// What stands for standard input on the command line.
const STANDARD: &str = "-";
/// More of standard input than this is refused, as of a file.
const MAX_BYTES: u64 = 64 << 20;

/// How scenes are read; it wins over what they say.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct LoadArguments {
    /// The axis that stands upright where a scene has no camera: y or z. Otherwise the scene's, or z
    /// if there is nothing but patches of .bpt files, or y.
    #[arg(long, value_name = "AXIS", value_parser = up_axis)]
    up: Option<UpAxis>,

    /// Where a mesh's file has no normals: the angle between triangles, 0 to 180, beyond which their
    /// edge stays a crease; instead of the scene's, which is 30 if it does not say.
    #[arg(long, value_name = "D", value_parser = crease_angle, allow_negative_numbers = true)]
    crease_degrees: Option<CreaseAngle>,
}

fn up_axis(text: &str) -> Result<UpAxis, String> {
    text.parse().map_err(|_| "expected y or z".into())
}

pub(crate) fn crease_angle(text: &str) -> Result<CreaseAngle, String> {
    text.parse()
        .ok()
        .and_then(|degrees| CreaseAngle::new(degrees).ok())
        .ok_or_else(|| "expected a number of degrees from 0 to 180".into())
}

impl LoadArguments {
    /// Reads the scene of a file, or of standard input.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub(crate) fn load(self, path: &Path) -> Result<Scene> {
        let options = LoadOptions { crease: self.crease_degrees, up: self.up };
        if !is_standard(path) {
            return Ok(Scene::load_with(path, &options)?);
        }
        let name = Path::new("standard input");
        let fail = |cause: Cause| Error::file("read", name, cause);
        let mut bytes = Vec::new();
        std::io::stdin()
            .lock()
            .take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| fail(error.into()))?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(fail(format!("it has more than {MAX_BYTES} bytes").into()));
        }
        let text = String::from_utf8(bytes).map_err(|_| fail("it is not text".into()))?;
        if text.trim().is_empty() {
            return Err(fail("it is empty".into()));
        }
        Ok(Scene::from_text(&text, name, &options)?)
    }
}

/// Whether a scene is read from standard input.
pub(crate) fn is_standard(path: &Path) -> bool {
    path == Path::new(STANDARD)
}

/// Refuses to read standard input for two scenes.
///
/// # Errors
/// Two scenes that are `-`.
pub(crate) fn check(scenes: &[PathBuf]) -> Result<()> {
    match scenes.iter().filter(|scene| is_standard(scene)).count() {
        0 | 1 => Ok(()),
        count => {
            Err(Error::invalid("scenes", format!("\"-\" {count} times"), "standard input once"))
        }
    }
}
