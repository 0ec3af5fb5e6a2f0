//! Textures of surfaces, with mipmaps.

use std::borrow::Cow;

use glow::{HasContext, PixelUnpackData};

use super::{Gl, check_memory, checked_size, create, size_i32, transfer_plainly};
use crate::error::Result;
use crate::scene::Image;

/// A texture: RGBA with 8 bits per channel, without conversion from sRGB. Filtering is trilinear.
/// Coordinates are clamped to the edge unless the texture repeats.
pub struct Texture {
    gl: Gl,
    raw: glow::Texture,
    has_holes: bool,
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Texture").field("raw", &self.raw).finish()
    }
}

impl Texture {
    pub(super) const fn raw(&self) -> glow::Texture {
        self.raw
    }

    /// Whether any texel has an alpha below 1.
    pub(crate) const fn has_holes(&self) -> bool {
        self.has_holes
    }

    /// Uploads an image; its first row is at v = 1.
    ///
    /// # Errors
    /// An image without pixels or larger than the driver allows, or no memory.
    pub fn new(gl: &Gl, label: &str, image: &Image) -> Result<Self> {
        // SAFETY: the context is current (see the module).
        let max = unsafe { gl.get_parameter_i32(glow::MAX_TEXTURE_SIZE) };
        let [width, height] = checked_size("texture size", image.dimensions(), max)?;
        size_i32(label, image.len())?;
        let levels = 1 + width.max(height).ilog2();
        // SAFETY: the context is current (see the module); the texture is new and ours.
        let texture = unsafe {
            let raw = create(label, gl.create_named_texture(glow::TEXTURE_2D))?;
            gl.texture_storage_2d(raw, levels as i32, glow::RGBA8, width, height);
            let has_holes = image.pixels().any(|pixel| pixel.0[3] < 255);
            Self { gl: gl.clone(), raw, has_holes }
        };
        check_memory(gl, label, image.len() as u64)?;
        // Mipmaps are made here: OpenGL does not specify how drivers make them, and Mesa's software
        // driver compiles a shader for each level, which takes far longer (ARCHITECTURE.md).
        let mut image = Cow::Borrowed(image);
        texture.upload(0, &image);
        for level in 1..levels {
            let (width, height) = ((image.width() / 2).max(1), (image.height() / 2).max(1));
            image = Cow::Owned(image::imageops::thumbnail(image.as_ref(), width, height));
            texture.upload(level, &image);
        }
        // SAFETY: the context is current (see the module).
        unsafe {
            for (parameter, value) in [
                (glow::TEXTURE_MIN_FILTER, glow::LINEAR_MIPMAP_LINEAR),
                (glow::TEXTURE_MAG_FILTER, glow::LINEAR),
                (glow::TEXTURE_WRAP_S, glow::CLAMP_TO_EDGE),
                (glow::TEXTURE_WRAP_T, glow::CLAMP_TO_EDGE),
            ] {
                gl.texture_parameter_i32(texture.raw, parameter, value as i32);
            }
            gl.object_label(glow::TEXTURE, texture.raw.0.get(), Some(label));
        }
        Ok(texture)
    }

    /// Makes the texture repeat.
    #[must_use]
    pub(crate) fn repeating(self) -> Self {
        // SAFETY: the context is current (see the module); the texture is ours.
        unsafe {
            for axis in [glow::TEXTURE_WRAP_S, glow::TEXTURE_WRAP_T] {
                self.gl.texture_parameter_i32(self.raw, axis, glow::REPEAT as i32);
            }
        }
        self
    }

    /// Uploads one mipmap level. The image must have the level's size.
    fn upload(&self, level: u32, image: &Image) {
        let row = 4 * image.width() as usize;
        let bottom_up: Vec<u8> = image.chunks_exact(row).rev().flatten().copied().collect();
        transfer_plainly(&self.gl);
        // SAFETY: the context is current (see the module); the pixels are exactly width × height
        // RGBA texels, and the transfer reads them without gaps.
        unsafe {
            self.gl.texture_sub_image_2d(
                self.raw,
                level as i32,
                0,
                0,
                image.width() as i32,
                image.height() as i32,
                glow::RGBA,
                glow::UNSIGNED_BYTE,
                PixelUnpackData::Slice(Some(&bottom_up)),
            );
        }
    }

    /// Binds the texture to a unit.
    pub fn bind(&self, unit: u32) {
        // SAFETY: the context is current (see the module); the texture lives as long as `self`.
        unsafe { self.gl.bind_texture_unit(unit, Some(self.raw)) }
    }
}

impl Drop for Texture {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the texture.
        unsafe { self.gl.delete_texture(self.raw) }
    }
}
