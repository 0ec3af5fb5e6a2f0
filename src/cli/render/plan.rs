//! Which pictures are made of which scenes.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::io::input::is_standard;
use crate::io::output::{is_folder, is_png, make_folder, single, sweep, with_png};
use crate::io::{Error, Result};

use super::RenderArguments;
use super::arguments::{BatchArguments, FrameRange};
use super::inputs::Input;
use super::messages::Task;
use super::record;

/// A picture that is to be made.
#[derive(Debug)]
pub(super) struct Picture {
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
    /// Of a moving camera.
    pub(super) frame: Option<u32>,
    /// Why it cannot be made, if that is known.
    pub(super) fault: Option<String>,
}

impl Picture {
    /// What a worker is asked to do.
    pub(super) fn task(&self) -> Task {
        let Self { input, output, frame, .. } = self;
        Task::Draw { input: input.clone(), output: output.clone(), frame: *frame }
    }
}

/// The pictures of the scenes, without those of other shards. Their folders exist afterwards, and have no temporary
/// files of killed programs for them.
///
/// # Errors
/// Two pictures have the same name, the output is no folder, or a folder cannot be created.
pub(super) fn pictures(inputs: Vec<Input>, arguments: &RenderArguments) -> Result<Vec<Picture>> {
    let frames = frames_of(&arguments.batch)?;
    let place = place_of(arguments, inputs.len() * frames.len())?;
    let mut pictures = Vec::new();
    let mut taken: HashMap<PathBuf, PathBuf> = HashMap::new();
    for Input { path, name, fault } in inputs {
        for frame in &frames {
            let name = name_of(&name, *frame);
            let output = match &place {
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
                let (input, fault) = (path.clone(), fault.clone());
                pictures.push(Picture { input, output, frame: *frame, fault });
            }
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

/// The frames of each scene: a single picture without a number, or those of a moving camera.
fn frames_of(batch: &BatchArguments) -> Result<Vec<Option<u32>>> {
    let FrameRange { first, last } = match (batch.turntable, batch.frames) {
        (None, None) => return Ok(vec![None]),
        (None, Some(frames)) => frames,
        (Some(last), None) => FrameRange { first: 1, last },
        (Some(count), Some(frames)) if frames.first >= 1 && frames.last <= count => frames,
        (Some(count), Some(FrameRange { first, last })) => {
            let expected = format!("frames of the turntable, 1 to {count}");
            return Err(Error::invalid("--frames", format!("{first}-{last}"), expected));
        }
    };
    Ok((first..=last).map(Some).collect())
}

/// The name of the picture of a frame, below the folder of the output.
fn name_of(name: &Path, frame: Option<u32>) -> PathBuf {
    let mut name = name.as_os_str().to_owned();
    if let Some(frame) = frame {
        name.push(format!("-{frame:04}"));
    }
    with_png(&name).into()
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
        let batch = &arguments.batch;
        (&batch.list, batch.turntable, batch.frames) == (&None, None, None)
            && matches!(&arguments.scenes[..], [one] if !one.is_dir())
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
