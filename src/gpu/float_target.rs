//! Floating-point render targets without a window, which are read back.

use glow::{HasContext, PixelPackData};

use super::framebuffer::Renderbuffer;
use super::{DriverInfo, Gl, checked_size, create, transfer_plainly};
use crate::error::{Error, Result};

/// A framebuffer object with several colour attachments of four 32-bit floats per pixel, and a
/// 32-bit depth attachment.
pub struct FloatTarget {
    gl: Gl,
    raw: glow::Framebuffer,
    colors: Vec<Renderbuffer>,
    _depth: Renderbuffer,
    width: u32,
    height: u32,
}

impl std::fmt::Debug for FloatTarget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FloatTarget")
            .field("raw", &self.raw)
            .field("width", &self.width)
            .field("height", &self.height)
            .finish_non_exhaustive()
    }
}

impl FloatTarget {
    /// Creates a target of the given size with `pictures` single-sample colour attachments. It is
    /// not bound.
    ///
    /// # Errors
    /// A width or height of 0 or beyond the driver's limit, or no memory.
    pub fn new(gl: &Gl, (width, height): (u32, u32), pictures: u32) -> Result<Self> {
        let size = checked_size("resolution", (width, height), DriverInfo::of(gl).max_size)?;
        let colors = (0..pictures)
            .map(|_| Renderbuffer::new(gl, "numbers", glow::RGBA32F, size, 1))
            .collect::<Result<Vec<_>>>()?;
        let depth = Renderbuffer::new(gl, "depth", glow::DEPTH_COMPONENT32F, size, 1)?;
        // SAFETY: the context is current (see the module); the framebuffer is new and ours, and
        // `drop` deletes it once `Self` holds it.
        unsafe {
            let raw = create("framebuffer", gl.create_named_framebuffer())?;
            let attachments: Vec<u32> =
                (0..pictures).map(|picture| glow::COLOR_ATTACHMENT0 + picture).collect();
            let attach = |attachment: u32, buffer: &Renderbuffer| {
                let kind = glow::RENDERBUFFER;
                gl.named_framebuffer_renderbuffer(Some(raw), attachment, kind, Some(buffer.raw()));
            };
            for (attachment, color) in attachments.iter().zip(&colors) {
                attach(*attachment, color);
            }
            attach(glow::DEPTH_ATTACHMENT, &depth);
            gl.named_framebuffer_draw_buffers(Some(raw), &attachments);
            gl.object_label(glow::FRAMEBUFFER, raw.0.get(), Some("numbers"));
            let target = Self { gl: gl.clone(), raw, colors, _depth: depth, width, height };
            let status = gl.check_named_framebuffer_status(Some(raw), glow::FRAMEBUFFER);
            if status != glow::FRAMEBUFFER_COMPLETE {
                return Err(Error::Driver {
                    what: format!("numbers for {width}x{height} pixels"),
                    reason: format!("framebuffer status {status:#06x}"),
                });
            }
            Ok(target)
        }
    }

    /// Binds the framebuffer, sets the viewport to its size, and clears it to zeros and depth 1.
    /// Leaves rasterizer discard off and depth writes on.
    pub fn bind_cleared(&self) {
        // SAFETY: the context is current (see the module); the sizes fitted an i32 in `new`.
        unsafe {
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, Some(self.raw));
            self.gl.viewport(0, 0, self.width as i32, self.height as i32);
            self.gl.disable(glow::RASTERIZER_DISCARD);
            self.gl.depth_mask(true);
            for picture in 0..self.colors.len() as u32 {
                self.gl.clear_buffer_f32_slice(glow::COLOR, picture, &[0.0; 4]);
            }
            self.gl.clear_buffer_f32_slice(glow::DEPTH, 0, &[1.0]);
        }
    }

    /// The number of colour attachments.
    pub(crate) fn pictures(&self) -> u32 {
        self.colors.len() as u32
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The pixels of one attachment, rows from top to bottom. Leaves the framebuffer bound for
    /// reading.
    #[must_use]
    pub fn read(&self, picture: u32) -> Vec<[f32; 4]> {
        let (width, height) = (self.width as usize, self.height as usize);
        let mut bottom_up = vec![[0.0_f32; 4]; width * height];
        transfer_plainly(&self.gl);
        // SAFETY: the context is current (see the module); the slice holds exactly the pixels that
        // are asked for, and the transfer writes them without gaps.
        unsafe {
            self.gl.bind_framebuffer(glow::READ_FRAMEBUFFER, Some(self.raw));
            self.gl.read_buffer(glow::COLOR_ATTACHMENT0 + picture);
            self.gl.read_pixels(
                0,
                0,
                width as i32,
                height as i32,
                glow::RGBA,
                glow::FLOAT,
                PixelPackData::Slice(Some(bytemuck::cast_slice_mut(&mut bottom_up))),
            );
        }
        bottom_up.chunks_exact(width).rev().flatten().copied().collect()
    }
}

impl Drop for FloatTarget {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the framebuffer.
        unsafe { self.gl.delete_framebuffer(self.raw) }
    }
}
