//! The destinations of pictures. A file is first written beside its destination and then renamed. So no file is
//! left half written, and a failure leaves an existing file unchanged.

use std::collections::HashSet;
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use super::{Error, Result};
use freeform_surface::{Cause, Image};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};
use tempfile::NamedTempFile;

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
    /// The destination of the picture of a scene that is drawn alone. Without `output`, or with a folder, the picture is
    /// named after the scene; a folder that is missing is created.
    ///
    /// # Errors
    /// A name that does not end in .png, or a folder that cannot be created.
    pub(crate) fn of_one(scene: &Path, output: Option<&Path>) -> Result<Self> {
        let folder = match output {
            Some(path) if is_standard(path) => return Ok(Self::Standard),
            Some(path) if !is_folder(path) => return single(path).map(Self::File),
            folder => folder.unwrap_or(Path::new("")),
        };
        let stem = match scene.file_stem() {
            _ if is_standard(scene) => OsStr::new("freeform"),
            stem => stem.unwrap_or(scene.as_os_str()),
        };
        make_folder(folder)?;
        Ok(Self::File(folder.join(with_png(stem))))
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

/// Whether a destination is a folder, or ends as one.
pub(crate) fn is_folder(path: &Path) -> bool {
    path.to_string_lossy().ends_with(std::path::is_separator) || path.is_dir()
}

/// Whether a file's name ends in .png.
pub(crate) fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// A name with .png at its end.
pub(crate) fn with_png(name: &OsStr) -> OsString {
    let mut name = name.to_owned();
    name.push(".png");
    name
}

/// Checks the name of a single picture's file.
///
/// # Errors
/// It does not end in .png.
pub(crate) fn single(path: &Path) -> Result<PathBuf> {
    if !is_png(path) {
        return Err(Error::invalid(
            "output",
            path.display(),
            "a name that ends in .png, or a folder",
        ));
    }
    Ok(path.to_owned())
}

/// Creates a folder and those that it lies in, unless they exist.
///
/// # Errors
/// The error names the folder.
pub(crate) fn make_folder(folder: &Path) -> Result<()> {
    if folder.as_os_str().is_empty() {
        return Ok(());
    }
    std::fs::create_dir_all(folder).map_err(|error| Error::file("make the folder", folder, error))
}

/// The bytes of a PNG file; without transparent pixels it has no alpha channel.
///
/// # Errors
/// A picture that is too large for the format.
pub(crate) fn encode(image: &Image) -> image::ImageResult<Vec<u8>> {
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

/// The end of the names of temporary files.
const PART: &str = ".part";

/// What the names of the temporary files of a file begin with.
fn part_prefix(name: &OsStr) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    prefix
}

/// Writes to a temporary file beside `path` and renames it. The temporary file is locked until then, so that others can
/// tell it from what a killed program has left ([`sweep`]).
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    // A symbolic link is kept; the file that it points to is replaced.
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let part = locked_part(path)?;
    let mut file = BufWriter::new(part.as_file());
    write(&mut file)?;
    file.flush()?;
    drop(file);
    part.persist(path)?;
    Ok(())
}

/// A new temporary file beside `path`, which no other program has, and which is removed when it is dropped.
fn locked_part(path: &Path) -> std::io::Result<NamedTempFile> {
    let prefix = part_prefix(path.file_name().unwrap_or_default());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(PART);
    loop {
        // Unlike tempfile's own way to create files, this gives everybody the usual access to them.
        let part =
            builder.make_in(folder.unwrap_or(Path::new(".")), |path| File::create_new(path))?;
        // Some file systems have no locks; there, nothing is ever swept.
        let is_locked = part.as_file().lock().is_ok();
        // Another program may have swept the file before it was locked.
        if !is_locked || part.path().exists() {
            return Ok(part);
        }
    }
}

/// Removes the temporary files that killed programs have left for files of these names in a folder. Files that are still
/// being written stay.
pub(crate) fn sweep(folder: &Path, names: &HashSet<OsString>) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| is_part_of(&entry.file_name(), names)) {
        let path = entry.path();
        // What cannot be opened, locked or removed is another program's, or gone.
        // For a lock, NFS asks for files that may be written.
        if let Ok(file) = File::options().write(true).open(&path)
            && file.try_lock().is_ok()
        {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// Whether a file's name is that of a temporary file for one of these names.
fn is_part_of(name: &OsStr, names: &HashSet<OsString>) -> bool {
    let name = name.to_string_lossy();
    let target = name.strip_prefix('.').and_then(|name| name.strip_suffix(PART));
    let target = target.and_then(|target| target.rsplit_once('.'));
    target.is_some_and(|(target, _)| names.contains(OsStr::new(target)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_one(scene: &str, output: Option<&str>) -> Result<Output> {
        Output::of_one(Path::new(scene), output.map(Path::new))
    }

    #[test]
    fn the_name_comes_from_the_scene() {
        let file = |name: &str| Output::File(name.into());
        assert_eq!(of_one("a/x.toml", None).unwrap(), file("x.png"));
        assert_eq!(of_one("a/x.toml", Some("z.PNG")).unwrap(), file("z.PNG"));
        assert_eq!(of_one("a/x.toml", Some("-")).unwrap(), Output::Standard);
        assert_eq!(of_one("-", None).unwrap(), file("freeform.png"));
        let folder = tempfile::tempdir().unwrap();
        let inside = format!("{}/new/", folder.path().display());
        assert_eq!(of_one("b/y.toml", Some(&inside)).unwrap(), file(&format!("{inside}y.png")));
        assert!(Path::new(&inside).is_dir());
        for output in ["x.jpg", "x"] {
            let text = of_one("x.toml", Some(output)).unwrap_err().to_string();
            assert!(text.contains(".png"), "{text}");
        }
    }

    #[test]
    fn only_what_killed_programs_left_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in [".x.png.abcdef.part", ".y.png.abcdef.part", ".x.png.part", "x.png"] {
            std::fs::write(path(name), "half").unwrap();
        }
        let names = HashSet::from(["x.png".into()]);
        replace(&path("x.png"), |file| {
            // The file that is being written is there during the sweep, and afterwards.
            sweep(folder.path(), &names);
            file.write_all(b"whole")
        })
        .unwrap();
        let mut left: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        assert_eq!(left, [".x.png.part", ".y.png.abcdef.part", "x.png"]);
        assert_eq!(std::fs::read(path("x.png")).unwrap(), b"whole");
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
