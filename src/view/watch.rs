//! Tells when a file changes on the disk.

use std::path::Path;

use freeform_surface::{Error, Result};
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher as _};

/// Watches one file until it is dropped.
pub(super) struct Watch {
    _watcher: RecommendedWatcher,
}

impl Watch {
    /// Calls `tell` on a thread of its own whenever the file may have changed.
    ///
    /// # Errors
    /// The system cannot watch the file's folder.
    pub(super) fn new(file: &Path, tell: impl Fn() + Send + 'static) -> Result<Self> {
        let fail = |error: notify::Error| Error::File {
            action: "watch",
            path: file.to_owned(),
            reason: error.to_string(),
        };
        let name = file.file_name().map(ToOwned::to_owned);
        let mut watcher = notify::recommended_watcher(move |event: notify::Result<Event>| {
            // Reading it is no change.
            let changed = event.is_ok_and(|event| {
                let own = |path: &std::path::PathBuf| path.file_name() == name.as_deref();
                !event.kind.is_access() && event.paths.iter().any(own)
            });
            if changed {
                tell();
            }
        })
        .map_err(fail)?;
        // The folder and not the file: editors put another file in its place.
        let folder = match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        watcher.watch(folder, RecursiveMode::NonRecursive).map_err(fail)?;
        Ok(Self { _watcher: watcher })
    }
}
