//! The words of a model file and their lines.

use std::fmt::Display;
use std::io::{BufRead, ErrorKind};
use std::path::Path;

use crate::error::{Error, Result, shortened};
use crate::model::check::MAX_WORD;

/// Reads a file word by word; the next word can be looked at before it is taken.
pub(super) struct Words<'a, R> {
    text: R,
    path: &'a Path,
    /// The line, from 1, where reading goes on.
    line: usize,
    /// The word that was read last.
    word: String,
    kind: Kind,
    /// Whether this word is still to be taken.
    is_next: bool,
    /// Its line.
    line_of_word: usize,
    /// The line of the word that was taken last.
    line_of_taken: usize,
    /// The record that is read: its kind and its number.
    pub(super) place: Option<(&'static str, usize)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Word,
    /// A text in quotes, without them.
    Text,
    /// The file ends.
    End,
}

/// Where the bytes of a text in quotes are.
enum Quoted {
    Inside,
    AfterBackslash,
    Closed,
}

impl<'a, R: BufRead> Words<'a, R> {
    pub(super) fn new(text: R, path: &'a Path) -> Self {
        Self {
            text,
            path,
            line: 1,
            word: String::new(),
            kind: Kind::End,
            is_next: false,
            line_of_word: 1,
            line_of_taken: 1,
            place: None,
        }
    }

    /// Whether the next word is this one.
    pub(super) fn is(&mut self, word: &str) -> Result<bool> {
        self.look()?;
        Ok(self.kind == Kind::Word && self.word == word)
    }

    /// Takes the next word if it is this one.
    pub(super) fn accept(&mut self, word: &str) -> Result<bool> {
        let is_it = self.is(word)?;
        if is_it {
            self.take();
        }
        Ok(is_it)
    }

    /// Takes the next word, which must be this one.
    pub(super) fn expect(&mut self, word: &str) -> Result<()> {
        if self.accept(word)? { Ok(()) } else { Err(self.unexpected(word)) }
    }

    /// Takes a text in quotes.
    pub(super) fn text(&mut self, name: &str) -> Result<String> {
        self.look()?;
        if self.kind != Kind::Text {
            return Err(self.unexpected(format_args!("{name}, a text in double quotes")));
        }
        self.take();
        Ok(self.word.clone())
    }

    /// Takes a word as a value of another type.
    pub(super) fn parse<T: std::str::FromStr>(
        &mut self,
        name: impl Display,
        expected: &str,
    ) -> Result<T> {
        self.look()?;
        let value = if self.kind == Kind::Word { self.word.parse().ok() } else { None };
        match value {
            Some(value) => {
                self.take();
                Ok(value)
            }
            None if self.kind == Kind::End => {
                Err(self.unexpected(format_args!("{name}, {expected}")))
            }
            None => {
                let found = self.found();
                Err(self.fail(format_args!("{name} is {found}; expected {expected}")))
            }
        }
    }

    /// Refuses anything after the end of the model.
    pub(super) fn expect_end(&mut self) -> Result<()> {
        self.look()?;
        match self.kind {
            Kind::End => Ok(()),
            _ => Err(self.unexpected("nothing after the word end")),
        }
    }

    /// An error at the next word.
    pub(super) fn unexpected(&self, expected: impl Display) -> Error {
        match self.kind {
            Kind::End => self.fail(format_args!("the file ends; expected {expected}")),
            _ => self.fail(format_args!("{} found; expected {expected}", self.found())),
        }
    }

    fn found(&self) -> String {
        let word = shortened(&self.word);
        if self.kind == Kind::Text { format!("the text \"{word}\"") } else { format!("\"{word}\"") }
    }

    /// An error at the word that was looked at last.
    fn fail(&self, message: impl Display) -> Error {
        self.error(self.line_of_word, message)
    }

    /// The error of a check of words that were taken.
    pub(super) fn fault(&self, error: &Error) -> Error {
        self.error(self.line_of_taken, error)
    }

    fn error(&self, line: usize, message: impl Display) -> Error {
        let message = match self.place {
            Some((kind, number)) => format!("{kind} {number}: {message}"),
            None => message.to_string(),
        };
        Error::Scene { path: self.path.to_owned(), line, message }
    }

    fn take(&mut self) {
        self.is_next = false;
        self.line_of_taken = self.line_of_word;
    }

    /// Reads the next word, unless that was done before.
    fn look(&mut self) -> Result<()> {
        if self.is_next {
            return Ok(());
        }
        self.is_next = true;
        let mut word = std::mem::take(&mut self.word).into_bytes();
        word.clear();
        let first = self.skip_space()?;
        self.line_of_word = self.line;
        self.kind = match first {
            None => Kind::End,
            Some(b'"') => {
                self.text.consume(1);
                self.read_text(&mut word)?;
                Kind::Text
            }
            Some(_) => {
                self.read_word(&mut word)?;
                Kind::Word
            }
        };
        self.word = String::from_utf8(word).map_err(|error| {
            let word = String::from_utf8_lossy(error.as_bytes()).into_owned();
            self.fail(format_args!("\"{}\" is not text; expected UTF-8", shortened(&word)))
        })?;
        Ok(())
    }

    /// The bytes that can be read without waiting; none at the end of the file.
    fn buffer(&mut self) -> Result<&[u8]> {
        while let Err(error) = self.text.fill_buf() {
            if error.kind() != ErrorKind::Interrupted {
                return Err(Error::file("read", self.path, error));
            }
        }
        self.text.fill_buf().map_err(|error| Error::file("read", self.path, error))
    }

    /// Skips white space and comments. Returns the byte after them, which stays to be read.
    fn skip_space(&mut self) -> Result<Option<u8>> {
        let mut is_comment = false;
        loop {
            let bytes = self.buffer()?;
            if bytes.is_empty() {
                return Ok(None);
            }
            let mut lines = 0;
            let end = bytes.iter().position(|byte| {
                lines += usize::from(*byte == b'\n');
                is_comment = (is_comment || *byte == b'#') && *byte != b'\n';
                !is_comment && !byte.is_ascii_whitespace()
            });
            let (first, skipped) = (end.map(|end| bytes[end]), end.unwrap_or(bytes.len()));
            self.text.consume(skipped);
            self.line += lines;
            if first.is_some() {
                return Ok(first);
            }
        }
    }

    /// Reads up to white space, a comment or the end of the file.
    fn read_word(&mut self, word: &mut Vec<u8>) -> Result<()> {
        loop {
            let bytes = self.buffer()?;
            let end = bytes.iter().position(|byte| byte.is_ascii_whitespace() || *byte == b'#');
            let length = end.unwrap_or(bytes.len());
            if word.len() + length > MAX_WORD {
                return Err(self.too_long());
            }
            word.extend_from_slice(&bytes[..length]);
            self.text.consume(length);
            if end.is_some() || length == 0 {
                return Ok(());
            }
        }
    }

    /// Reads a text up to its closing quote.
    fn read_text(&mut self, word: &mut Vec<u8>) -> Result<()> {
        let mut state = Quoted::Inside;
        while !matches!(state, Quoted::Closed) {
            let bytes = self.buffer()?;
            if bytes.is_empty() {
                return Err(self.fail("the file ends within a text; expected a double quote"));
            }
            let mut used = 0;
            for byte in bytes {
                used += 1;
                state = match (state, byte) {
                    (Quoted::Inside, b'"') => Quoted::Closed,
                    (Quoted::Inside, b'\\') => Quoted::AfterBackslash,
                    (Quoted::Inside, b'\n') => {
                        return Err(self.fail(
                            "the line ends within a text; expected a double quote, or \\n for a line feed",
                        ));
                    }
                    (Quoted::AfterBackslash, b'n') => {
                        word.push(b'\n');
                        Quoted::Inside
                    }
                    (Quoted::Inside, byte) | (Quoted::AfterBackslash, byte @ (b'"' | b'\\')) => {
                        word.push(*byte);
                        Quoted::Inside
                    }
                    (Quoted::AfterBackslash | Quoted::Closed, _) => {
                        return Err(self.fail(
                            "a backslash in a text stands alone; expected \\\\, \\\" or \\n",
                        ));
                    }
                };
                if word.len() > MAX_WORD {
                    return Err(self.too_long());
                }
                if matches!(state, Quoted::Closed) {
                    break;
                }
            }
            self.text.consume(used);
        }
        match self.buffer()?.first() {
            Some(byte) if !byte.is_ascii_whitespace() && *byte != b'#' => {
                Err(self.fail("a text is followed by another word; expected white space"))
            }
            _ => Ok(()),
        }
    }

    fn too_long(&self) -> Error {
        self.fail(format_args!("a word of more than {MAX_WORD} bytes; expected a shorter one"))
    }
}
