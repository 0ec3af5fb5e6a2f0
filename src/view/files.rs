//! Files beside a scene: the next scene of the folder, and unused names.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::io::scenes::scenes_in;
use crate::io::{Error, Result};

/// The scenes that follow the file in its folder. After the last one come those before the file; the file
/// itself is left out.
///
/// # Errors
/// The folder cannot be read, or contains no other scene.
pub(crate) fn next_scenes(file: Option<&Path>) -> Result<Vec<PathBuf>> {
    let folder = file.and_then(Path::parent).unwrap_or(Path::new(""));
    let mut unreadable = None;
    let found = scenes_in(folder, false);
    let mut scenes: Vec<PathBuf> =
        found.filter_map(|scene| scene.map_err(|error| unreadable = Some(error)).ok()).collect();
    let name = file.and_then(Path::file_name);
    if let Some(own) = scenes.iter().position(|scene| scene.file_name() == name) {
        scenes.rotate_left(own);
        scenes.remove(0);
    }
    if scenes.is_empty() {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        return Err(unreadable.unwrap_or_else(|| {
            Error::invalid(
                format!("folder {}", folder.display()),
                "without another scene",
                "a .toml, .bpt or .obj file, or a CAD model",
            )
        }));
    }
    Ok(scenes)
}

/// Creates a new empty file beside the scene. Its name consists of the scene's name, `added`, the first unused
/// number, and the extension.
///
/// # Errors
/// The folder is not writable.
pub(crate) fn new_file(scene: Option<&Path>, added: &str, extension: &str) -> Result<PathBuf> {
    let scene = scene.unwrap_or(Path::new("freeform"));
    let stem = scene.file_stem().unwrap_or(scene.as_os_str()).to_string_lossy();
    let mut number = 1_u64;
    loop {
        let path = scene.with_file_name(format!("{stem}-{added}{number:03}.{extension}"));
        match File::create_new(&path) {
            Ok(_) => return Ok(path),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
            Err(error) => {
                return Err(Error::file("write", path, error));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_follow_one_another_in_a_circle() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["b.toml", "a.bpt", "c.OBJ", "d.png", "e", "d.ffm", "f.STEP"] {
            std::fs::write(path(name), "x").unwrap();
        }
        std::fs::create_dir(path("f.toml")).unwrap();
        let next = next_scenes(Some(&path("b.toml"))).unwrap();
        assert_eq!(next, ["c.OBJ", "d.ffm", "f.STEP", "a.bpt"].map(path));
        // If the file is gone, all scenes of the folder follow.
        assert_eq!(next_scenes(Some(&path("gone.toml"))).unwrap().len(), 5);
        let alone = tempfile::tempdir().unwrap();
        let own = alone.path().join("a.toml");
        std::fs::write(&own, "x").unwrap();
        assert!(next_scenes(Some(&own)).unwrap_err().to_string().contains("another scene"));
        assert!(next_scenes(Some(&alone.path().join("no/a.toml"))).is_err());
    }

    #[test]
    fn names_that_are_taken_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("my scene.toml");
        std::fs::write(folder.path().join("my scene-001.png"), "old").unwrap();
        let path = new_file(Some(&scene), "", "png").unwrap();
        assert_eq!(path, folder.path().join("my scene-002.png"));
        assert_eq!(
            new_file(Some(&scene), "", "png").unwrap(),
            path.with_file_name("my scene-003.png")
        );
        let old = std::fs::read_to_string(folder.path().join("my scene-001.png")).unwrap();
        assert_eq!(old, "old");
        let gone = folder.path().join("no/a.toml");
        assert!(new_file(Some(&gone), "", "png").unwrap_err().to_string().contains("no/a-001.png"));
    }
}
