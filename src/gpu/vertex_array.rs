//! The layout of vertices that are control points.

use std::sync::Arc;

use glow::HasContext;

use super::{Buffer, create};
use crate::Result;

/// Bytes of the one vertex attribute: four 32-bit floats.
const VEC4_BYTES: i32 = 16;

/// The vertex layout of everything that is drawn from control points: attribute 0 is one `vec4`.
/// The buffer changes from draw to draw.
pub struct VertexArray {
    gl: Arc<glow::Context>,
    raw: glow::VertexArray,
}

impl std::fmt::Debug for VertexArray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VertexArray").field("raw", &self.raw).finish()
    }
}

impl VertexArray {
    /// The layout, with no buffer bound.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn new(gl: &Arc<glow::Context>) -> Result<Self> {
        // SAFETY: the context is current (see the module); the array is new and ours.
        unsafe {
            let raw = create("vertex array", gl.create_named_vertex_array())?;
            gl.enable_vertex_array_attrib(raw, 0);
            gl.vertex_array_attrib_format_f32(raw, 0, 4, glow::FLOAT, false, 0);
            gl.vertex_array_attrib_binding_f32(raw, 0, 0);
            gl.object_label(glow::VERTEX_ARRAY, raw.0.get(), Some("control points"));
            Ok(Self { gl: Arc::clone(gl), raw })
        }
    }

    /// Binds the layout with a buffer of `vec4`.
    pub fn bind(&self, points: &Buffer) {
        // SAFETY: the context is current (see the module); both objects live.
        unsafe {
            self.gl.vertex_array_vertex_buffer(self.raw, 0, Some(points.raw()), 0, VEC4_BYTES);
            self.gl.bind_vertex_array(Some(self.raw));
        }
    }

    /// Binds no vertex array.
    pub fn unbind(&self) {
        // SAFETY: the context is current (see the module). The array must not keep a buffer alive
        // that its owner deletes.
        unsafe {
            self.gl.vertex_array_vertex_buffer(self.raw, 0, None, 0, VEC4_BYTES);
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
