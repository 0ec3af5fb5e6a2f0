//! A whole scene in the driver's memory.

use std::sync::Arc;

use super::{Frame, Renderer};
use crate::gpu::Texture;
use crate::{FreeFormSurface, Paint, Result, Scene};

/// A scene in the driver's memory, ready to be drawn from anywhere.
#[derive(Debug)]
pub struct PreparedScene {
    surfaces: Vec<FreeFormSurface>,
}

impl PreparedScene {
    /// Uploads the surfaces of a scene; a picture or colour that several share goes up once.
    ///
    /// # Errors
    /// Trims out of their range, a texture that the driver cannot hold, no memory.
    pub fn new(renderer: &Renderer, scene: &Scene) -> Result<Self> {
        let mut textures: Vec<(&Paint, Arc<Texture>)> = Vec::new();
        let mut surfaces = Vec::with_capacity(scene.surfaces.len());
        for surface in &scene.surfaces {
            let paint = &surface.paint;
            let known = textures.iter().find(|(other, _)| same(other, paint));
            let texture = match known {
                Some((_, texture)) => Arc::clone(texture),
                None => {
                    let texture = Arc::new(paint.upload(renderer.gl())?);
                    textures.push((paint, Arc::clone(&texture)));
                    texture
                }
            };
            surfaces.push(FreeFormSurface::with_texture(renderer, surface.clone(), texture)?);
        }
        Ok(Self { surfaces })
    }

    /// The surfaces, to be changed between frames.
    pub fn surfaces_mut(&mut self) -> &mut [FreeFormSurface] {
        &mut self.surfaces
    }

    /// Clears the bound framebuffer and draws the scene into it.
    ///
    /// # Errors
    /// A shader that the driver does not take, no memory for changed trims, or loops that the frame's
    /// method cannot cut.
    pub fn draw(&mut self, renderer: &mut Renderer, frame: &Frame) -> Result<()> {
        renderer.clear(frame.settings.background);
        for surface in &mut self.surfaces {
            renderer.draw(surface, frame)?;
        }
        if frame.settings.control_points {
            for surface in &self.surfaces {
                renderer.draw_control_points(surface, frame)?;
            }
        }
        Ok(())
    }
}

/// Whether two paints can share a texture: one colour, or one picture in memory.
fn same(a: &Paint, b: &Paint) -> bool {
    match (a, b) {
        (Paint::Color(a), Paint::Color(b)) => a == b,
        (Paint::Texture(a), Paint::Texture(b)) => Arc::ptr_eq(a, b),
        _ => false,
    }
}
