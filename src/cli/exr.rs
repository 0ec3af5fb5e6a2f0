//! AOVs as OpenEXR files of 32-bit floats: which of them go where.

use std::io::{Cursor, Write as _};
use std::path::PathBuf;

use freeform_surface::{AovKind, Aovs, Error, Result};
use image::codecs::openexr::OpenExrEncoder;
use image::{ExtendedColorType, ImageEncoder as _};

use super::output::{Output, replace};

/// One AOV and its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct AovFile {
    /// What is written.
    pub(super) kind: AovKind,
    /// Where.
    pub(super) path: PathBuf,
}

impl std::str::FromStr for AovFile {
    type Err = Error;

    /// Reads `KIND=FILE.exr`.
    fn from_str(text: &str) -> Result<Self> {
        let Some((kind, path)) = text.split_once('=') else {
            return Err(Error::invalid("AOV", format!("\"{text}\""), "KIND=FILE.exr"));
        };
        let kind = kind.parse()?;
        let path = PathBuf::from(path);
        if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
            let name = format!("\"{}\"", path.display());
            return Err(Error::invalid("file of an AOV", name, "a name that ends in .exr"));
        }
        Ok(Self { kind, path })
    }
}

impl AovFile {
    /// Refuses what would leave one file where several were asked for.
    ///
    /// # Errors
    /// Several scenes, two AOVs with one file.
    pub(super) fn check(files: &[Self], scenes: usize) -> Result<()> {
        if scenes > 1 && !files.is_empty() {
            return Err(Error::invalid("--aov", format!("given for {scenes} scenes"), "one scene"));
        }
        for (i, file) in files.iter().enumerate() {
            if files[..i].iter().any(|other| other.path == file.path) {
                let name = format!("{} for two AOVs", file.path.display());
                return Err(Error::invalid("--aov", name, "a file for each"));
            }
        }
        Ok(())
    }

    /// Refuses to write over a file that a scene was read from.
    ///
    /// # Errors
    /// Names the file.
    pub(super) fn check_keeps(&self, sources: &[PathBuf]) -> Result<()> {
        Output::File(self.path.clone()).check_keeps(sources)
    }

    /// Writes its AOV with the channels R, G, B and A.
    ///
    /// # Errors
    /// The file cannot be written; an older one stays as it was.
    pub(super) fn write(&self, aovs: &Aovs) -> Result<()> {
        let fail =
            |reason: String| Error::File { action: "write", path: self.path.clone(), reason };
        let mut bytes = Cursor::new(Vec::new());
        let pixels = bytemuck::cast_slice(aovs.channel(self.kind));
        let (width, height) = aovs.size;
        OpenExrEncoder::new(&mut bytes)
            .write_image(pixels, width, height, ExtendedColorType::Rgba32F)
            .map_err(|error| fail(error.to_string()))?;
        replace(&self.path, |file| file.write_all(bytes.get_ref()))
            .map_err(|error| fail(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("n.exr");
        let mut aovs = Aovs::empty((3, 2));
        aovs.normal = vec![
            [0.0, -0.0, 1.0, 1.0],
            [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45],
            [1.0 / 3.0, -16_777_217.0, 65_505.0, 0.5],
            [1e-8, 6e-8, f32::EPSILON, 1.0],
            [f32::INFINITY, f32::NEG_INFINITY, 2048.5, 1.0],
            [-1e30, 1e30, 0.1, 0.0],
        ];
        for _ in 0..2 {
            AovFile { kind: AovKind::Normal, path: path.clone() }.write(&aovs).unwrap();
        }
        let read = image::open(&path).unwrap();
        assert_eq!((read.color(), read.width(), read.height()), (image::ColorType::Rgba32F, 3, 2));
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(read.into_rgba32f().as_raw()), bits(aovs.normal.as_flattened()));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

        let missing = AovFile { kind: AovKind::Uv, path: folder.path().join("no/x.exr") };
        assert!(missing.write(&aovs).unwrap_err().to_string().contains("no/x.exr"));
    }

    #[test]
    fn kinds_and_names_are_read_or_refused() {
        let expected = AovFile { kind: AovKind::Depth, path: "a/b=c.EXR".into() };
        assert_eq!("depth=a/b=c.EXR".parse::<AovFile>().unwrap(), expected);
        for (text, words) in [
            ("depth", ["\"depth\"", "KIND=FILE.exr"]),
            ("", ["\"\"", "KIND=FILE.exr"]),
            ("colour=x.exr", ["\"colour\"", "uv, position, normal or depth"]),
            ("uv=x.png", ["\"x.png\"", ".exr"]),
            ("uv=", ["\"\"", ".exr"]),
            ("uv=.exr", ["\".exr\"", ".exr"]),
        ] {
            let text = text.parse::<AovFile>().unwrap_err().to_string();
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
            assert!(!text.contains('\n'));
        }
    }
}
