//! The destinations of pictures. A file is first written beside its destination and then renamed. So no file is
//! left half written, and a failure leaves an existing file unchanged.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use super::{Error, Result};
use freeform_surface::{Cause, Image};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};

use super::input::is_standard;

/// The destination of one picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Output {
    /// A PNG file.
    File(PathBuf),
    /// Standard output.
    Standard,
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Standard => f.write_str("standard output"),
        }
    }
}

impl Output {
    /// The destination of each scene's picture. A folder that is needed and missing is created.
    ///
    /// # Errors
    /// Two pictures have the same name, several go to standard output, a name does not end in .png, or a folder
    /// cannot be created.
    pub(crate) fn plan(scenes: &[PathBuf], output: Option<&Path>) -> Result<Vec<Self>> {
        let folder = match output {
            None => PathBuf::new(),
            Some(path) if path == Path::new("-") => {
                return match scenes {
                    [_] => Ok(vec![Self::Standard]),
                    _ => Err(Error::invalid(
                        "output",
                        "\"-\" for several scenes",
                        "a folder, or a single scene",
                    )),
                };
            }
            Some(path) => {
                if scenes.len() > 1 && is_png(path) && !path.is_dir() {
                    let name = format!("{} for several scenes", path.display());
                    return Err(Error::invalid("output", name, "a folder, or a single scene"));
                }
                let ends_as_folder = path.to_string_lossy().ends_with(std::path::is_separator);
                if scenes.len() == 1 && !ends_as_folder && !path.is_dir() {
                    return single(path).map(|output| vec![output]);
                }
                path.to_owned()
            }
        };
        let mut taken: HashMap<PathBuf, &PathBuf> = HashMap::new();
        let outputs: Vec<Self> = scenes
            .iter()
            .map(|scene| {
                let stem = match scene.file_stem() {
                    _ if is_standard(scene) => OsStr::new("freeform"),
                    stem => stem.unwrap_or(scene.as_os_str()),
                };
                let mut name = stem.to_owned();
                name.push(".png");
                let path = folder.join(name);
                match taken.insert(path.clone(), scene) {
                    None => Ok(Self::File(path)),
                    Some(other) => Err(Error::invalid(
                        "output",
                        format!(
                            "{} for {} and {}",
                            path.display(),
                            other.display(),
                            scene.display()
                        ),
                        "scenes with different names, or one call for each",
                    )),
                }
            })
            .collect::<Result<_>>()?;
        // The folder is created only now, so that a refused call leaves no folder behind.
        if !folder.as_os_str().is_empty() {
            std::fs::create_dir_all(&folder)
                .map_err(|error| Error::file("make the folder", folder, error))?;
        }
        Ok(outputs)
    }

    /// Refuses to overwrite a file that the scene was read from.
    ///
    /// # Errors
    /// The error names the file.
    pub(crate) fn check_keeps(&self, files: &[PathBuf]) -> Result<()> {
        let Self::File(path) = self else { return Ok(()) };
        let Ok(place) = path.canonicalize() else { return Ok(()) };
        let is_source = |file: &PathBuf| file.canonicalize().is_ok_and(|file| file == place);
        if files.iter().any(is_source) {
            let name = format!("{}, which the scene was read from", path.display());
            return Err(Error::invalid("output", name, "another file: see --output"));
        }
        Ok(())
    }

    /// Writes a picture; without transparent pixels it has no alpha channel.
    ///
    /// # Errors
    /// The file cannot be written; an existing file is left unchanged.
    pub(crate) fn write(&self, image: &Image) -> Result<()> {
        let path = match self {
            Self::File(path) => path.clone(),
            Self::Standard => PathBuf::from("standard output"),
        };
        let fail = |cause: Cause| Error::file("write", path.clone(), cause);
        let bytes = encode(image).map_err(|error| fail(error.into()))?;
        match self {
            Self::Standard => {
                let mut out = std::io::stdout().lock();
                out.write_all(&bytes).and_then(|()| out.flush())
            }
            Self::File(path) => replace(path, |file| file.write_all(&bytes)),
        }
        .map_err(|error| fail(error.into()))
    }
}

fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

fn single(path: &Path) -> Result<Output> {
    if !is_png(path) {
        return Err(Error::invalid(
            "output",
            path.display(),
            "a name that ends in .png, or a folder",
        ));
    }
    Ok(Output::File(path.to_owned()))
}

fn encode(image: &Image) -> image::ImageResult<Vec<u8>> {
    let (width, height) = image.dimensions();
    let opaque = image.pixels().all(|pixel| pixel.0[3] == 255);
    let rgb: Vec<u8>;
    let (pixels, color): (&[u8], _) = if opaque {
        rgb = image.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect();
        (&rgb, ExtendedColorType::Rgb8)
    } else {
        (image.as_raw(), ExtendedColorType::Rgba8)
    };
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
        .write_image(pixels, width, height, color)?;
    Ok(bytes)
}

/// Writes to a temporary file beside `path` and renames it.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    // A symbolic link is kept; the file that it points to is replaced.
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let write_part = || {
        let mut file = BufWriter::new(File::create(&part)?);
        write(&mut file)?;
        file.flush()
    };
    write_part().and_then(|()| std::fs::rename(&part, path)).inspect_err(|_| {
        // The file may not exist; the first error is returned in any case.
        let _ = std::fs::remove_file(&part);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(scenes: &[&str], output: Option<&str>) -> Result<Vec<Output>> {
        let scenes: Vec<PathBuf> = scenes.iter().map(PathBuf::from).collect();
        Output::plan(&scenes, output.map(Path::new))
    }

    #[test]
    fn names_come_from_the_scenes() {
        let file = |name: &str| Output::File(name.into());
        assert_eq!(plan(&["a/x.toml", "y.bpt"], None).unwrap(), [file("x.png"), file("y.png")]);
        assert_eq!(plan(&["a/x.toml"], Some("z.PNG")).unwrap(), [file("z.PNG")]);
        assert_eq!(plan(&["a/x.toml"], Some("-")).unwrap(), [Output::Standard]);
        assert_eq!(plan(&["-"], None).unwrap(), [file("freeform.png")]);
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("new");
        let planned = plan(&["a/x.toml", "b/y.toml"], inside.to_str()).unwrap();
        assert_eq!(planned[1], Output::File(inside.join("y.png")));
        assert!(inside.is_dir());
    }

    #[test]
    fn clashes_and_other_formats_are_refused() {
        for (scenes, output, word) in [
            (&["a/x.toml", "b/x.bpt"][..], None, "x.png for a/x.toml and b/x.bpt"),
            (&["x.toml", "y.toml"][..], Some("-"), "several scenes"),
            (&["x.toml"][..], Some("x.jpg"), ".png"),
            (&["x.toml"][..], Some("x"), ".png"),
            (&["x.toml", "y.toml"][..], Some("both.png"), "a folder"),
        ] {
            let text = plan(scenes, output).unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
    }

    #[test]
    fn a_picture_is_replaced_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        let output = Output::File(path.clone());
        let opaque = Image::from_pixel(3, 2, image::Rgba([1, 2, 3, 255]));
        output.write(&opaque).unwrap();
        // A hard link to the old file keeps the old picture, because nothing was written into that file.
        let old = folder.path().join("old.png");
        std::fs::hard_link(&path, &old).unwrap();
        let clear = Image::from_pixel(3, 2, image::Rgba([1, 2, 3, 0]));
        output.write(&clear).unwrap();
        assert_eq!(image::open(&old).unwrap().into_rgba8(), opaque);
        std::fs::remove_file(&old).unwrap();
        // If the file cannot be put in its place, no temporary file is left beside it.
        let in_the_way = folder.path().join("folder.png");
        std::fs::create_dir(&in_the_way).unwrap();
        assert!(Output::File(in_the_way.clone()).write(&clear).is_err());
        std::fs::remove_dir(&in_the_way).unwrap();
        assert_eq!(image::open(&path).unwrap().into_rgba8(), clear);
        let files = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(files, 1);

        let link = folder.path().join("link.png");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&path, &link).unwrap();
            Output::File(link.clone()).write(&opaque).unwrap();
            assert!(link.is_symlink());
            assert_eq!(image::open(&path).unwrap().into_rgba8(), opaque);
        }
        assert!(output.check_keeps(&[folder.path().join("other.png")]).is_ok());
        assert!(output.check_keeps(&[link]).unwrap_err().to_string().contains("read from"));

        let missing = Output::File(folder.path().join("no/x.png"));
        assert!(missing.write(&opaque).unwrap_err().to_string().contains("no/x.png"));
    }
}
