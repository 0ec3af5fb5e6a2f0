//! AOVs as OpenEXR files of 32-bit floats: the requested AOVs and their files.

use std::io::{Cursor, Write as _};
use std::path::PathBuf;

use crate::io::{Error, Result};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    WritableImage as _,
};
use freeform_surface::{AovKind, Aovs, Cause};

use crate::io::output::{Output, replace};

/// One AOV and its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct AovFile {
    /// The AOV that is written.
    pub(super) kind: AovKind,
    /// The file that it is written to.
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
    /// Refuses requests in which one file would overwrite another.
    ///
    /// # Errors
    /// Two AOVs have the same file.
    pub(super) fn check(files: &[Self]) -> Result<()> {
        for (i, file) in files.iter().enumerate() {
            if files[..i].iter().any(|other| other.path == file.path) {
                let name = format!("{} for two AOVs", file.path.display());
                return Err(Error::invalid("--aov", name, "a file for each"));
            }
        }
        Ok(())
    }

    /// Refuses to overwrite a file that a scene was read from.
    ///
    /// # Errors
    /// The error names the file.
    pub(super) fn check_keeps(&self, sources: &[PathBuf]) -> Result<()> {
        Output::File(self.path.clone()).check_keeps(sources)
    }

    /// Writes the AOV to its file. Depth has the single channel Z, which is infinite where nothing is drawn, as
    /// compositing programs expect. The other AOVs have the channels R, G, B and A.
    ///
    /// # Errors
    /// The file cannot be written; an existing file is left unchanged.
    pub(super) fn write(&self, aovs: &Aovs) -> Result<()> {
        let numbers = aovs.channel(self.kind);
        let channel = |name: &str, of_pixel: fn(&[f32; 4]) -> f32| {
            AnyChannel::new(name, FlatSamples::F32(numbers.iter().map(of_pixel).collect()))
        };
        let channels = match self.kind {
            AovKind::Depth => vec![channel(
                "Z",
                |[depth, _, _, alpha]| {
                    if *alpha > 0.0 { *depth } else { f32::INFINITY }
                },
            )],
            _ => vec![
                channel("R", |pixel| pixel[0]),
                channel("G", |pixel| pixel[1]),
                channel("B", |pixel| pixel[2]),
                channel("A", |pixel| pixel[3]),
            ],
        };
        let bytes = encode(aovs.size, channels);
        let fail = |cause: Cause| Error::file("write", self.path.clone(), cause);
        let bytes = bytes.map_err(|error| fail(error.into()))?;
        replace(&self.path, |file| file.write_all(&bytes)).map_err(|error| fail(error.into()))
    }
}

fn encode(
    (width, height): (u32, u32),
    channels: Vec<AnyChannel<FlatSamples>>,
) -> exr::error::Result<Vec<u8>> {
    let size = (width as usize, height as usize);
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use exr::prelude::read_first_flat_layer_from_file;

    use super::*;

    /// The size of a file's picture and the values of its channels, keyed by channel name.
    fn read(path: &Path) -> ((usize, usize), BTreeMap<String, Vec<f32>>) {
        let layer = read_first_flat_layer_from_file(path).unwrap().layer_data;
        let channels = layer.channel_data.list.iter().map(|channel| {
            (channel.name.to_string(), channel.sample_data.values_as_f32().collect())
        });
        ((layer.size.x(), layer.size.y()), channels.collect())
    }

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
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        let (size, channels) = read(&path);
        assert_eq!(size, (3, 2));
        for (name, component) in [("A", 3), ("B", 2), ("G", 1), ("R", 0)] {
            let expected: Vec<f32> = aovs.normal.iter().map(|pixel| pixel[component]).collect();
            assert_eq!(bits(&channels[name]), bits(&expected), "{name}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

        let missing = AovFile { kind: AovKind::Uv, path: folder.path().join("no/x.exr") };
        assert!(missing.write(&aovs).unwrap_err().to_string().contains("no/x.exr"));
    }

    #[test]
    fn depth_is_one_channel_that_is_infinite_where_nothing_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.exr");
        let mut aovs = Aovs::empty((2, 1));
        aovs.depth[1] = [2.5, 2.5, 2.5, 1.0];
        AovFile { kind: AovKind::Depth, path: path.clone() }.write(&aovs).unwrap();
        let (size, channels) = read(&path);
        assert_eq!((size, channels.len()), ((2, 1), 1));
        assert_eq!(channels["Z"], [f32::INFINITY, 2.5]);
    }

    #[test]
    fn kinds_and_names_are_read_or_refused() {
        let expected = AovFile { kind: AovKind::Depth, path: "a/b=c.EXR".into() };
        assert_eq!("depth=a/b=c.EXR".parse::<AovFile>().unwrap(), expected);
        for (text, words) in [
            ("depth", ["\"depth\"", "KIND=FILE.exr"]),
            ("", ["\"\"", "KIND=FILE.exr"]),
            ("colour=x.exr", ["\"colour\"", "uv, position, normal, depth, face or curvature"]),
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
