//! The layout of vertices that are control points.

use std::sync::Arc;

use glow::HasContext;

use super::{Buffer, create};
use crate::Result;

/// Bytes of the one vertex attribute: four 32-bit floats.
const VEC4_BYTES: i32 = 16;

/// The vertex layout of everything that is drawn from control points: attribute 0 is one `vec4` for
/// each vertex, attribute 1 one for each instance, if there is a buffer of them. The buffers change
/// from draw to draw.
pub struct VertexArray {
    gl: Arc<glow::Context>,
    raw: glow::VertexArray,
    buffers: u32,
}

impl std::fmt::Debug for VertexArray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VertexArray").field("raw", &self.raw).finish_non_exhaustive()
    }
}

impl VertexArray {
    /// The layout of control points alone, with no buffer bound.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn new(gl: &Arc<glow::Context>) -> Result<Self> {
        Self::with_buffers(gl, "control points", 1)
    }

    /// The layout of control points and instances, with no buffer bound.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn with_instances(gl: &Arc<glow::Context>) -> Result<Self> {
        Self::with_buffers(gl, "control points and parts", 2)
    }

    fn with_buffers(gl: &Arc<glow::Context>, label: &str, buffers: u32) -> Result<Self> {
        // SAFETY: the context is current (see the module); the array is new and ours.
        unsafe {
            let raw = create("vertex array", gl.create_named_vertex_array())?;
            for buffer in 0..buffers {
                gl.enable_vertex_array_attrib(raw, buffer);
                gl.vertex_array_attrib_format_f32(raw, buffer, 4, glow::FLOAT, false, 0);
                gl.vertex_array_attrib_binding_f32(raw, buffer, buffer);
            }
            if buffers > 1 {
                // glow 0.17 has no call that needs no binding.
                gl.bind_vertex_array(Some(raw));
                gl.vertex_binding_divisor(1, 1);
                gl.bind_vertex_array(None);
            }
            gl.object_label(glow::VERTEX_ARRAY, raw.0.get(), Some(label));
            Ok(Self { gl: Arc::clone(gl), raw, buffers })
        }
    }

    /// Binds the layout with its buffers of `vec4`, as many as it has.
    pub fn bind(&self, buffers: &[&Buffer]) {
        debug_assert_eq!(buffers.len(), self.buffers as usize);
        // SAFETY: the context is current (see the module); all objects live.
        unsafe {
            for (place, buffer) in (0..).zip(buffers) {
                let raw = Some(buffer.raw());
                self.gl.vertex_array_vertex_buffer(self.raw, place, raw, 0, VEC4_BYTES);
            }
            self.gl.bind_vertex_array(Some(self.raw));
        }
    }

    /// Binds no vertex array.
    pub fn unbind(&self) {
        // SAFETY: the context is current (see the module). The array must not keep a buffer alive
        // that its owner deletes.
        unsafe {
            for place in 0..self.buffers {
                self.gl.vertex_array_vertex_buffer(self.raw, place, None, 0, VEC4_BYTES);
            }
            self.gl.bind_vertex_array(None);
        }
    }
}

impl Drop for VertexArray {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the array.
        unsafe { self.gl.delete_vertex_array(self.raw) }
    }
}
