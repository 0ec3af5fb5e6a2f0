//! Triangles that were made beforehand, through the fragment stages of surfaces: what tessellation is
//! measured against.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use glow::HasContext;

use super::uniforms::{set_aovs, set_depth, set_lights};
use super::{Frame, Renderer};
use crate::aov::Aovs;
use crate::error::{Error, Result};
use crate::gpu::{Attribute, Buffer, FloatTarget, Gl, Texture, Vertex, VertexArray};
use crate::programs::{Output, Pipeline, ProgramKey, TrimFeatures, location};
use crate::scene::{Method, Shading};

/// A corner of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct StaticVertex {
    /// World space.
    pub position: [f32; 3],
    /// First coordinate in the domain.
    pub u: f32,
    /// World space, of any length, Sv × Su as the thesis has it.
    pub normal: [f32; 3],
    /// Second coordinate in the domain.
    pub v: f32,
    /// The patch's number in the scene.
    pub patch: u32,
}

impl Vertex for StaticVertex {
    const ATTRIBUTES: &'static [Attribute] = &[
        Attribute::floats(0, 4, offset_of!(Self, position)),
        Attribute::floats(1, 4, offset_of!(Self, normal)),
        Attribute::words(2, 1, offset_of!(Self, patch)),
    ];
}

/// Triangles in the driver's memory.
#[derive(Debug)]
pub struct StaticMesh {
    gl: Gl,
    vertices: Buffer,
    indices: Buffer,
    count: usize,
    array: VertexArray,
}

impl StaticMesh {
    /// Uploads triangles: three indices of vertices each. Neither may be empty.
    ///
    /// # Errors
    /// An index without its vertex; no memory for them, or 2 GiB and more.
    pub fn new(gl: &Gl, vertices: &[StaticVertex], indices: &[u32]) -> Result<Self> {
        check(vertices, indices)?;
        Ok(Self {
            gl: gl.clone(),
            vertices: Buffer::new(gl, "vertices of triangles", vertices)?,
            indices: Buffer::new(gl, "indices of triangles", indices)?,
            count: indices.len(),
            array: VertexArray::of::<StaticVertex>(gl, "static triangles")?,
        })
    }

    /// Replaces the triangles; buffers that are large enough are used again.
    ///
    /// # Errors
    /// As [`StaticMesh::new`].
    pub fn replace(&mut self, vertices: &[StaticVertex], indices: &[u32]) -> Result<()> {
        check(vertices, indices)?;
        refill(&self.gl, &mut self.vertices, "vertices of triangles", vertices)?;
        refill(&self.gl, &mut self.indices, "indices of triangles", indices)?;
        self.count = indices.len();
        Ok(())
    }

    /// How many triangles there are.
    #[must_use]
    pub const fn triangles(&self) -> usize {
        self.count / 3
    }
}

/// Refuses indices beyond the vertices: the driver would read what is not there.
fn check(vertices: &[StaticVertex], indices: &[u32]) -> Result<()> {
    match indices.iter().max() {
        Some(last) if *last as usize >= vertices.len() => {
            let expected = format!("a number below {}", vertices.len());
            Err(Error::invalid("index of a vertex", last, expected))
        }
        _ => Ok(()),
    }
}

fn refill<T: Pod>(gl: &Gl, buffer: &mut Buffer, label: &str, values: &[T]) -> Result<()> {
    if size_of_val(values) <= buffer.bytes() {
        buffer.write(0, values);
    } else {
        *buffer = Buffer::new(gl, label, values)?;
    }
    Ok(())
}

/// How static triangles are drawn.
#[derive(Debug, Clone, Copy)]
pub struct StaticStyle<'a> {
    /// Whose fragment stage.
    pub method: Method,
    /// Its light.
    pub shading: Shading,
    /// The trims that are compiled in: of the thesis' method alone. Their uniforms are set on
    /// [`Renderer::program`] of [`StaticStyle::key`], where they stay.
    pub trims: TrimFeatures,
    /// The surface's picture.
    pub texture: &'a Texture,
}

impl StaticStyle<'_> {
    /// The program that draws so.
    #[must_use]
    pub const fn key(&self, output: Output, far_depth: bool) -> ProgramKey {
        let pipeline = Pipeline::Static(self.method);
        ProgramKey {
            pipeline,
            shading: self.shading,
            trims: self.trims,
            output,
            far_depth,
            cut_out: false,
        }
    }
}

impl Renderer {
    /// Draws static triangles into the bound framebuffer.
    ///
    /// # Errors
    /// A shader that the driver does not take.
    pub fn draw_static(
        &mut self,
        mesh: &StaticMesh,
        style: &StaticStyle<'_>,
        frame: &Frame,
    ) -> Result<()> {
        self.draw_static_to(mesh, style, frame, Output::Picture)
    }

    /// The AOVs of static triangles, at the centres of pixels.
    ///
    /// # Errors
    /// As [`Renderer::draw_static`].
    pub fn static_aovs(
        &mut self,
        mesh: &StaticMesh,
        style: &StaticStyle<'_>,
        target: &FloatTarget,
        frame: &Frame,
    ) -> Result<Aovs> {
        target.bind_cleared();
        self.draw_static_to(mesh, style, frame, Output::Aovs)?;
        Ok(target.aovs())
    }

    fn draw_static_to(
        &mut self,
        mesh: &StaticMesh,
        style: &StaticStyle<'_>,
        frame: &Frame,
        output: Output,
    ) -> Result<()> {
        let is_far = frame.camera.depth_scale().is_some();
        let program = self.program(style.key(output, is_far))?;
        program.bind();
        set_depth(&program, frame);
        program.set_mat4(location::VIEW, &frame.camera.view.as_mat4());
        if style.shading == Shading::Phong && output == Output::Picture {
            set_lights(&program, frame);
        }
        program.set_mat4(location::PROJECTION, &frame.camera.for_driver().as_mat4());
        if output == Output::Aovs {
            set_aovs(&program, frame);
        }
        style.texture.bind(0);
        self.set_state(frame, 3, frame.settings.wireframe && output == Output::Picture);
        mesh.array.bind_indexed(&mesh.vertices, &mesh.indices);
        // SAFETY: the context is current (see the type); the buffer holds `count` indices, which were
        // checked to be of vertices, and whose bytes fit an i32.
        unsafe {
            let count = mesh.count as i32;
            self.gl.draw_elements(glow::TRIANGLES, count, glow::UNSIGNED_INT, 0);
        }
        mesh.array.unbind();
        self.release();
        Ok(())
    }
}
