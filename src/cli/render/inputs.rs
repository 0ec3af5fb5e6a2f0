//! The scenes of many pictures: from the command line, from folders and from lists.

use std::collections::HashSet;
use std::io::Read as _;
use std::path::{Component, Path, PathBuf};

use crate::io::input::is_standard;
use crate::io::scenes::scenes_in;
use crate::io::{Error, Result};

use super::RenderArguments;

/// A scene that is to be drawn.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Input {
    pub(super) path: PathBuf,
    /// The name of its picture below the folder of the output, without the extension.
    pub(super) name: PathBuf,
    /// Why it cannot be drawn, if that is known.
    pub(super) fault: Option<String>,
}

impl Input {
    fn new(path: PathBuf, name: &Path) -> Self {
        let fault = path.to_str().is_none().then(|| {
            format!("cannot read {}: its name is not UTF-8; expected another name", path.display())
        });
        Self { path, name: name.with_extension(""), fault }
    }
}

/// The scenes of the arguments in their order, each once.
///
/// # Errors
/// A scene from standard input, a folder without scenes, a list that cannot be read or is empty.
pub(super) fn gather(arguments: &RenderArguments) -> Result<Vec<Input>> {
    let mut inputs = Vec::new();
    for path in &arguments.scenes {
        if is_standard(path) {
            let among = "\"-\" among others or with options for many pictures";
            return Err(Error::invalid("scenes", among, "a scene from standard input alone"));
        }
        let name = path.file_name().unwrap_or(path.as_os_str());
        inputs.extend(expanded(path, Path::new(name), Path::new(""), arguments)?);
    }
    if let Some(list) = &arguments.batch.list {
        for path in paths_of(list)? {
            let name = below(&path);
            inputs.extend(expanded(&path, &name, &name, arguments).unwrap_or_else(|error| {
                vec![Input { path, name: name.clone(), fault: Some(error.to_string()) }]
            }));
        }
    }
    let mut known = HashSet::new();
    inputs.retain(|input| known.insert(input.path.clone()));
    Ok(inputs)
}

/// The scenes of a folder, whose names are below `folder_name`; or a scene with its own name.
fn expanded(
    path: &Path,
    name: &Path,
    folder_name: &Path,
    arguments: &RenderArguments,
) -> Result<Vec<Input>> {
    if !path.is_dir() {
        return Ok(vec![Input::new(path.to_owned(), name)]);
    }
    let mut inputs = Vec::new();
    for scene in scenes_in(path, arguments.batch.recursive) {
        inputs.push(match scene {
            Ok(scene) => {
                let within = scene.strip_prefix(path).unwrap_or(&scene).to_owned();
                Input::new(scene, &folder_name.join(within))
            }
            Err(error) => Input {
                path: path.to_owned(),
                name: folder_name.to_owned(),
                fault: Some(error.to_string()),
            },
        });
    }
    if inputs.is_empty() {
        let deeper = if arguments.batch.recursive { "" } else { ", or --recursive" };
        let expected = format!("a .toml, .bpt, .obj file or a CAD model in it{deeper}");
        let name = format!("folder {}", path.display());
        return Err(Error::invalid(name, "without a scene", expected));
    }
    Ok(inputs)
}

/// A path without its root and without steps to the same or a higher folder.
fn below(path: &Path) -> PathBuf {
    path.components().filter(|part| matches!(part, Component::Normal(_))).collect()
}

/// The paths of a list, one a line. Empty lines are left out.
fn paths_of(list: &Path) -> Result<Vec<PathBuf>> {
    let (place, bytes) = if is_standard(list) {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().read_to_end(&mut bytes);
        (Path::new("standard input"), read.map(|_| bytes))
    } else {
        (list, std::fs::read(list))
    };
    let bytes = bytes.map_err(|error| Error::file("read", place, error))?;
    let lines = bytes.split(|byte| *byte == b'\n');
    let lines = lines.map(|line| line.strip_suffix(b"\r").unwrap_or(line));
    let paths: Vec<PathBuf> = lines.filter(|line| !line.is_empty()).map(path_of).collect();
    if paths.is_empty() {
        return Err(Error::file("read", place, "it has no path; expected one a line"));
    }
    Ok(paths)
}

#[cfg(unix)]
fn path_of(bytes: &[u8]) -> PathBuf {
    use std::os::unix::ffi::OsStrExt as _;
    PathBuf::from(std::ffi::OsStr::from_bytes(bytes))
}

#[cfg(not(unix))]
fn path_of(bytes: &[u8]) -> PathBuf {
    String::from_utf8_lossy(bytes).into_owned().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_may_have_empty_lines_and_any_ends_of_lines() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("list");
        std::fs::write(&list, "a b.toml\r\n\n/c/d.obj\n../e.bpt").unwrap();
        assert_eq!(
            paths_of(&list).unwrap(),
            ["a b.toml", "/c/d.obj", "../e.bpt"].map(PathBuf::from)
        );
        std::fs::write(&list, "\n\n").unwrap();
        assert!(paths_of(&list).unwrap_err().to_string().contains("one a line"));
        assert!(paths_of(&folder.path().join("none")).is_err());
    }

    #[test]
    fn names_stay_below_the_output() {
        for (path, name) in [("/a/b.x.toml", "a/b.x.toml"), ("../a/./b", "a/b"), ("c", "c")] {
            assert_eq!(below(Path::new(path)), Path::new(name));
        }
    }
}
