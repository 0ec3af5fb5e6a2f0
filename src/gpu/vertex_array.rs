//! Vertex array objects: the layouts of vertices, as declared by the structs that are uploaded.

use bytemuck::Pod;
use glow::HasContext;

use super::{Buffer, Gl, create};
use crate::error::Result;

/// A vertex as it is stored in a buffer.
pub(crate) trait Vertex: Pod {
    /// The attributes that the vertex stage reads.
    const ATTRIBUTES: &'static [Attribute];
}

/// One vertex attribute: components of a vertex that the vertex stage reads at a location.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attribute {
    location: u32,
    kind: u32,
    count: i32,
    /// Offset in the vertex in bytes.
    offset: usize,
}

impl Attribute {
    /// `count` floats.
    pub(crate) const fn floats(location: u32, count: i32, offset: usize) -> Self {
        Self { location, kind: glow::FLOAT, count, offset }
    }

    /// `count` unsigned integers.
    pub(crate) const fn words(location: u32, count: i32, offset: usize) -> Self {
        Self { location, kind: glow::UNSIGNED_INT, count, offset }
    }
}

/// A vertex without attributes: its shader fetches everything by the vertex' number.
impl Vertex for () {
    const ATTRIBUTES: &'static [Attribute] = &[];
}

/// The location of the colours, which are in a separate buffer.
const COLORS: u32 = 4;

/// A vertex array object for one type of vertex. The buffers are set before each draw.
pub(crate) struct VertexArray {
    gl: Gl,
    raw: glow::VertexArray,
    bytes: i32,
}

impl std::fmt::Debug for VertexArray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VertexArray").field("raw", &self.raw).finish_non_exhaustive()
    }
}

impl VertexArray {
    /// Creates the layout of a type of vertex.
    ///
    /// # Errors
    /// The driver cannot create a vertex array.
    pub(crate) fn of<V: Vertex>(gl: &Gl, label: &str) -> Result<Self> {
        // SAFETY: the context is current (see the module); the array is new and ours.
        unsafe {
            let raw = create("vertex array", gl.create_named_vertex_array())?;
            gl.object_label(glow::VERTEX_ARRAY, raw.0.get(), Some(label));
            for &Attribute { location, kind, count, offset } in V::ATTRIBUTES {
                let offset = offset as u32;
                gl.enable_vertex_array_attrib(raw, location);
                if kind == glow::FLOAT {
                    gl.vertex_array_attrib_format_f32(raw, location, count, kind, false, offset);
                } else {
                    gl.vertex_array_attrib_format_i32(raw, location, count, kind, offset);
                }
                gl.vertex_array_attrib_binding_f32(raw, location, 0);
            }
            gl.vertex_array_attrib_format_f32(raw, COLORS, 4, glow::UNSIGNED_BYTE, true, 0);
            gl.vertex_array_attrib_binding_f32(raw, COLORS, 1);
            Ok(Self { gl: gl.clone(), raw, bytes: size_of::<V>() as i32 })
        }
    }

    /// Sets the buffer of the colours, four bytes each, or disables them. The array must be bound.
    pub(crate) fn bind_colors(&self, colors: Option<&Buffer>) {
        let raw = colors.map(Buffer::raw);
        // SAFETY: the context is current (see the module); both objects live.
        unsafe {
            self.gl.vertex_array_vertex_buffer(self.raw, 1, raw, 0, 4);
            if raw.is_some() {
                self.gl.enable_vertex_array_attrib(self.raw, COLORS);
            } else {
                // glow 0.17 lacks `glDisableVertexArrayAttrib`.
                self.gl.disable_vertex_attrib_array(COLORS);
            }
        }
    }

    /// Binds the layout with a buffer of its vertices.
    pub(crate) fn bind(&self, buffer: &Buffer) {
        // SAFETY: the context is current (see the module); both objects live.
        unsafe {
            self.gl.vertex_array_vertex_buffer(self.raw, 0, Some(buffer.raw()), 0, self.bytes);
            self.gl.bind_vertex_array(Some(self.raw));
        }
    }

    /// Binds the layout without a buffer, if it has no attributes.
    pub(crate) fn bind_bare(&self) {
        // SAFETY: the context is current (see the module); the array lives.
        unsafe { self.gl.bind_vertex_array(Some(self.raw)) }
    }

    /// Binds the layout with a buffer of its vertices and a buffer of indices.
    pub(crate) fn bind_indexed(&self, vertices: &Buffer, indices: &Buffer) {
        // SAFETY: the context is current (see the module); both objects live.
        unsafe { self.gl.vertex_array_element_buffer(self.raw, Some(indices.raw())) }
        self.bind(vertices);
    }

    /// Detaches all buffers from this layout, and binds no vertex array.
    pub(crate) fn unbind(&self) {
        // Detached because the array would otherwise keep the memory of deleted buffers alive.
        // SAFETY: the context is current (see the module).
        unsafe {
            self.gl.vertex_array_vertex_buffer(self.raw, 0, None, 0, self.bytes);
            self.gl.vertex_array_vertex_buffer(self.raw, 1, None, 0, 4);
            self.gl.vertex_array_element_buffer(self.raw, None);
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
