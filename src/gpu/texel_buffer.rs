//! Words that shaders fetch by their number, for the trims' grids.

use std::sync::Arc;

use glow::HasContext;

use super::{Buffer, create};
use crate::{Error, Result};

/// A buffer that shaders read through two buffer textures: as words (`R32UI`), and as four floats at
/// a time (`RGBA32F`).
pub struct TexelBuffer {
    gl: Arc<glow::Context>,
    views: [glow::Texture; 2],
    _buffer: Buffer,
}

impl std::fmt::Debug for TexelBuffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TexelBuffer").field("views", &self.views).finish_non_exhaustive()
    }
}

impl TexelBuffer {
    /// A buffer of words, of which there must be some.
    ///
    /// # Errors
    /// More words than the driver's buffer textures have texels, no memory.
    pub fn new(gl: &Arc<glow::Context>, label: &str, words: &[u32]) -> Result<Self> {
        // SAFETY: the context is current (see the module).
        let most = unsafe { gl.get_parameter_i32(glow::MAX_TEXTURE_BUFFER_SIZE) };
        if words.len() > usize::try_from(most).unwrap_or(0) {
            return Err(Error::Driver {
                what: label.to_owned(),
                reason: format!("{} words; its buffer textures have at most {most}", words.len()),
            });
        }
        let buffer = Buffer::new(gl, label, words)?;
        let view = |format: u32| {
            // SAFETY: the context is current (see the module); the texture is new and ours, and the
            // buffer lives as long as it.
            unsafe {
                let raw = create(label, gl.create_named_texture(glow::TEXTURE_BUFFER))?;
                // glow 0.17 has no call that needs no binding.
                gl.bind_texture(glow::TEXTURE_BUFFER, Some(raw));
                gl.tex_buffer(glow::TEXTURE_BUFFER, format, Some(buffer.raw()));
                gl.bind_texture(glow::TEXTURE_BUFFER, None);
                gl.object_label(glow::TEXTURE, raw.0.get(), Some(label));
                Ok(raw)
            }
        };
        let words = view(glow::R32UI)?;
        let points = view(glow::RGBA32F).inspect_err(|_| {
            // SAFETY: the context is current (see the module); nothing else owns the texture.
            unsafe { gl.delete_texture(words) }
        })?;
        Ok(Self { gl: Arc::clone(gl), views: [words, points], _buffer: buffer })
    }

    /// Binds the words to a texture unit and the floats to the next.
    pub fn bind(&self, unit: u32) {
        for (unit, view) in (unit..).zip(self.views) {
            // SAFETY: the context is current (see the module); the textures live as long as `self`.
            unsafe { self.gl.bind_texture_unit(unit, Some(view)) }
        }
    }
}

impl Drop for TexelBuffer {
    fn drop(&mut self) {
        for view in self.views {
            // SAFETY: the context is current (see the module); nothing else owns the texture.
            unsafe { self.gl.delete_texture(view) }
        }
    }
}
