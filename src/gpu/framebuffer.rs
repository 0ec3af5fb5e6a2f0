//! Render targets without a window, whose pictures are read back.

use glow::{HasContext, PixelPackData};

use super::{DriverInfo, Gl, Texture, check_memory, checked_size, create, transfer_plainly};
use crate::error::{Error, Result};
use crate::scene::Image;

/// A framebuffer object: RGBA with 8 bits per channel, and a 32-bit depth.
pub struct Framebuffer {
    gl: Gl,
    raw: glow::Framebuffer,
    _color: Renderbuffer,
    _depth: Option<Renderbuffer>,
    width: u32,
    height: u32,
    samples: u32,
    /// The single-sample framebuffer that multisampled pixels are resolved to.
    resolved: Option<Box<Self>>,
}

impl std::fmt::Debug for Framebuffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Framebuffer")
            .field("raw", &self.raw)
            .field("width", &self.width)
            .field("height", &self.height)
            .field("samples", &self.samples)
            .finish_non_exhaustive()
    }
}

impl Framebuffer {
    /// Creates a framebuffer of `width` × `height` pixels with one sample each. It is not bound.
    ///
    /// # Errors
    /// A width or height of 0 or beyond the driver's limit, or no memory.
    pub fn new(gl: &Gl, width: u32, height: u32) -> Result<Self> {
        Self::with_samples(gl, width, height, 1)
    }

    /// A framebuffer with `samples` samples per pixel, or more if the driver does not support this
    /// number; [`Framebuffer::read`] averages them.
    ///
    /// # Errors
    /// As [`Framebuffer::new`]; 0 samples, or more than the driver supports
    /// ([`DriverInfo::max_samples`]).
    pub fn with_samples(gl: &Gl, width: u32, height: u32, samples: u32) -> Result<Self> {
        let info = DriverInfo::of(gl);
        let size = checked_size("resolution", (width, height), info.max_size)?;
        let max = u32::try_from(info.max_samples).unwrap_or(0).max(1);
        if !(1..=max).contains(&samples) {
            let range = format!("1 to {max} with this driver");
            return Err(Error::invalid("samples of a framebuffer", samples, range));
        }
        let resolved = if samples > 1 {
            let color = Renderbuffer::new(gl, "resolved picture", glow::RGBA8, size, 1)?;
            Some(Box::new(Self::of(gl, color, None, None)?))
        } else {
            None
        };
        let color = Renderbuffer::new(gl, "picture", glow::RGBA8, size, samples)?;
        let depth = Renderbuffer::new(gl, "depth", glow::DEPTH_COMPONENT32F, size, samples)?;
        Self::of(gl, color, Some(depth), resolved)
    }

    fn of(
        gl: &Gl,
        color: Renderbuffer,
        depth: Option<Renderbuffer>,
        resolved: Option<Box<Self>>,
    ) -> Result<Self> {
        let Renderbuffer { size: [width, height], samples, .. } = color;
        // SAFETY: the context is current (see the module); the framebuffer is new and ours, and
        // `drop` deletes it once `Self` holds it.
        unsafe {
            let raw = create("framebuffer", gl.create_named_framebuffer())?;
            for (buffer, attachment) in
                [(Some(&color), glow::COLOR_ATTACHMENT0), (depth.as_ref(), glow::DEPTH_ATTACHMENT)]
            {
                let Some(buffer) = buffer else { continue };
                let kind = glow::RENDERBUFFER;
                gl.named_framebuffer_renderbuffer(Some(raw), attachment, kind, Some(buffer.raw));
            }
            gl.object_label(glow::FRAMEBUFFER, raw.0.get(), Some("offscreen picture"));
            let framebuffer = Self {
                gl: gl.clone(),
                raw,
                _color: color,
                _depth: depth,
                width: width as u32,
                height: height as u32,
                samples,
                resolved,
            };
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

    /// Binds the framebuffer and sets the viewport to its size.
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

    /// The requested number of samples per pixel.
    #[must_use]
    pub const fn samples(&self) -> u32 {
        self.samples
    }

    /// Copies the pixels, each the average of its samples, to the lower left corner of the default
    /// framebuffer (the window).
    pub fn show(&self) {
        if let Some(resolved) = &self.resolved {
            self.copy_to(Some(resolved.raw));
            resolved.show();
        } else {
            self.copy_to(None);
        }
    }

    /// Replaces the pixels by those of an image of the same size. The framebuffer must have one
    /// sample per pixel.
    ///
    /// # Errors
    /// No memory for a copy of the image.
    pub fn write(&self, image: &Image) -> Result<()> {
        let texture = Texture::new(&self.gl, "a picture to be copied", image)?;
        // SAFETY: the context is current (see the module); the framebuffer is ours and
        // is deleted after its use.
        unsafe {
            let from = create("framebuffer", self.gl.create_named_framebuffer())?;
            let picture = Some(texture.raw());
            self.gl.named_framebuffer_texture(Some(from), glow::COLOR_ATTACHMENT0, picture, 0);
            self.copy(Some(from), Some(self.raw));
            self.gl.delete_framebuffer(from);
        }
        Ok(())
    }

    /// Copies the colours to another framebuffer; `None` is the default one.
    fn copy_to(&self, other: Option<glow::Framebuffer>) {
        self.copy(Some(self.raw), other);
    }

    /// Copies colours from one framebuffer to another, in the rectangle of this framebuffer's size.
    fn copy(&self, from: Option<glow::Framebuffer>, to: Option<glow::Framebuffer>) {
        let (width, height) = (self.width as i32, self.height as i32);
        // SAFETY: the context is current (see the module); both are its framebuffers. A
        // blit is clipped to their sizes.
        unsafe {
            // The scissor test clips blits too.
            let scissor = self.gl.is_enabled(glow::SCISSOR_TEST);
            self.gl.disable(glow::SCISSOR_TEST);
            self.gl.blit_named_framebuffer(
                from,
                to,
                0,
                0,
                width,
                height,
                0,
                0,
                width,
                height,
                glow::COLOR_BUFFER_BIT,
                glow::NEAREST,
            );
            if scissor {
                self.gl.enable(glow::SCISSOR_TEST);
            }
        }
    }

    /// The pixels, each the average of its samples, rows from top to bottom. Leaves a framebuffer
    /// bound for reading.
    #[must_use]
    pub fn read(&self) -> Image {
        let (width, height) = (self.width as i32, self.height as i32);
        if let Some(resolved) = &self.resolved {
            self.copy_to(Some(resolved.raw));
            return resolved.read();
        }
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
                width,
                height,
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

/// A renderbuffer: one attachment of a framebuffer.
pub(super) struct Renderbuffer {
    gl: Gl,
    raw: glow::Renderbuffer,
    size: [i32; 2],
    samples: u32,
}

impl Renderbuffer {
    pub(super) fn new(
        gl: &Gl,
        label: &str,
        format: u32,
        size: [i32; 2],
        samples: u32,
    ) -> Result<Self> {
        let [width, height] = size;
        // In OpenGL, 0 samples means a renderbuffer without multisampling.
        let several = if samples > 1 { samples as i32 } else { 0 };
        // SAFETY: the context is current (see the module); the renderbuffer is new and ours.
        unsafe {
            let raw = create(label, gl.create_renderbuffer())?;
            // From here on, `drop` deletes it.
            let buffer = Self { gl: gl.clone(), raw, size, samples };
            gl.bind_renderbuffer(glow::RENDERBUFFER, Some(raw));
            let kind = glow::RENDERBUFFER;
            gl.renderbuffer_storage_multisample(kind, several, format, width, height);
            let pixel = if format == glow::RGBA32F { 16 } else { 4 };
            let bytes = pixel * u64::from(samples) * width as u64 * height as u64;
            check_memory(gl, label, bytes)?;
            gl.object_label(glow::RENDERBUFFER, raw.0.get(), Some(label));
            Ok(buffer)
        }
    }

    pub(super) const fn raw(&self) -> glow::Renderbuffer {
        self.raw
    }
}

impl Drop for Renderbuffer {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the renderbuffer.
        unsafe { self.gl.delete_renderbuffer(self.raw) }
    }
}
