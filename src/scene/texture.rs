//! Pictures for surfaces: PNG, JPEG and BMP files, told apart by their first bytes.

use std::io::{BufReader, Cursor};
use std::path::Path;

use image::{ImageFormat, ImageReader, Limits};

use super::Image;
use crate::{Error, Result};

/// What a picture may be.
const FORMATS: [ImageFormat; 3] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp];
/// The width and height that every OpenGL 4.5 driver can hold in a texture.
const MAX_SIDE: u32 = 16_384;
/// The most pixels: 256 MiB in memory. A small file can hold a picture that fills any memory.
const MAX_PIXELS: u64 = 64 << 20;
/// What decoding may need besides: 16 bits for each of four channels.
const MAX_BYTES: u64 = 8 * MAX_PIXELS;

/// Reads a picture.
///
/// # Errors
/// A file that cannot be read, is no PNG, JPEG or BMP picture, or is larger than 16,384 pixels a
/// side or 64 million in all.
pub fn load_texture(path: &Path) -> Result<Image> {
    let fail = |reason: String| Error::File { action: "read", path: path.to_owned(), reason };
    let metadata = std::fs::metadata(path).map_err(|error| fail(error.to_string()))?;
    if !metadata.is_file() {
        return Err(fail("it is a folder or a device, expected a picture".into()));
    }
    let open = || -> std::io::Result<ImageReader<BufReader<std::fs::File>>> {
        ImageReader::open(path)?.with_guessed_format()
    };
    let reader = open().map_err(|error| fail(error.to_string()))?;
    // The program can write other formats, and so could read them.
    if let Some(format) = reader.format().filter(|format| !FORMATS.contains(format)) {
        return Err(fail(format!("no PNG, JPEG or BMP picture (it is {format:?})")));
    }
    let (width, height) = reader
        .into_dimensions()
        .map_err(|error| fail(format!("no PNG, JPEG or BMP picture ({error})")))?;
    if width > MAX_SIDE || height > MAX_SIDE || width == 0 || height == 0 {
        return Err(fail(format!(
            "it has {width} × {height} pixels; a texture has 1 to {MAX_SIDE} a side"
        )));
    }
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS {
        return Err(fail(format!("it has {pixels} pixels; a texture has at most {MAX_PIXELS}")));
    }
    let mut reader = open().map_err(|error| fail(error.to_string()))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| fail(error.to_string()))?;
    Ok(picture.into_rgba8())
}

/// The brick picture of `resources/textures`, which travels inside the library.
pub(super) fn brick() -> Image {
    let bytes = include_bytes!("../../resources/textures/brick.png");
    ImageReader::with_format(Cursor::new(bytes), image::ImageFormat::Png)
        .decode()
        .expect("the picture inside the library is whole")
        .into_rgba8()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_program_only_writes_is_no_picture_for_a_surface() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        // The first bytes of OpenEXR.
        std::fs::write(&path, [0x76, 0x2f, 0x31, 0x01, 0x02, 0, 0, 0]).unwrap();
        let text = load_texture(&path).unwrap_err().to_string();
        assert!(text.contains("no PNG") && text.contains("OpenExr"), "{text}");
    }
}
