//! The scene files of folders.

use std::path::{Path, PathBuf};

use super::{Error, Result};
use freeform_surface::{CadModel, Cause};
use walkdir::WalkDir;

/// Whether a file's name has the extension of a scene.
pub(crate) fn is_scene(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    matches!(extension.as_deref(), Some("toml" | "bpt" | "obj")) || CadModel::is_file_of_one(path)
}

/// The scenes of a folder, and with `recursive` those of the folders in it; each folder is sorted by name. A folder that
/// cannot be read is an error among the scenes.
pub(crate) fn scenes_in(folder: &Path, recursive: bool) -> impl Iterator<Item = Result<PathBuf>> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let depth = if recursive { usize::MAX } else { 1 };
    let entries = WalkDir::new(folder).max_depth(depth).follow_links(true).sort_by_file_name();
    entries.into_iter().filter_map(|entry| match entry {
        Ok(entry) => {
            let is_one = entry.file_type().is_file() && is_scene(entry.path());
            is_one.then(|| Ok(entry.into_path()))
        }
        Err(error) => {
            let place = error.path().unwrap_or(Path::new(".")).to_owned();
            // A link to nothing may be a scene only if its name is one's.
            let is_other = error.depth() > 0 && place.is_symlink() && !is_scene(&place);
            let cause = match error.into_io_error() {
                Some(error) => Cause::from(error),
                None => "a link in it leads back to it".into(),
            };
            (!is_other).then(|| Err(Error::file("read", place, cause)))
        }
    })
}
