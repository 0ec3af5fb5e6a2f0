//! SVG documents that scenes name.

use std::path::Path;

use crate::error::Result;
use crate::trim::TrimPath;

/// The paths of a document, and the names of the features that were ignored.
#[cfg(feature = "svg")]
pub(super) fn load(path: &Path) -> Result<(Vec<TrimPath>, Vec<&'static str>)> {
    let text = super::file::read_text(path)?;
    crate::trim::read_svg(&text).map_err(|error| super::file::unreadable(path, error))
}

#[cfg(not(feature = "svg"))]
pub(super) fn load(_: &Path) -> Result<(Vec<TrimPath>, Vec<&'static str>)> {
    Err(crate::error::Error::NotBuilt { what: "the reader of SVG documents", feature: "svg" })
}
