//! Buffer textures: values that shaders fetch by index.

use bytemuck::Pod;
use glam::Vec4;
use glow::HasContext;

use super::{Buffer, Gl, create};
use crate::error::{Error, Result};

/// A buffer that shaders read through buffer textures: as 32-bit words (`R32UI`), as texels of four
/// floats (`RGBA32F`), or both. Each of the two is called a view.
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
    /// A buffer of 32-bit words with both views; `words` must not be empty.
    ///
    /// # Errors
    /// More words than a buffer texture of the driver can have texels, or no memory.
    pub fn of_words(gl: &Gl, label: &str, words: &[u32]) -> Result<Self> {
        Self::new(gl, label, words, &[glow::R32UI, glow::RGBA32F])
    }

    /// A buffer of vectors with a view of four floats per texel; `vectors` must not be empty.
    ///
    /// # Errors
    /// More vectors than a buffer texture of the driver can have texels, or no memory.
    pub fn of_vectors(gl: &Gl, label: &str, vectors: &[Vec4]) -> Result<Self> {
        Self::new(gl, label, vectors, &[glow::RGBA32F])
    }

    /// A buffer of texels of four words each, with room for `count`. They are 0.
    ///
    /// # Errors
    /// More texels than a buffer texture of the driver can have, or no memory.
    pub(crate) fn of_texels(gl: &Gl, label: &str, count: usize) -> Result<Self> {
        Self::new(gl, label, &vec![[0_u32; 4]; count], &[glow::RGBA32UI])
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
        // From here on, `drop` deletes what exists, also if the next view fails.
        let mut texels = Self { gl: gl.clone(), views: Vec::new(), buffer };
        for format in formats {
            // SAFETY: the context is current (see the module); the texture is new and ours,
            // and the buffer lives as long as the texture.
            unsafe {
                let raw = create(label, gl.create_named_texture(glow::TEXTURE_BUFFER))?;
                texels.views.push(raw);
                // glow 0.17 lacks `glTextureBuffer`.
                gl.bind_texture(glow::TEXTURE_BUFFER, Some(raw));
                gl.tex_buffer(glow::TEXTURE_BUFFER, *format, Some(texels.buffer.raw()));
                gl.bind_texture(glow::TEXTURE_BUFFER, None);
                gl.object_label(glow::TEXTURE, raw.0.get(), Some(label));
            }
        }
        Ok(texels)
    }

    /// The underlying buffer object, for overwriting values or as vertex input.
    #[must_use]
    pub const fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// Binds the views to consecutive texture units from `unit` on: the words, then the vectors.
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
