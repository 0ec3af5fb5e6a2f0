//! Reads the files of scenes, and finds the line of a byte offset.

use std::io::Read as _;
use std::path::Path;

use crate::error::{Cause, Error, Result};

/// Scene files beyond this size are refused, so that a wrong file cannot exhaust the memory.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// The byte order mark that some editors write at the beginning of a text.
pub(super) const BYTE_ORDER_MARK: char = '\u{feff}';

/// The extension in lower case, without the dot.
pub(super) fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

pub(super) fn unreadable(path: &Path, reason: impl Into<Cause>) -> Error {
    Error::file("read", path, reason)
}

pub(super) fn check_is_file(path: &Path) -> Result<()> {
    let metadata = std::fs::metadata(path).map_err(|error| unreadable(path, error))?;
    if metadata.is_dir() {
        Err(unreadable(path, "it is a folder, expected a file"))
    } else if !metadata.is_file() {
        Err(unreadable(path, "it is a pipe or a device, expected a file"))
    } else {
        Ok(())
    }
}

/// The bytes of a file. Anything that is not a file or is too large is refused, with its name in the error.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    check_is_file(path)?;
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|error| unreadable(path, error))?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(unreadable(path, format!("it has more than {MAX_FILE_BYTES} bytes")));
    }
    Ok(bytes)
}

/// The text of a scene file without a byte order mark. Anything that is not a file, is too large, is empty or is not
/// UTF-8 is refused, with its name in the error.
pub(super) fn read_text(path: &Path) -> Result<String> {
    let fail = |reason: String| unreadable(path, reason);
    let bytes = read_bytes(path)?;
    let mut text = String::from_utf8(bytes).map_err(|error| {
        fail(format!("it is not text (byte {})", error.utf8_error().valid_up_to()))
    })?;
    if text.starts_with(BYTE_ORDER_MARK) {
        text.drain(..BYTE_ORDER_MARK.len_utf8());
    }
    if text.trim().is_empty() {
        return Err(fail("it is empty".into()));
    }
    Ok(text)
}

/// The line, from 1, of a byte offset.
pub(super) fn line_of(text: &str, offset: usize) -> usize {
    1 + text.as_bytes()[..offset.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}
