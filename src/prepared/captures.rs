//! A scene as data instead of colours: AOVs of each pixel, and the triangles that the tessellator generates.

use super::PreparedScene;
use crate::aov::Aovs;
use crate::error::Result;
use crate::gpu::FloatTarget;
use crate::programs::Output;
use crate::renderer::{DrawnVertex, Frame, Renderer};
use crate::scene::{Method, Normals};

impl PreparedScene {
    /// Renders the AOVs of a frame at pixel centres. Wireframe lines and control points are not drawn.
    ///
    /// # Errors
    /// As [`PreparedScene::draw`].
    pub fn aovs(
        &mut self,
        renderer: &mut Renderer,
        target: &FloatTarget,
        frame: &Frame,
    ) -> Result<Aovs> {
        let mut frame = *frame;
        frame.settings.wireframe = false;
        target.bind_cleared();
        self.draw_together(renderer, &frame, Output::Aovs)?;
        Ok(target.aovs())
    }

    /// Captures the vertices of all triangles that a frame of the exact method draws, three for each triangle. The
    /// triangles are not trimmed, and they include degenerate ones (without area). A framebuffer must be bound; its
    /// contents are not changed.
    ///
    /// # Errors
    /// As [`PreparedScene::draw`].
    pub fn triangles(
        &mut self,
        renderer: &mut Renderer,
        frame: &Frame,
    ) -> Result<Vec<DrawnVertex>> {
        let mut frame = *frame;
        frame.settings.method = Method::Exact;
        frame.settings.wireframe = false;
        // Per-pixel normals are not captured.
        frame.settings.normals = Normals::Vertex;
        let mut captured = Vec::new();
        let output = Output::Triangles;
        self.draw_list.update(renderer, &mut self.surfaces, &frame)?;
        renderer.draw_patches(
            &self.surfaces,
            &self.draw_list,
            &frame,
            output,
            Some(&mut captured),
        )?;
        let mut patches = self.draw_list.stats().patches;
        for mesh in &mut self.meshes {
            mesh.update(renderer, &frame)?;
            renderer.draw_mesh(mesh, &frame, output, patches, Some(&mut captured))?;
            patches += mesh.stats().patches;
        }
        Ok(captured)
    }
}
