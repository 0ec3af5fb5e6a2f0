//! What a picture was made from: a record beside it, by which a later run tells whether it has to be made again.

use std::collections::{HashMap, HashSet};
use std::ffi::OsString;
use std::fs::File;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::io::output::{make_folder, replace, sweep};
use crate::io::{Error, Result};

/// The folder of the records, beside the pictures.
const FOLDER: &str = ".freeform";

/// The files, settings and version that made a picture.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Record {
    version: String,
    settings: String,
    files: Vec<Source>,
    /// The SHA-256 of the picture's file.
    picture: String,
}

/// A file that a scene was read from, or looked for.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Source {
    /// Relative to the folder of the scene, if it was found from there.
    path: PathBuf,
    /// `None`: there was no such file.
    sha256: Option<String>,
}

/// The folder of the records of the pictures in a folder.
fn folder_beside(folder: &Path) -> PathBuf {
    folder.join(FOLDER)
}

fn name_for(picture: &OsString) -> OsString {
    let mut name = picture.clone();
    name.push(".json");
    name
}

fn place(output: &Path) -> PathBuf {
    let name = output.file_name().unwrap_or_default().to_owned();
    folder_beside(output.parent().unwrap_or(Path::new(""))).join(name_for(&name))
}

/// Creates the folder for the records of the pictures in a folder.
///
/// # Errors
/// It cannot be created.
pub(super) fn make_folder_in(folder: &Path) -> Result<()> {
    make_folder(&folder_beside(folder))
}

/// Removes what killed programs have left of the records of the pictures in a folder.
pub(super) fn sweep_in(folder: &Path, pictures: &HashSet<OsString>) {
    sweep(&folder_beside(folder), &pictures.iter().map(name_for).collect());
}

/// Whether a picture has a record, right or wrong.
pub(super) fn exists(output: &Path) -> bool {
    place(output).exists()
}

impl Record {
    /// The record of a picture that is about to be written. `None`: a file may have changed while the scene was read,
    /// since `start`.
    ///
    /// # Errors
    /// A file that can no longer be read.
    pub(super) fn new(
        input: &Path,
        files: &[PathBuf],
        start: SystemTime,
        settings: String,
        picture: &[u8],
        digests: &mut Digests,
    ) -> Result<Option<Self>> {
        let folder = input.parent().unwrap_or(Path::new(""));
        let now = SystemTime::now();
        let mut sources = Vec::with_capacity(files.len());
        for file in files {
            let digest = digests.of(file).map_err(|error| Error::file("read", file, error))?;
            if digest.as_ref().is_some_and(|digest| (start..=now).contains(&digest.modified)) {
                return Ok(None);
            }
            let path = file.strip_prefix(folder).unwrap_or(file).to_owned();
            sources.push(Source { path, sha256: digest.map(|digest| digest.sha256) });
        }
        Ok(Some(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            settings,
            files: sources,
            picture: hex(&Sha256::digest(picture)),
        }))
    }

    /// Whether the record of a picture says that it would be made again as it is.
    pub(super) fn holds(
        input: &Path,
        output: &Path,
        settings: &str,
        digests: &mut Digests,
    ) -> bool {
        let read = || serde_json::from_slice::<Self>(&std::fs::read(place(output)).ok()?).ok();
        let Some(record) = read() else { return false };
        let folder = input.parent().unwrap_or(Path::new(""));
        let first = record.files.first().map(|first| folder.join(&first.path));
        record.version == env!("CARGO_PKG_VERSION")
            && record.settings == settings
            && first.as_deref() == Some(input)
            && std::fs::read(output)
                .is_ok_and(|bytes| hex(&Sha256::digest(bytes)) == record.picture)
            && record.files.iter().all(|source| {
                digests
                    .of(&folder.join(&source.path))
                    .is_ok_and(|now| now.map(|now| now.sha256) == source.sha256)
            })
    }

    /// Writes the record of a picture.
    ///
    /// # Errors
    /// It cannot be written; an older one is left unchanged.
    pub(super) fn write(&self, output: &Path) -> Result<()> {
        let path = place(output);
        let bytes = serde_json::to_vec(self).map_err(|error| Error::file("write", &path, error))?;
        replace(&path, |file| file.write_all(&bytes))
            .map_err(|error| Error::file("write", path, error))
    }
}

/// The digest of a file, and when it was changed and how long it was at that time.
#[derive(Debug, Clone)]
struct Digest {
    modified: SystemTime,
    length: u64,
    sha256: String,
}

/// Digests of files, each read again only after it was changed.
#[derive(Debug, Default)]
pub(super) struct Digests(HashMap<PathBuf, Digest>);

impl Digests {
    /// `None`: there is no such file.
    fn of(&mut self, path: &Path) -> std::io::Result<Option<Digest>> {
        let metadata = match std::fs::metadata(path) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        let (modified, length) = (metadata.modified()?, metadata.len());
        let known = self.0.get(path);
        if let Some(known) =
            known.filter(|known| known.modified == modified && known.length == length)
        {
            return Ok(Some(known.clone()));
        }
        let mut hasher = Sha256::new();
        std::io::copy(&mut File::open(path)?, &mut hasher)?;
        let digest = Digest { modified, length, sha256: hex(&hasher.finalize()) };
        self.0.insert(path.to_owned(), digest.clone());
        Ok(Some(digest))
    }

    /// Forgets all files.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const ALL: [&str; 3] = ["in/a.toml", "in/b.png", "out/a.png"];

    /// A folder with a picture and its record.
    fn made(root: &Path) -> [PathBuf; 3] {
        let [input, texture, output] = ALL.map(|name| root.join(name));
        for path in [&input, &output] {
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        }
        for path in [&input, &texture, &output] {
            std::fs::write(path, "content").unwrap();
        }
        let files = [input.clone(), texture.clone()];
        make_folder_in(output.parent().unwrap()).unwrap();
        let later = SystemTime::now() + Duration::from_secs(5);
        Record::new(&input, &files, later, "s".into(), b"content", &mut Digests::default())
            .unwrap()
            .unwrap()
            .write(&output)
            .unwrap();
        [input, texture, output]
    }

    #[test]
    fn a_record_holds_until_anything_changes() {
        let folder = tempfile::tempdir().unwrap();
        let [input, texture, output] = made(folder.path());
        let holds = |settings| Record::holds(&input, &output, settings, &mut Digests::default());
        assert!(exists(&output) && holds("s") && !holds("t"));
        for path in [&input, &texture, &output, &place(&output)] {
            let old = std::fs::read(path).unwrap();
            std::fs::write(path, "context").unwrap();
            assert!(!holds("s"), "{}", path.display());
            std::fs::remove_file(path).unwrap();
            assert!(!holds("s"), "{}", path.display());
            std::fs::write(path, old).unwrap();
            assert!(holds("s"));
        }
        let text = std::fs::read_to_string(place(&output)).unwrap();
        std::fs::write(place(&output), text.replace(env!("CARGO_PKG_VERSION"), "0.0.0")).unwrap();
        assert!(!holds("s"));
    }

    #[test]
    fn a_record_moves_with_its_folders() {
        let folder = tempfile::tempdir().unwrap();
        made(&folder.path().join("old"));
        std::fs::rename(folder.path().join("old"), folder.path().join("new")).unwrap();
        let [input, _, output] = ALL.map(|name| folder.path().join("new").join(name));
        assert!(Record::holds(&input, &output, "s", &mut Digests::default()));
        // A scene of another name in the same place is another one.
        let other = input.with_file_name("c.toml");
        std::fs::copy(&input, &other).unwrap();
        assert!(!Record::holds(&other, &output, "s", &mut Digests::default()));
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_gives_no_record() {
        let folder = tempfile::tempdir().unwrap();
        let start = SystemTime::now() - Duration::from_secs(5);
        let input = folder.path().join("a.toml");
        std::fs::write(&input, "content").unwrap();
        let files = [input.clone()];
        let record = Record::new(&input, &files, start, "s".into(), b"", &mut Digests::default());
        assert_eq!(record.unwrap(), None);
    }

    #[test]
    fn digests_are_those_of_sha256sum() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "x.png").unwrap();
        let digest = Digests::default().of(file.path()).unwrap().unwrap();
        assert!(digest.sha256.starts_with("3910c6508d0ae9c1470b97d3"), "{}", digest.sha256);
    }
}
