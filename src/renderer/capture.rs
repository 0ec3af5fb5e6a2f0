//! The triangles that a frame draws, as the tessellation stages make them.
#![allow(unsafe_code, reason = "transform feedback is unsafe in glow")]

use bytemuck::{Pod, Zeroable};
use glow::HasContext;

use crate::error::Result;
use crate::gpu::{Buffer, Gl};

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

    pub(super) fn end(self, captured: &mut Vec<DrawnVertex>) {
        // SAFETY: the context is current (see the renderer); feedback was begun.
        unsafe {
            self.gl.end_transform_feedback();
            self.gl.disable(glow::RASTERIZER_DISCARD);
        }
        captured.extend(self.buffer.read::<DrawnVertex>(self.vertices));
    }
}
