//! A context, a renderer and a target in which scenes are drawn and measured.

use freeform_surface::inspect::DrawnVertex;
use freeform_surface::inspect::measure::{Measurement, measure};
use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::reference::coverage;
use freeform_surface::{
    Aovs, Backend, FloatTarget, Frame, FrameStats, Framebuffer, FreeFormSurface, Headless, Image,
    Offscreen, PreparedScene, Renderer, Scene, ViewProjection,
};
use glam::UVec2;

use super::backends;

/// Draws one scene after the other, and fails if the driver complains of anything.
pub struct Stage {
    /// Created when it is first needed.
    numbers: Option<FloatTarget>,
    offscreen: Offscreen,
    pub size: UVec2,
}

impl Stage {
    /// In a context of the first backend to test.
    pub fn new(size: UVec2) -> Self {
        Self::with_sources(backends()[0], size, Sources::default())
    }

    /// With other shaders.
    pub fn with_sources(backend: Backend, size: UVec2, sources: Sources) -> Self {
        let context = Headless::new(backend).unwrap_or_else(|error| panic!("{error}"));
        let renderer =
            Renderer::with_sources(context.gl(), sources).unwrap_or_else(|error| panic!("{error}"));
        let offscreen = Offscreen::with_renderer(context, renderer, size.x, size.y).unwrap();
        Self { numbers: None, offscreen, size }
    }

    pub fn renderer(&self) -> &Renderer {
        self.offscreen.renderer()
    }

    pub fn renderer_mut(&mut self) -> &mut Renderer {
        self.offscreen.renderer_mut()
    }

    pub fn context(&self) -> &Headless {
        self.offscreen.context()
    }

    pub fn target(&self) -> &Framebuffer {
        self.offscreen.target()
    }

    pub fn prepared(&self, scene: &Scene) -> PreparedScene {
        PreparedScene::new(self.renderer(), scene).unwrap_or_else(|error| panic!("{error}"))
    }

    /// A frame of the scene's own camera, or of the camera that frames the scene.
    pub fn frame(&self, scene: &Scene) -> Frame {
        Frame::of(scene, self.size)
    }

    pub fn projection(&self, scene: &Scene) -> ViewProjection {
        scene.projection(self.size.x, self.size.y)
    }

    pub fn aspect(&self) -> f64 {
        f64::from(self.size.x) / f64::from(self.size.y)
    }

    /// Draws a scene, one sample a pixel.
    pub fn render(&mut self, scene: &Scene) -> Image {
        let mut prepared = self.prepared(scene);
        self.picture(&mut prepared, &self.frame(scene))
    }

    /// The picture of a frame, one sample a pixel.
    pub fn picture(&mut self, prepared: &mut PreparedScene, frame: &Frame) -> Image {
        let _ = self.draw(prepared, frame);
        self.target().read()
    }

    /// Draws a frame, one sample a pixel.
    pub fn draw(&mut self, prepared: &mut PreparedScene, frame: &Frame) -> FrameStats {
        self.target().bind();
        prepared.draw(self.renderer_mut(), frame).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The picture of one surface on a transparent background.
    pub fn picture_of_surface(&mut self, surface: &mut FreeFormSurface, frame: &Frame) -> Image {
        self.target().bind();
        self.renderer().clear([0.0; 4]);
        let _ = surface.render(self.renderer_mut(), frame).unwrap();
        self.target().read()
    }

    pub fn aovs(&mut self, prepared: &mut PreparedScene, frame: &Frame) -> Aovs {
        let renderer = self.offscreen.renderer_mut();
        let numbers = self.numbers.get_or_insert_with(|| {
            FloatTarget::for_aovs(renderer, self.size.into()).expect("a target of AOVs")
        });
        prepared.aovs(renderer, numbers, frame).unwrap()
    }

    pub fn triangles(&mut self, prepared: &mut PreparedScene, frame: &Frame) -> Vec<DrawnVertex> {
        self.target().bind();
        prepared.triangles(self.renderer_mut(), frame).unwrap()
    }

    /// The errors of a frame.
    pub fn measured(
        &mut self,
        scene: &Scene,
        prepared: &mut PreparedScene,
        frame: &Frame,
    ) -> Measurement {
        let aovs = self.aovs(prepared, frame);
        let method = frame.settings.method;
        let reference = coverage(scene, &frame.camera, self.size, method).unwrap();
        measure(scene, &frame.camera, &aovs, &reference)
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        super::check_complaints(self.context());
    }
}
