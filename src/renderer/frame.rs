//! A frame: the camera, the viewport and the settings of one picture.

use glam::{IVec2, UVec2, Vec4};
use glow::HasContext;

use crate::camera::ViewProjection;
use crate::gpu::Gl;
use crate::scene::{RenderSettings, Scene};

/// Everything that is the same for all surfaces of one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The view and projection matrices.
    pub camera: ViewProjection,
    /// The rectangle of the bound framebuffer that is drawn to. Drawing sets it.
    pub viewport: Viewport,
    /// How the picture is drawn.
    pub settings: RenderSettings,
}

impl Frame {
    /// A frame of the given width and height in pixels, or in a [`Viewport`].
    #[must_use]
    pub fn new(
        camera: ViewProjection,
        viewport: impl Into<Viewport>,
        settings: RenderSettings,
    ) -> Self {
        Self { camera, viewport: viewport.into(), settings }
    }

    /// A frame with a scene's settings and its camera; a scene without a camera gets one that sees
    /// all of it.
    #[must_use]
    pub fn of(scene: &Scene, viewport: impl Into<Viewport>) -> Self {
        let viewport = viewport.into();
        let size = viewport.pixels();
        let camera = scene.projection(size.x, size.y);
        Self { camera, viewport, settings: scene.settings }
    }
}

/// A rectangle of pixels of a framebuffer, as `glViewport` takes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Viewport {
    /// Its lower left pixel, counted from the lower left corner of the framebuffer.
    pub origin: IVec2,
    /// Width and height in pixels. 0 counts as 1.
    pub size: UVec2,
}

impl From<(u32, u32)> for Viewport {
    /// From the width and height of a picture at the lower left corner of the framebuffer.
    fn from((width, height): (u32, u32)) -> Self {
        Self::from(UVec2::new(width, height))
    }
}

impl From<UVec2> for Viewport {
    fn from(size: UVec2) -> Self {
        Self { origin: IVec2::ZERO, size }
    }
}

impl Viewport {
    /// Width and height in pixels, clamped to the range from 1 to the largest `i32`.
    pub(crate) fn pixels(&self) -> UVec2 {
        self.size.clamp(UVec2::ONE, UVec2::splat(i32::MAX as u32))
    }

    /// The uniform `viewport` of `common/aov.frag`: the lower left pixel, and half of the width and
    /// height.
    pub(super) fn origin_and_half(&self) -> Vec4 {
        let (first, half) = (self.origin.as_vec2(), 0.5 * self.pixels().as_vec2());
        Vec4::new(first.x, first.y, half.x, half.y)
    }

    /// Sets the context's viewport.
    pub(super) fn set(&self, gl: &Gl) {
        let (first, size) = (self.origin, self.pixels().as_ivec2());
        // SAFETY: the context is current (see the renderer).
        unsafe { gl.viewport(first.x, first.y, size.x, size.y) }
    }
}
