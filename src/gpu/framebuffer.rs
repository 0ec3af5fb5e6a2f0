//! Pictures that are drawn into without a window, and read back.

use std::sync::Arc;

use glow::{HasContext, PixelPackData};

use super::{DriverInfo, checked_size, create, transfer_plainly};
use crate::{Error, Image, Result};

/// A picture that can be drawn into without a window: RGBA with 8 bits each, and a 32-bit depth.
pub struct Framebuffer {
    gl: Arc<glow::Context>,
    raw: glow::Framebuffer,
    _color: Renderbuffer,
    _depth: Renderbuffer,
    width: u32,
    height: u32,
}

impl std::fmt::Debug for Framebuffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Framebuffer")
            .field("raw", &self.raw)
            .field("width", &self.width)
            .field("height", &self.height)
            .finish_non_exhaustive()
    }
}

impl Framebuffer {
    /// A picture of so many pixels, bound by nobody yet.
    ///
    /// # Errors
    /// A side of 0 pixels or beyond the driver's limit, or no memory for it.
    pub fn new(gl: &Arc<glow::Context>, width: u32, height: u32) -> Result<Self> {
        let most = DriverInfo::of(gl).max_size;
        let size = checked_size("resolution", (width, height), most)?;
        let color = Renderbuffer::new(gl, "picture", glow::RGBA8, size)?;
        let depth = Renderbuffer::new(gl, "depth", glow::DEPTH_COMPONENT32F, size)?;
        // SAFETY: the context is current (see the module); the framebuffer is new and ours, and
        // freed by `drop` from the moment `Self` holds it.
        unsafe {
            let raw = create("framebuffer", gl.create_named_framebuffer())?;
            for (buffer, attachment) in
                [(&color, glow::COLOR_ATTACHMENT0), (&depth, glow::DEPTH_ATTACHMENT)]
            {
                let kind = glow::RENDERBUFFER;
                gl.named_framebuffer_renderbuffer(Some(raw), attachment, kind, Some(buffer.raw));
            }
            gl.object_label(glow::FRAMEBUFFER, raw.0.get(), Some("offscreen picture"));
            let framebuffer =
                Self { gl: Arc::clone(gl), raw, _color: color, _depth: depth, width, height };
            let status = gl.check_named_framebuffer_status(Some(raw), glow::FRAMEBUFFER);
            if status != glow::FRAMEBUFFER_COMPLETE {
                return Err(Error::Driver {
                    what: format!("a picture of {width}x{height} pixels"),
                    reason: format!("framebuffer status {status:#06x}"),
                });
            }
            Ok(framebuffer)
        }
    }

    /// Makes this the target of drawing, over its whole size.
    pub fn bind(&self) {
        // SAFETY: the context is current (see the module); the sizes fitted an i32 in `new`.
        unsafe {
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, Some(self.raw));
            self.gl.viewport(0, 0, self.width as i32, self.height as i32);
        }
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The pixels as they are now, first row on top.
    ///
    /// # Panics
    /// Never: the buffer has the size of the picture.
    #[must_use]
    pub fn read(&self) -> Image {
        let row = 4 * self.width as usize;
        let mut bottom_up = vec![0; row * self.height as usize];
        transfer_plainly(&self.gl);
        // SAFETY: the context is current (see the module); the slice holds exactly the pixels that
        // are asked for, and the transfer writes them without gaps.
        unsafe {
            self.gl.bind_framebuffer(glow::READ_FRAMEBUFFER, Some(self.raw));
            self.gl.read_pixels(
                0,
                0,
                self.width as i32,
                self.height as i32,
                glow::RGBA,
                glow::UNSIGNED_BYTE,
                PixelPackData::Slice(Some(&mut bottom_up)),
            );
        }
        let mut image = Image::new(self.width, self.height);
        for (to, from) in image.chunks_exact_mut(row).zip(bottom_up.chunks_exact(row).rev()) {
            to.copy_from_slice(from);
        }
        image
    }
}

impl Drop for Framebuffer {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the framebuffer.
        unsafe { self.gl.delete_framebuffer(self.raw) }
    }
}

/// The memory of one attachment.
struct Renderbuffer {
    gl: Arc<glow::Context>,
    raw: glow::Renderbuffer,
}

impl Renderbuffer {
    fn new(gl: &Arc<glow::Context>, label: &str, format: u32, size: [i32; 2]) -> Result<Self> {
        // SAFETY: the context is current (see the module); the renderbuffer is new and ours.
        unsafe {
            let raw = create(label, gl.create_renderbuffer())?;
            gl.bind_renderbuffer(glow::RENDERBUFFER, Some(raw));
            gl.renderbuffer_storage(glow::RENDERBUFFER, format, size[0], size[1]);
            gl.object_label(glow::RENDERBUFFER, raw.0.get(), Some(label));
            Ok(Self { gl: Arc::clone(gl), raw })
        }
    }
}

impl Drop for Renderbuffer {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the renderbuffer.
        unsafe { self.gl.delete_renderbuffer(self.raw) }
    }
}
