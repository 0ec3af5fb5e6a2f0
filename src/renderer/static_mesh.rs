//! Triangles tessellated in advance and drawn with the fragment stages of surfaces. They are the baseline against
//! which tessellation is measured.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use glow::HasContext;

use super::uniforms::{analysis_of, set_analysis, set_aovs, set_depth, set_lights};
use super::{Frame, Renderer};
use crate::aov::Aovs;
use crate::error::{Error, Result};
use crate::gpu::{Attribute, Buffer, FloatTarget, Gl, Texture, Vertex, VertexArray};
use crate::programs::{Output, Pipeline, ProgramKey, TrimFeatures, location};
use crate::scene::{Analysis, AnalysisKind, Light, Method, Shading};

/// A vertex of a static triangle.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct StaticVertex {
    /// Position in world space.
    pub position: [f32; 3],
    /// First coordinate in the domain.
    pub u: f32,
    /// Normal in world space, of any length, in the direction Sv × Su as in the thesis.
    pub normal: [f32; 3],
    /// Second coordinate in the domain.
    pub v: f32,
    /// Index of the patch in the scene.
    pub patch: u32,
}

impl Vertex for StaticVertex {
    const ATTRIBUTES: &'static [Attribute] = &[
        Attribute::floats(0, 4, offset_of!(Self, position)),
        Attribute::floats(1, 4, offset_of!(Self, normal)),
        Attribute::words(2, 1, offset_of!(Self, patch)),
    ];
}

/// Static triangles uploaded to the driver.
#[derive(Debug)]
pub struct StaticMesh {
    gl: Gl,
    vertices: Buffer,
    indices: Buffer,
    count: usize,
    array: VertexArray,
}

impl StaticMesh {
    /// Uploads triangles; each has three vertex indices. Neither slice may be empty.
    ///
    /// # Errors
    /// An index beyond the vertices, no memory, or data of 2 GiB or more.
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

    /// Replaces the triangles. Buffers that are large enough are reused.
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

    /// The number of triangles.
    #[must_use]
    pub const fn triangles(&self) -> usize {
        self.count / 3
    }
}

/// Rejects indices beyond the vertices, because the driver would read out of bounds.
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
    /// The method whose fragment stage is used.
    pub method: Method,
    /// The shading model.
    pub shading: Shading,
    /// The trims that are compiled in; only the thesis' method supports them here. Set their uniforms on
    /// [`Renderer::program`] of [`StaticStyle::key`], where they stay.
    pub trims: TrimFeatures,
    /// The surface's texture.
    pub texture: &'a Texture,
}

impl StaticStyle<'_> {
    /// The key of the program that draws in this style.
    #[must_use]
    pub const fn key(
        &self,
        light: Light,
        analysis: Option<AnalysisKind>,
        output: Output,
        far_depth: bool,
    ) -> ProgramKey {
        let pipeline = Pipeline::Static(self.method);
        ProgramKey {
            pipeline,
            shading: self.shading,
            analysis,
            light,
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
    /// A shader that the driver rejects.
    pub fn draw_static(
        &mut self,
        mesh: &StaticMesh,
        style: &StaticStyle<'_>,
        frame: &Frame,
    ) -> Result<()> {
        self.draw_static_to(mesh, style, frame, Output::Picture)
    }

    /// Renders the AOVs of static triangles at pixel centres.
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
        let is_picture = output == Output::Picture;
        let is_shown = |shown: &Analysis| {
            let has_it = style.method == Method::Exact && shown.kind() != AnalysisKind::Curvature;
            has_it || !is_picture
        };
        let analysis = analysis_of(&frame.settings, output).filter(is_shown);
        let kind = analysis.map(|shown| shown.kind());
        let program = self.program(style.key(frame.settings.light, kind, output, is_far))?;
        program.bind();
        set_depth(&program, frame);
        program.set_mat4(location::VIEW, &frame.camera.view.as_mat4());
        if let Some(analysis) = analysis.filter(|_| is_picture) {
            set_analysis(&program, frame, &analysis, 1.0);
        } else if style.shading == Shading::Phong && is_picture {
            set_lights(&program, frame);
        }
        program.set_mat4(location::PROJECTION, &frame.camera.for_driver().as_mat4());
        if output == Output::Aovs {
            set_aovs(&program, frame);
        }
        style.texture.bind(0);
        self.set_state(frame, 3, frame.settings.wireframe && output == Output::Picture);
        mesh.array.bind_indexed(&mesh.vertices, &mesh.indices);
        // SAFETY: the context is current (see the type); the buffer holds `count` indices, which were checked against
        // the number of vertices, and its size in bytes fits an i32.
        unsafe {
            let count = mesh.count as i32;
            self.gl.draw_elements(glow::TRIANGLES, count, glow::UNSIGNED_INT, 0);
        }
        mesh.array.unbind();
        self.release();
        Ok(())
    }
}
