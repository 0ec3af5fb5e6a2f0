//! The log of many pictures: a line of JSON for each.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::messages::Report;
use super::plan::Picture;
use crate::io::{Error, Result};

/// A file to which lines are appended.
#[derive(Debug)]
pub(super) struct Log {
    file: File,
    path: PathBuf,
}

#[derive(Serialize)]
struct Line<'a> {
    input: &'a str,
    output: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<u32>,
    #[serde(flatten)]
    report: &'a Report,
}

impl Log {
    /// Opens or creates the file. If its last line is not whole, because the disk was full or the machine went down, the
    /// next line is still a line of its own.
    ///
    /// # Errors
    /// It cannot be opened.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let fail = |error: std::io::Error| Error::file("write", path, error);
        let open = || {
            let mut file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
            if file.seek(SeekFrom::End(0))? > 0 {
                let mut last = [0];
                file.seek(SeekFrom::End(-1))?;
                file.read_exact(&mut last)?;
                if last != *b"\n" {
                    file.write_all(b"\n")?;
                }
            }
            Ok(file)
        };
        Ok(Self { file: open().map_err(fail)?, path: path.to_owned() })
    }

    /// Appends a line about a picture. It is written at once, so that lines of several programs do not mix.
    ///
    /// # Errors
    /// It cannot be written.
    pub(super) fn add(&mut self, picture: &Picture, report: &Report) -> Result<()> {
        let (input, output) = (picture.input.to_string_lossy(), picture.output.to_string_lossy());
        let line = Line { input: &input, output: &output, frame: picture.frame, report };
        serde_json::to_vec(&line)
            .map_err(Into::into)
            .and_then(|mut line| {
                line.push(b'\n');
                self.file.write_all(&line)
            })
            .map_err(|error| Error::file("write", &self.path, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::render::messages::Status;

    #[test]
    fn a_torn_line_stays_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.jsonl");
        let picture =
            Picture { input: "a.toml".into(), output: "a.png".into(), frame: None, fault: None };
        std::fs::write(&path, "{\"input\":\"b.to").unwrap();
        for _ in 0..2 {
            Log::open(&path).unwrap().add(&picture, &Report::of(Status::Kept)).unwrap();
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3, "{text}");
        for line in &lines[1..] {
            let line: serde_json::Value = serde_json::from_str(line).unwrap();
            assert_eq!(line["output"], "a.png");
            assert_eq!(line["status"], "kept");
        }
    }
}
