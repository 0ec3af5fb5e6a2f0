use std::sync::Arc;

use super::{Frame, Renderer};
use crate::gpu::Texture;
use crate::{FreeFormSurface, Image, Paint, Result, Scene};

/// A scene in the driver's memory, ready to be drawn from anywhere.
#[derive(Debug)]
pub struct PreparedScene {
    surfaces: Vec<FreeFormSurface>,
}

impl PreparedScene {
    /// Uploads the surfaces of a scene; a picture that several share goes up once.
    ///
    /// # Errors
    /// Trims that the method cannot cut, a texture that the driver cannot hold, no memory.
    pub fn new(renderer: &Renderer, scene: &Scene) -> Result<Self> {
        let mut textures: Vec<(&Arc<Image>, Arc<Texture>)> = Vec::new();
        let mut surfaces = Vec::with_capacity(scene.surfaces.len());
        for surface in &scene.surfaces {
            let mut uploaded = FreeFormSurface::from_surface(renderer, surface.clone())?;
            if let Paint::Texture(image) = &surface.paint {
                let known = textures.iter().find(|(other, _)| Arc::ptr_eq(other, image));
                let texture = match known {
                    Some((_, texture)) => Arc::clone(texture),
                    None => {
                        let texture =
                            Arc::new(Texture::new(renderer.gl(), "surface picture", image)?);
                        textures.push((image, Arc::clone(&texture)));
                        texture
                    }
                };
                uploaded.set_texture(texture);
            }
            surfaces.push(uploaded);
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
    /// A shader that the driver does not take, or no memory for changed trims.
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
