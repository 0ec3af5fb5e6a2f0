//! Captures the triangles of a frame as the tessellation stages generate them.
#![allow(unsafe_code, reason = "transform feedback is unsafe in glow")]

use bytemuck::{Pod, Zeroable};
use glow::HasContext;

use crate::error::Result;
use crate::gpu::{Buffer, Gl};

/// A vertex of a triangle that the exact method draws.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct DrawnVertex {
    /// Position in clip space; for rational patches multiplied by the weight.
    pub clip: [f32; 4],
    /// Position in view space; the fourth component is 1.
    pub position: [f32; 4],
    /// Normal in view space, of unit length, in the direction Sv × Su; on meshes it points inwards.
    pub normal: [f32; 3],
    /// Parameters (u, v) in the domain; on a mesh's triangle the barycentric weights of its second and third corner.
    pub uv: [f32; 2],
    /// Index of the patch in the scene.
    pub patch: u32,
}

/// A draw whose triangles are captured by transform feedback instead of being rasterized.
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
        // SAFETY: the context is current (see the renderer); the bound program has outputs to capture, and the buffer
        // has room for them.
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
