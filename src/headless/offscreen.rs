//! Pictures without a display, in one call.

use super::{Backend, Headless};
use crate::error::{Error, Result};
use crate::gpu::Framebuffer;
use crate::prepared::PreparedScene;
use crate::renderer::{Frame, Renderer};
use crate::scene::{Image, Samples, Scene};
use crate::tessellation::FrameStats;

/// A headless context with a renderer and a framebuffer, which draws pictures.
///
/// [`Offscreen::render`] draws a scene. Everything else is done with the parts, which the other
/// methods return. The context must be current when this is used; dropping this makes it current.
#[derive(Debug)]
pub struct Offscreen {
    /// Dropped first: it makes itself current, and the others are deleted in it.
    context: Headless,
    target: Framebuffer,
    /// The number of samples that the target was made for.
    samples: Samples,
    renderer: Renderer,
}

impl Offscreen {
    /// For pictures of the given width and height in pixels, in a context from EGL or, if EGL gives
    /// none, from OSMesa.
    ///
    /// # Errors
    /// As [`Headless::new`] and [`Framebuffer::new`].
    pub fn new(width: u32, height: u32) -> Result<Self> {
        Self::in_context(Headless::new(Backend::Auto)?, width, height)
    }

    /// The same in a given context, which must be current.
    ///
    /// # Errors
    /// As [`Framebuffer::new`].
    pub fn in_context(context: Headless, width: u32, height: u32) -> Result<Self> {
        let renderer = Renderer::new(context.gl())?;
        Self::with_renderer(context, renderer, width, height)
    }

    /// The same with a given renderer of that context.
    ///
    /// # Errors
    /// As [`Framebuffer::new`].
    pub fn with_renderer(
        context: Headless,
        renderer: Renderer,
        width: u32,
        height: u32,
    ) -> Result<Self> {
        let target = Framebuffer::new(context.gl(), width, height)?;
        Ok(Self { target, samples: Samples::default(), renderer, context })
    }

    /// The picture of a scene with its own camera and settings, and statistics.
    ///
    /// # Errors
    /// As [`PreparedScene::new`] and [`Offscreen::picture`].
    pub fn render(&mut self, scene: &Scene) -> Result<(Image, FrameStats)> {
        let mut prepared = PreparedScene::new(&self.renderer, scene)?;
        let frame = Frame::of(scene, self.target.size());
        let image = self.picture(&mut prepared, &frame, |_, _| {})?;
        Ok((image, prepared.stats()))
    }

    /// The picture of a frame. It has the size of the target, whatever the frame's viewport is. If
    /// the frame needs more samples per pixel than the driver supports, the scene is drawn once for
    /// each sample. `progress` is called with the number of finished passes and the total.
    ///
    /// # Errors
    /// As [`PreparedScene::picture`], or the driver reports an error.
    pub fn picture(
        &mut self,
        prepared: &mut PreparedScene,
        frame: &Frame,
        progress: impl FnMut(u32, u32),
    ) -> Result<Image> {
        // Errors of earlier pictures must not be attributed to this one.
        let _ = self.context.debug_log().take_errors();
        self.set_samples(frame.settings.samples)?;
        let image = prepared.picture(&mut self.renderer, &self.target, frame, progress)?;
        self.check_complaints(|| {
            let (width, height) = self.target.size();
            format!("a picture of {width}x{height} pixels")
        })?;
        Ok(image)
    }

    /// Replaces the target by one for this number of samples per pixel, unless it is one already.
    ///
    /// # Errors
    /// As [`Framebuffer::for_samples`].
    pub fn set_samples(&mut self, samples: Samples) -> Result<()> {
        if self.samples != samples {
            self.target = Framebuffer::for_samples(self.context.gl(), self.target.size(), samples)?;
            self.samples = samples;
        }
        Ok(())
    }

    /// Fails if the driver has reported errors since they were last taken from the log. `what`
    /// names the operation, for the message.
    ///
    /// # Errors
    /// [`Error::Driver`] with all reported errors.
    pub fn check_complaints(&self, what: impl FnOnce() -> String) -> Result<()> {
        let complaints = self.context.debug_log().take_errors();
        if complaints.is_empty() {
            return Ok(());
        }
        Err(Error::Driver { what: what(), reason: complaints.join("; ") })
    }

    /// The framebuffer. It was made for the number of samples of the last picture, and has one
    /// sample per pixel if the driver does not support that number.
    #[must_use]
    pub const fn target(&self) -> &Framebuffer {
        &self.target
    }

    /// The renderer.
    #[must_use]
    pub const fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The renderer, for drawing.
    pub const fn renderer_mut(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// The context.
    #[must_use]
    pub const fn context(&self) -> &Headless {
        &self.context
    }
}
