//! The triangles that a frame draws, as the tessellation stages make them.
#![allow(unsafe_code, reason = "transform feedback is unsafe in glow")]

use bytemuck::{Pod, Zeroable};
use glow::HasContext;

use super::programs::Output;
use super::{Frame, PreparedScene, Renderer};
use crate::error::Result;
use crate::gpu::{Buffer, Gl, Target};
use crate::scene::{Method, Normals};

/// A corner of a triangle that the exact method draws.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct DrawnVertex {
    /// Clip space; of rational patches multiplied by the weight.
    pub clip: [f32; 4],
    /// View space, and 1.
    pub position: [f32; 4],
    /// View space, unit length, Sv × Su; of meshes inwards.
    pub normal: [f32; 3],
    /// Place in the domain; of a mesh's triangle the weights of its second and third corner.
    pub uv: [f32; 2],
    /// The patch's number in the scene.
    pub patch: u32,
}

impl PreparedScene {
    /// The corners of all triangles that a frame of the exact method draws, three for each, for a
    /// viewport like the present one. Trims cut none of them; triangles without area are among them.
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
        // Those of pixels are none of the triangles'.
        frame.settings.normals = Normals::Vertex;
        let mut kept = Vec::new();
        let target = Target::bound(renderer.gl());
        let gl = renderer.gl().clone();
        let (surfaces, draw_list) = self.for_draw_list();
        draw_list.update(&gl, surfaces, &frame, target.size, renderer.draw_size())?;
        let output = Output::Triangles;
        renderer.draw_exact(surfaces, draw_list, &frame, &target, output, Some(&mut kept))?;
        let mut patches = draw_list.stats().patches;
        self.update_meshes(renderer, &frame)?;
        for mesh in self.meshes() {
            renderer.draw_mesh(mesh, &frame, output, patches, Some(&mut kept))?;
            patches += mesh.stats().patches;
        }
        Ok(kept)
    }
}

/// One draw whose triangles are kept instead of being filled.
pub(super) struct Feedback {
    gl: Gl,
    buffer: Buffer,
    vertices: usize,
}

impl Feedback {
    pub(super) fn begin(gl: &Gl, triangles: u64) -> Result<Self> {
        let vertices = 3 * triangles as usize;
        let buffer = Buffer::new(gl, "kept triangles", &vec![DrawnVertex::zeroed(); vertices])?;
        buffer.bind_feedback();
        // SAFETY: the context is current (see the renderer); the program that is bound has outputs to
        // keep, the buffer has room for them.
        unsafe {
            gl.enable(glow::RASTERIZER_DISCARD);
            gl.begin_transform_feedback(glow::TRIANGLES);
        }
        Ok(Self { gl: gl.clone(), buffer, vertices })
    }

    pub(super) fn end(self, kept: &mut Vec<DrawnVertex>) {
        // SAFETY: the context is current (see the renderer); feedback was begun.
        unsafe {
            self.gl.end_transform_feedback();
            self.gl.disable(glow::RASTERIZER_DISCARD);
        }
        kept.extend(self.buffer.read::<DrawnVertex>(self.vertices));
    }
}
