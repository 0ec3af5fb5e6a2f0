//! Values that shaders fetch by their number.

use bytemuck::Pod;
use glam::Vec4;
use glow::HasContext;

use super::{Buffer, Gl, create};
use crate::error::{Error, Result};

/// A buffer that shaders read through buffer textures: as words (`R32UI`), as four floats at a time
/// (`RGBA32F`), or as both.
pub struct TexelBuffer {
    gl: Gl,
    views: Vec<glow::Texture>,
    buffer: Buffer,
}

impl std::fmt::Debug for TexelBuffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TexelBuffer").field("views", &self.views).finish_non_exhaustive()
    }
}

impl TexelBuffer {
    /// A buffer of words, of which there must be some, with both views.
    ///
    /// # Errors
    /// More words than the driver's buffer textures have texels, no memory.
    pub fn of_words(gl: &Gl, label: &str, words: &[u32]) -> Result<Self> {
        Self::new(gl, label, words, &[glow::R32UI, glow::RGBA32F])
    }

    /// A buffer of vectors, of which there must be some.
    ///
    /// # Errors
    /// More than the driver's buffer textures have texels, no memory.
    pub fn of_vectors(gl: &Gl, label: &str, vectors: &[Vec4]) -> Result<Self> {
        Self::new(gl, label, vectors, &[glow::RGBA32F])
    }

    fn new<T: Pod>(gl: &Gl, label: &str, values: &[T], formats: &[u32]) -> Result<Self> {
        // SAFETY: the context is current (see the module).
        let max = unsafe { gl.get_parameter_i32(glow::MAX_TEXTURE_BUFFER_SIZE) };
        if values.len() > usize::try_from(max).unwrap_or(0) {
            return Err(Error::Driver {
                what: label.to_owned(),
                reason: format!("{} values; its buffer textures hold at most {max}", values.len()),
            });
        }
        let buffer = Buffer::new(gl, label, values)?;
        // What is made is freed by `drop`, also if the next view fails.
        let mut texels = Self { gl: gl.clone(), views: Vec::new(), buffer };
        for format in formats {
            // SAFETY: the context is current (see the module); the texture is new and ours, and the
            // buffer lives as long as it.
            unsafe {
                let raw = create(label, gl.create_named_texture(glow::TEXTURE_BUFFER))?;
                texels.views.push(raw);
                // glow 0.17 has no call that needs no binding.
                gl.bind_texture(glow::TEXTURE_BUFFER, Some(raw));
                gl.tex_buffer(glow::TEXTURE_BUFFER, *format, Some(texels.buffer.raw()));
                gl.bind_texture(glow::TEXTURE_BUFFER, None);
                gl.object_label(glow::TEXTURE, raw.0.get(), Some(label));
            }
        }
        Ok(texels)
    }

    /// The values themselves, to be overwritten or to be drawn from.
    #[must_use]
    pub const fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// Binds the views to texture units from this one on, words before vectors.
    pub fn bind(&self, unit: u32) {
        for (unit, view) in (unit..).zip(&self.views) {
            // SAFETY: the context is current (see the module); the textures live as long as `self`.
            unsafe { self.gl.bind_texture_unit(unit, Some(*view)) }
        }
    }
}

impl Drop for TexelBuffer {
    fn drop(&mut self) {
        for view in &self.views {
            // SAFETY: the context is current (see the module); nothing else owns the texture.
            unsafe { self.gl.delete_texture(*view) }
        }
    }
}
