//! Reports changes of files on the disk.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::io::{Error, Result};
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher as _};

/// Watches files until it is dropped.
pub(super) struct Watch {
    _watcher: RecommendedWatcher,
}

impl Watch {
    /// Calls `tell` on a thread of its own whenever one of the files may have changed.
    ///
    /// # Errors
    /// The system cannot watch a file's folder.
    pub(super) fn new<'a>(
        files: impl Iterator<Item = &'a Path>,
        tell: impl Fn() + Send + 'static,
    ) -> Result<Self> {
        // Folders are watched and not files, because editors replace a file by another one.
        let mut folders = HashSet::new();
        let mut names: HashSet<(PathBuf, std::ffi::OsString)> = HashSet::new();
        for file in files {
            let folder = match file.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => folder,
                _ => Path::new("."),
            };
            // The system reports absolute paths, however the folder was named here.
            let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
            if let Some(name) = file.file_name() {
                names.insert((folder.clone(), name.to_owned()));
            }
            folders.insert(folder);
        }
        let mut watcher = notify::recommended_watcher(move |event: notify::Result<Event>| {
            // Reading a file does not change it.
            let changed = event.is_ok_and(|event| {
                let own = |path: &PathBuf| {
                    let place = path.parent().zip(path.file_name());
                    place.is_some_and(|(folder, name)| {
                        names.contains(&(folder.to_owned(), name.to_owned()))
                    })
                };
                !event.kind.is_access() && event.paths.iter().any(own)
            });
            if changed {
                tell();
            }
        })
        .map_err(|error| fail(Path::new("files"), error))?;
        for folder in folders {
            // A missing folder is reported when its file is read.
            if folder.is_dir() {
                watcher
                    .watch(&folder, RecursiveMode::NonRecursive)
                    .map_err(|error| fail(&folder, error))?;
            }
        }
        Ok(Self { _watcher: watcher })
    }
}

fn fail(path: &Path, error: notify::Error) -> Error {
    Error::file("watch", path, error)
}
