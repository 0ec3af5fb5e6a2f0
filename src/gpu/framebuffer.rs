use std::sync::Arc;

use glow::{HasContext, PixelPackData};

use super::create;
use crate::{Error, Image, Result};

/// A picture that can be drawn into without a window: RGBA with 8 bits each, and a 32-bit depth.
pub struct Framebuffer {
    gl: Arc<glow::Context>,
    raw: glow::Framebuffer,
    color: glow::Renderbuffer,
    depth: glow::Renderbuffer,
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
    /// # Errors
    /// A side of 0 pixels or beyond the driver's limit, or no memory for it.
    pub fn new(gl: &Arc<glow::Context>, width: u32, height: u32) -> Result<Self> {
        let most = super::DriverInfo::of(gl).max_size;
        let side = |size: u32| i32::try_from(size).ok().filter(|size| (1..=most).contains(size));
        let (Some(gl_width), Some(gl_height)) = (side(width), side(height)) else {
            return Err(Error::invalid(
                "resolution",
                format!("{width}x{height}"),
                format!("1 to {most} pixels a side with this driver"),
            ));
        };
        // SAFETY: the context is current (see the module); the three objects are new and ours, and
        // freed by `drop` from the moment `Self` holds them.
        unsafe {
            let framebuffer = Self {
                gl: Arc::clone(gl),
                raw: create("framebuffer", gl.create_framebuffer())?,
                color: create("colour renderbuffer", gl.create_renderbuffer())?,
                depth: create("depth renderbuffer", gl.create_renderbuffer())?,
                width,
                height,
            };
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(framebuffer.raw));
            for (buffer, format, attachment, label) in [
                (framebuffer.color, glow::RGBA8, glow::COLOR_ATTACHMENT0, "picture"),
                (framebuffer.depth, glow::DEPTH_COMPONENT32F, glow::DEPTH_ATTACHMENT, "depth"),
            ] {
                gl.bind_renderbuffer(glow::RENDERBUFFER, Some(buffer));
                gl.renderbuffer_storage(glow::RENDERBUFFER, format, gl_width, gl_height);
                gl.object_label(glow::RENDERBUFFER, buffer.0.get(), Some(label));
                gl.framebuffer_renderbuffer(
                    glow::FRAMEBUFFER,
                    attachment,
                    glow::RENDERBUFFER,
                    Some(buffer),
                );
            }
            gl.object_label(glow::FRAMEBUFFER, framebuffer.raw.0.get(), Some("offscreen picture"));
            let status = gl.check_framebuffer_status(glow::FRAMEBUFFER);
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
        // SAFETY: the context is current (see the module); the slice holds exactly the pixels that
        // are asked for, rows of 4-byte pixels need no padding.
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
        // SAFETY: the context is current (see the module); nothing else owns the three objects.
        unsafe {
            self.gl.delete_framebuffer(self.raw);
            self.gl.delete_renderbuffer(self.color);
            self.gl.delete_renderbuffer(self.depth);
        }
    }
}
