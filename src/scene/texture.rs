//! Pictures for surfaces: PNG, JPEG and BMP files, recognized by their first bytes.

use std::io::{BufReader, Cursor};
use std::path::Path;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader, Limits};

use super::Image;
use crate::error::{Cause, Error, Result};

/// The formats of pictures.
const FORMATS: [ImageFormat; 3] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp];
/// The width and height that every OpenGL 4.5 driver can hold in a texture.
const MAX_SIDE: u32 = 16_384;
/// The maximum number of pixels: 256 MiB in memory. Without a limit, a small file could hold a picture that exhausts
/// the memory.
const MAX_PIXELS: u64 = 64 << 20;
/// The maximum number of bytes that decoding may allocate: 16 bits for each of four channels of a pixel.
const MAX_BYTES: u64 = 8 * MAX_PIXELS;

/// Reads a picture, and applies the orientation that its file gives (EXIF).
///
/// # Errors
/// A file that cannot be read, is not a PNG, JPEG or BMP picture, or is larger than 16,384 pixels a side or 64
/// million in all.
pub fn load_texture(path: &Path) -> Result<Image> {
    let fail = |cause: Cause| Error::file("read", path, cause);
    let metadata = std::fs::metadata(path).map_err(|error| fail(error.into()))?;
    if !metadata.is_file() {
        return Err(fail("it is a folder or a device, expected a picture".into()));
    }
    let open = || -> std::io::Result<ImageReader<BufReader<std::fs::File>>> {
        ImageReader::open(path)?.with_guessed_format()
    };
    let reader = open().map_err(|error| fail(error.into()))?;
    // The image library also reads other formats, because the program writes them.
    if let Some(format) = reader.format().filter(|format| !FORMATS.contains(format)) {
        return Err(fail(format!("no PNG, JPEG or BMP picture (it is {format:?})").into()));
    }
    let (width, height) = reader
        .into_dimensions()
        .map_err(|error| fail(format!("no PNG, JPEG or BMP picture ({error})").into()))?;
    if width > MAX_SIDE || height > MAX_SIDE || width == 0 || height == 0 {
        return Err(fail(
            format!("it has {width} × {height} pixels; a texture has 1 to {MAX_SIDE} a side")
                .into(),
        ));
    }
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS {
        return Err(fail(
            format!("it has {pixels} pixels; a texture has at most {MAX_PIXELS}").into(),
        ));
    }
    let mut reader = open().map_err(|error| fail(error.into()))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|error| fail(error.into()))?;
    // The orientation of the camera is stored beside the pixels.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|error| fail(error.into()))?;
    picture.apply_orientation(orientation);
    Ok(picture.into_rgba8())
}

/// The brick picture of `resources/textures`, which is embedded in the library.
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

    /// A JPEG of 16 × 8 pixels, red to the left and blue to the right, with an EXIF block that gives its orientation.
    fn jpeg(orientation: u8) -> Vec<u8> {
        let color = |x| if x < 8 { [255, 0, 0] } else { [0, 0, 255] };
        let image = image::RgbImage::from_fn(16, 8, |x, _| image::Rgb(color(x)));
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
        // One entry of a little-endian TIFF directory: tag 0x0112, a short, once.
        let mut exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
        exif.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
        let mut whole = vec![0xff, 0xd8, 0xff, 0xe1];
        whole.extend((exif.len() as u16 + 2).to_be_bytes());
        whole.extend(exif);
        whole.extend(&bytes.get_ref()[2..]);
        whole
    }

    #[test]
    fn pictures_are_turned_as_their_files_say() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let is_red = |pixel: &image::Rgba<u8>| pixel.0[0] > 200 && pixel.0[2] < 60;
        // The size of the picture after it is turned, and where red and blue lie in it.
        for (orientation, size, red, blue) in [
            (1, (16, 8), (2, 4), (13, 4)),
            (2, (16, 8), (13, 4), (2, 4)),
            (3, (16, 8), (13, 4), (2, 4)),
            (4, (16, 8), (2, 4), (13, 4)),
            (5, (8, 16), (4, 2), (4, 13)),
            (6, (8, 16), (4, 2), (4, 13)),
            (7, (8, 16), (4, 13), (4, 2)),
            (8, (8, 16), (4, 13), (4, 2)),
        ] {
            std::fs::write(&path, jpeg(orientation)).unwrap();
            let image = load_texture(&path).unwrap();
            assert_eq!(image.dimensions(), size, "{orientation}");
            assert!(is_red(image.get_pixel(red.0, red.1)), "{orientation}");
            assert!(!is_red(image.get_pixel(blue.0, blue.1)), "{orientation}");
        }
    }

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
