//! Which pictures are made of which scenes.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::io::input::is_standard;
use crate::io::output::{is_folder, is_png, make_folder, single, sweep, with_png};
use crate::io::{Error, Result};

use super::RenderArguments;
use super::inputs::Input;
use super::messages::Task;
use super::record;

/// A picture that is to be made.
#[derive(Debug)]
pub(super) struct Picture {
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
    /// Why it cannot be made, if that is known.
    pub(super) fault: Option<String>,
}

impl Picture {
    /// What a worker is asked to do.
    pub(super) fn task(&self) -> Task {
        Task::Draw { input: self.input.clone(), output: self.output.clone() }
    }
}

/// The pictures of the scenes, without those of other shards. Their folders exist afterwards, and have no temporary
/// files of killed programs for them.
///
/// # Errors
/// Two pictures have the same name, the output is no folder, or a folder cannot be created.
pub(super) fn pictures(inputs: Vec<Input>, arguments: &RenderArguments) -> Result<Vec<Picture>> {
    let folder = place_of(arguments, inputs.len())?;
    let mut pictures = Vec::with_capacity(inputs.len());
    let mut taken: HashMap<PathBuf, PathBuf> = HashMap::new();
    for Input { path, name, fault } in inputs {
        let name = PathBuf::from(with_png(name.as_os_str()));
        let output = match &folder {
            Place::Folder(folder) => folder.join(&name),
            Place::File(file) => file.clone(),
        };
        if let Some(other) = taken.insert(output.clone(), path.clone()) {
            return Err(Error::invalid(
                "output",
                format!("{} for {} and {}", output.display(), other.display(), path.display()),
                "scenes with different names, or one call for each",
            ));
        }
        let is_own = |name: &str| arguments.batch.shard.is_none_or(|shard| shard.has(name));
        if is_own(&name.to_string_lossy()) {
            pictures.push(Picture { input: path, output, fault });
        }
    }
    // The folders are created only now, so that a refused call leaves none behind.
    for folder in folders(&pictures).keys() {
        make_folder(folder)?;
        record::make_folder_in(folder)?;
    }
    sweep_all(&pictures);
    Ok(pictures)
}

/// The folders of pictures, with the names of the pictures in them.
fn folders<'a>(
    pictures: impl IntoIterator<Item = &'a Picture>,
) -> BTreeMap<&'a Path, HashSet<OsString>> {
    let mut folders: BTreeMap<&Path, HashSet<OsString>> = BTreeMap::new();
    for Picture { output, .. } in pictures {
        let folder = output.parent().unwrap_or(Path::new(""));
        folders.entry(folder).or_default().extend(output.file_name().map(OsString::from));
    }
    folders
}

/// Removes the temporary files that killed programs have left for pictures and their records.
pub(super) fn sweep_all<'a>(pictures: impl IntoIterator<Item = &'a Picture>) {
    for (folder, names) in folders(pictures) {
        sweep(folder, &names);
        record::sweep_in(folder, &names);
    }
}

/// Where pictures go.
enum Place {
    Folder(PathBuf),
    /// The only picture.
    File(PathBuf),
}

fn place_of(arguments: &RenderArguments, count: usize) -> Result<Place> {
    let refused = |name: String| Err(Error::invalid("output", name, "a folder, or a single scene"));
    let is_one_scene = || {
        arguments.batch.list.is_none() && matches!(&arguments.scenes[..], [one] if !one.is_dir())
    };
    match arguments.output.as_deref() {
        None => Ok(Place::Folder(PathBuf::new())),
        Some(path) if is_standard(path) => refused("\"-\" for many pictures".into()),
        Some(path) if is_png(path) && !path.is_dir() => match count {
            1 => Ok(Place::File(path.to_owned())),
            _ => refused(format!("{} for several pictures", path.display())),
        },
        Some(path) if is_one_scene() && !is_folder(path) => single(path).map(Place::File),
        Some(path) => Ok(Place::Folder(path.to_owned())),
    }
}
