//! The layouts of vertices: control points, parts of patches, corners of smooth and static triangles.

use std::sync::Arc;

use glow::HasContext;

use super::{Buffer, create};
use crate::error::Result;

/// How vertices lie in the buffer that they are drawn from, which changes from draw to draw.
pub struct VertexArray {
    gl: Arc<glow::Context>,
    raw: glow::VertexArray,
    bytes: i32,
}

impl std::fmt::Debug for VertexArray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VertexArray").field("raw", &self.raw).finish_non_exhaustive()
    }
}

impl VertexArray {
    /// Control points: attribute 0 is a `vec4`.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn of_points(gl: &Arc<glow::Context>) -> Result<Self> {
        let array = Self::new(gl, "control points", 16)?;
        array.floats(0, 4, 0);
        Ok(array)
    }

    /// Corners of smooth triangles: attributes 0 and 1 are a `vec4`, 2 and 3 a `vec3`; in a buffer of its own,
    /// attribute 4 is a colour of four bytes.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn of_corners(gl: &Arc<glow::Context>) -> Result<Self> {
        let array = Self::new(gl, "corners of smooth triangles", 56)?;
        for (attribute, components, offset) in [(0, 4, 0), (1, 4, 16), (2, 3, 32), (3, 3, 44)] {
            array.floats(attribute, components, offset);
        }
        array.colors();
        Ok(array)
    }

    /// Corners of flat triangles: the same without attributes 2 and 3.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn of_flat_corners(gl: &Arc<glow::Context>) -> Result<Self> {
        Self::of_corners_without_edges(gl, "corners of flat triangles", 4)
    }

    /// Corners of flat triangles without texture coordinates: attributes 0 and 1 are a `vec3`, whose fourth number
    /// OpenGL makes 1.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn of_bare_corners(gl: &Arc<glow::Context>) -> Result<Self> {
        Self::of_corners_without_edges(gl, "bare corners of flat triangles", 3)
    }

    fn of_corners_without_edges(
        gl: &Arc<glow::Context>,
        label: &str,
        components: i32,
    ) -> Result<Self> {
        let array = Self::new(gl, label, 8 * components)?;
        array.floats(0, components, 0);
        array.floats(1, components, 4 * components as u32);
        array.colors();
        Ok(array)
    }

    /// Attribute 4, which is read where [`VertexArray::bind_colors`] gives it a buffer.
    fn colors(&self) {
        let gl = &self.gl;
        // SAFETY: the context is current (see the module); the array is ours.
        unsafe {
            gl.vertex_array_attrib_format_f32(self.raw, 4, 4, glow::UNSIGNED_BYTE, true, 0);
            gl.vertex_array_attrib_binding_f32(self.raw, 4, 1);
        }
    }

    /// Reads attribute 4 from a buffer of colours, or not at all. The array must be bound.
    pub fn bind_colors(&self, colors: Option<&Buffer>) {
        let raw = colors.map(Buffer::raw);
        // SAFETY: the context is current (see the module); both objects live.
        unsafe {
            self.gl.vertex_array_vertex_buffer(self.raw, 1, raw, 0, 4);
            if raw.is_some() {
                self.gl.enable_vertex_array_attrib(self.raw, 4);
            } else {
                // glow 0.17 has no call that needs no binding.
                self.gl.disable_vertex_attrib_array(4);
            }
        }
    }

    /// Corners of static triangles: attributes 0 and 1 are a `vec4`, 2 a `uint`.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn of_static(gl: &Arc<glow::Context>) -> Result<Self> {
        let array = Self::new(gl, "static triangles", 36)?;
        array.floats(0, 4, 0);
        array.floats(1, 4, 16);
        array.words(2, 1, 32);
        Ok(array)
    }

    /// An attribute of so many floats that begins so many bytes into a vertex.
    fn floats(&self, attribute: u32, components: i32, offset: u32) {
        let gl = &self.gl;
        // SAFETY: the context is current (see the module); the array is ours.
        unsafe {
            gl.enable_vertex_array_attrib(self.raw, attribute);
            gl.vertex_array_attrib_format_f32(
                self.raw,
                attribute,
                components,
                glow::FLOAT,
                false,
                offset,
            );
            gl.vertex_array_attrib_binding_f32(self.raw, attribute, 0);
        }
    }

    /// Parts of patches: attributes 0 and 1 are a `uvec4` each.
    ///
    /// # Errors
    /// The driver has no vertex array.
    pub fn of_parts(gl: &Arc<glow::Context>) -> Result<Self> {
        let array = Self::new(gl, "parts of patches", 32)?;
        array.words(0, 4, 0);
        array.words(1, 4, 16);
        Ok(array)
    }

    /// An attribute of so many whole numbers that begins so many bytes into a vertex.
    fn words(&self, attribute: u32, components: i32, offset: u32) {
        let gl = &self.gl;
        // SAFETY: the context is current (see the module); the array is ours.
        unsafe {
            gl.enable_vertex_array_attrib(self.raw, attribute);
            gl.vertex_array_attrib_format_i32(
                self.raw,
                attribute,
                components,
                glow::UNSIGNED_INT,
                offset,
            );
            gl.vertex_array_attrib_binding_f32(self.raw, attribute, 0);
        }
    }

    fn new(gl: &Arc<glow::Context>, label: &str, bytes: i32) -> Result<Self> {
        // SAFETY: the context is current (see the module); the array is new and ours.
        unsafe {
            let raw = create("vertex array", gl.create_named_vertex_array())?;
            gl.object_label(glow::VERTEX_ARRAY, raw.0.get(), Some(label));
            Ok(Self { gl: Arc::clone(gl), raw, bytes })
        }
    }

    /// Binds the layout with a buffer of such vertices.
    pub fn bind(&self, buffer: &Buffer) {
        // SAFETY: the context is current (see the module); both objects live.
        unsafe {
            self.gl.vertex_array_vertex_buffer(self.raw, 0, Some(buffer.raw()), 0, self.bytes);
            self.gl.bind_vertex_array(Some(self.raw));
        }
    }

    /// Binds the layout with a buffer of such vertices and one of indices.
    pub fn bind_indexed(&self, vertices: &Buffer, indices: &Buffer) {
        // SAFETY: the context is current (see the module); both objects live.
        unsafe { self.gl.vertex_array_element_buffer(self.raw, Some(indices.raw())) }
        self.bind(vertices);
    }

    /// Binds no vertex array.
    pub fn unbind(&self) {
        // SAFETY: the context is current (see the module). The array must not keep a buffer alive
        // that its owner deletes.
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
