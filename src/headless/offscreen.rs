//! Pictures without a display, in one call.

use super::{Backend, Headless};
use crate::error::{Error, Result};
use crate::gpu::Framebuffer;
use crate::prepared::PreparedScene;
use crate::renderer::{Frame, Renderer};
use crate::scene::{Image, Samples, Scene};
use crate::tessellation::FrameStats;

/// A headless context with a renderer and a framebuffer: draws one picture after the other.
///
/// For pictures of scenes [`Offscreen::render`] is enough. The parts are there for everything else.
#[derive(Debug)]
pub struct Offscreen {
    target: Framebuffer,
    /// The number of samples that the target was made for.
    samples: Samples,
    renderer: Renderer,
    context: Headless,
}

impl Offscreen {
    /// Pictures of the given width and height in pixels, by EGL or OSMesa, whichever there is.
    ///
    /// # Errors
    /// As [`Headless::new`] and [`Framebuffer::new`].
    pub fn new(width: u32, height: u32) -> Result<Self> {
        Self::in_context(Headless::new(Backend::Auto)?, width, height)
    }

    /// The same in a context that is there already. It must be current.
    ///
    /// # Errors
    /// As [`Framebuffer::new`].
    pub fn in_context(context: Headless, width: u32, height: u32) -> Result<Self> {
        let renderer = Renderer::new(context.gl())?;
        Self::with_renderer(context, renderer, width, height)
    }

    /// The same with a renderer of that context.
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

    /// The picture of a scene, from its camera and as its settings ask for, and what was drawn.
    ///
    /// # Errors
    /// As [`PreparedScene::new`] and [`Offscreen::picture`].
    pub fn render(&mut self, scene: &Scene) -> Result<(Image, FrameStats)> {
        let mut prepared = PreparedScene::new(&self.renderer, scene)?;
        let frame = Frame::of(scene, self.target.size());
        let image = self.picture(&mut prepared, &frame, |_, _| {})?;
        Ok((image, prepared.stats()))
    }

    /// The picture of a frame of the whole target. Where the frame asks for more samples than the driver has,
    /// `progress` is told how many of how many drawings are done.
    ///
    /// # Errors
    /// As [`PreparedScene::picture`]; what the driver complains of.
    pub fn picture(
        &mut self,
        prepared: &mut PreparedScene,
        frame: &Frame,
        progress: impl FnMut(u32, u32),
    ) -> Result<Image> {
        // Complaints of earlier pictures are not this one's.
        let _ = self.context.debug_log().take_errors();
        self.set_samples(frame.settings.samples)?;
        let image = prepared.picture(&mut self.renderer, &self.target, frame, progress)?;
        self.check_complaints(|| {
            let (width, height) = self.target.size();
            format!("a picture of {width}x{height} pixels")
        })?;
        Ok(image)
    }

    /// Gives the target this number of samples per pixel.
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

    /// Fails if the driver has complained since it was last asked; `what` names what it was doing.
    ///
    /// # Errors
    /// [`Error::Driver`] with all complaints.
    pub fn check_complaints(&self, what: impl FnOnce() -> String) -> Result<()> {
        let complaints = self.context.debug_log().take_errors();
        if complaints.is_empty() {
            return Ok(());
        }
        Err(Error::Driver { what: what(), reason: complaints.join("; ") })
    }

    /// The framebuffer. It has as many samples as the last picture asked for.
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
