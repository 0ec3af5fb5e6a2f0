//! All draw calls: a surface and a frame in, pixels in the bound framebuffer out.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

mod prepared;
pub mod programs;
mod smooth;

use std::collections::HashMap;
use std::sync::Arc;

use glam::DMat4;
use glow::HasContext;

pub use prepared::PreparedScene;
use programs::{Pipeline, ProgramKey, Sources, TrimFeatures, location};
pub use smooth::sample_offsets;

use crate::camera::Projection;
use crate::gpu::{Buffer, Program, VertexArray, check_version, samples_of_target};
use crate::surface::{ExactTrims, ThesisTrims};
use crate::tessellation::{Parts, batches};
use crate::{Degree, FreeFormSurface, Method, RenderSettings, Result, Shading};

/// Side of the square that shows a control point, in pixels.
pub const CONTROL_POINT_PX: f32 = 7.0;

/// Everything that is the same for all surfaces of one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Where the picture is seen from.
    pub projection: Projection,
    /// How it is drawn.
    pub settings: RenderSettings,
}

/// Draws surfaces with the OpenGL context of its caller.
///
/// The context must be current whenever the renderer or something made with it is used or dropped.
///
/// Drawing sets, and leaves set: depth test, function and mask; no blending, culling, stencil test,
/// rasterizer discard or program point size; filled polygons; the patch size; the textures of units
/// 0, 1 and 2 and the sampler of unit 0; the storage buffers 1 and 2; no program, no vertex array and no
/// buffer texture. Uploading a picture sets
/// plain pixel transfers. All other state is the caller's and holds for what is drawn: framebuffer,
/// viewport, scissor, colour mask and logic operation, depth range and clip control, polygon offset,
/// sample masks, sRGB conversion, the width of lines.
pub struct Renderer {
    gl: Arc<glow::Context>,
    sources: Sources,
    programs: HashMap<ProgramKey, Program>,
    vertex_array: VertexArray,
    parts_array: VertexArray,
}

impl std::fmt::Debug for Renderer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Renderer").field("programs", &self.programs).finish_non_exhaustive()
    }
}

impl Renderer {
    /// A renderer for the current context. Programs are compiled when something first needs them.
    ///
    /// # Errors
    /// A context older than OpenGL 4.5.
    pub fn new(gl: &Arc<glow::Context>) -> Result<Self> {
        Self::with_sources(gl, Sources::default())
    }

    /// A renderer with shaders of one's own in the place of some files of `glsl/`.
    ///
    /// # Errors
    /// A context older than OpenGL 4.5.
    pub fn with_sources(gl: &Arc<glow::Context>, sources: Sources) -> Result<Self> {
        check_version(gl)?;
        Ok(Self {
            gl: Arc::clone(gl),
            sources,
            programs: HashMap::new(),
            vertex_array: VertexArray::new(gl)?,
            parts_array: VertexArray::with_instances(gl)?,
        })
    }

    /// The functions of the context.
    #[must_use]
    pub const fn gl(&self) -> &Arc<glow::Context> {
        &self.gl
    }

    /// Fills the bound framebuffer with the background and the farthest depth.
    pub fn clear(&self, background: [f32; 4]) {
        let [red, green, blue, alpha] = background;
        // SAFETY: the context is current (see the type).
        unsafe {
            self.gl.clear_color(red, green, blue, alpha);
            self.gl.clear_depth_f64(1.0);
            self.gl.depth_mask(true);
            self.gl.disable(glow::RASTERIZER_DISCARD);
            self.gl.clear(glow::COLOR_BUFFER_BIT | glow::DEPTH_BUFFER_BIT);
        }
    }

    /// Compiles the program of a key, unless that was done before.
    ///
    /// # Errors
    /// A shader that the driver does not take.
    pub fn program(&mut self, key: ProgramKey) -> Result<&Program> {
        use std::collections::hash_map::Entry;
        Ok(match self.programs.entry(key) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(self.sources.link(&self.gl, key)?),
        })
    }

    /// Draws the patches of a surface into the bound framebuffer.
    ///
    /// # Errors
    /// A shader that the driver does not take, no memory for changed trims, or loops that the frame's
    /// method cannot cut.
    pub fn draw(&mut self, surface: &mut FreeFormSurface, frame: &Frame) -> Result<()> {
        surface.upload_trims(&self.gl, frame.settings.method, frame.settings.level)?;
        let uploaded = surface.uploaded_trims();
        match (frame.settings.method, &uploaded.thesis, &uploaded.exact) {
            (Method::Thesis, Some(trims), _) => self.draw_ported(surface, trims, frame),
            (Method::Exact, _, Some(trims)) => self.draw_exact(surface, trims, frame),
            _ => Ok(()),
        }
    }

    /// Draws a surface as the thesis or the report does.
    fn draw_ported(
        &mut self,
        surface: &FreeFormSurface,
        trims: &ThesisTrims,
        frame: &Frame,
    ) -> Result<()> {
        let key = ProgramKey {
            pipeline: Pipeline::ported(surface),
            shading: surface.shading(),
            trims: trims.features(surface.trims()),
        };
        let settings = &frame.settings;
        self.program(key)?;
        let program = &self.programs[&key];
        program.bind();
        set_matrices(program, surface.model_matrix(), &frame.projection);
        let parts = Parts::of(settings.level);
        program.set_f32(location::TESS_LEVEL, parts.level as f32);
        if key.pipeline == Pipeline::Report {
            program.set_i32(location::WIREFRAME, i32::from(settings.wireframe));
            program.set_i32(location::SHOW_CONTROL_POINTS, 0);
        }
        trims.set(surface.trims(), program, &settings.newton);
        surface.texture().bind(0);
        self.set_state(surface.degree(), settings.wireframe);
        let batch = parts.patches_per_draw(settings.wireframe) * surface.degree().points();
        let points = surface.control_point_count();
        self.vertex_array.bind(&[surface.control_point_buffer()]);
        for domain in parts.domains() {
            program.set_vec3(location::PART, domain);
            for first in (0..points).step_by(batch) {
                let count = batch.min(points - first);
                // SAFETY: the context is current (see the type); the range lies within the buffer,
                // whose points fit an i32 since it was made.
                unsafe { self.gl.draw_arrays(glow::PATCHES, first as i32, count as i32) }
            }
        }
        self.release();
        Ok(())
    }

    /// Draws what the exact trims leave of a surface: parts that are wholly kept without the trims'
    /// code, those that may be cut with it.
    fn draw_exact(
        &mut self,
        surface: &FreeFormSurface,
        trims: &ExactTrims,
        frame: &Frame,
    ) -> Result<()> {
        let parts = trims.parts();
        let Some(boxes) = &parts.boxes else { return Ok(()) };
        let settings = &frame.settings;
        let degree = surface.degree();
        let pipeline = Pipeline::Exact { degree, samples: samples_of_target(&self.gl) };
        let kept = (TrimFeatures::NONE, 0..parts.kept);
        let trimmed = (trims.features(), parts.kept..parts.kept + parts.trimmed);
        let key = |features| ProgramKey { pipeline, shading: surface.shading(), trims: features };
        let passes = [kept, trimmed].into_iter().filter(|(_, instances)| !instances.is_empty());
        // Before anything is bound: a program may be refused.
        for (features, _) in passes.clone() {
            self.program(key(features))?;
        }
        for (features, instances) in passes {
            let program = &self.programs[&key(features)];
            program.bind();
            set_matrices(program, surface.model_matrix(), &frame.projection);
            program.set_f32(location::TESS_LEVEL, parts.level as f32);
            if features.any() {
                trims.bind();
            }
            surface.texture().bind(0);
            self.set_state(degree, settings.wireframe);
            self.parts_array.bind(&[surface.control_point_buffer(), boxes]);
            let patches = surface.control_point_count() / degree.points();
            for batch in batches(parts.level, settings.wireframe, patches, instances) {
                let [first, count] = [batch.patches.start, batch.patches.len()]
                    .map(|patches| (patches * degree.points()) as i32);
                // SAFETY: the context is current (see the type); the ranges lie within the buffers,
                // whose values fit an i32 since they were made.
                unsafe {
                    self.gl.draw_arrays_instanced_base_instance(
                        glow::PATCHES,
                        first,
                        count,
                        batch.instances.len() as i32,
                        batch.instances.start as u32,
                    );
                }
            }
        }
        self.release();
        Ok(())
    }

    /// The state that patches are drawn with.
    fn set_state(&self, degree: Degree, wireframe: bool) {
        let gl = &self.gl;
        // SAFETY: the context is current (see the type).
        unsafe {
            gl.enable(glow::DEPTH_TEST);
            gl.depth_func(glow::LESS);
            gl.depth_mask(true);
            for capability in
                [glow::CULL_FACE, glow::BLEND, glow::STENCIL_TEST, glow::RASTERIZER_DISCARD]
            {
                gl.disable(capability);
            }
            gl.bind_sampler(0, None);
            gl.polygon_mode(glow::FRONT_AND_BACK, if wireframe { glow::LINE } else { glow::FILL });
            gl.patch_parameter_i32(glow::PATCH_VERTICES, degree.points() as i32);
        }
    }

    /// Draws the control points of a surface as blue squares, on top of what is there.
    ///
    /// # Errors
    /// A shader that the driver does not take.
    pub fn draw_control_points(&mut self, surface: &FreeFormSurface, frame: &Frame) -> Result<()> {
        let program = self.program(ProgramKey {
            pipeline: Pipeline::Points,
            shading: Shading::Unlit,
            trims: TrimFeatures::NONE,
        })?;
        program.bind();
        set_matrices(program, surface.model_matrix(), &frame.projection);
        program.set_f32(location::POINT_SIZE, CONTROL_POINT_PX);
        program.set_i32(location::SHOW_CONTROL_POINTS, 1);
        surface.texture().bind(0);
        self.set_state(surface.degree(), false);
        self.draw_points(surface.control_point_buffer(), surface.control_point_count());
        self.release();
        Ok(())
    }

    fn draw_points(&self, points: &Buffer, count: usize) {
        self.vertex_array.bind(&[points]);
        // SAFETY: the context is current (see the type); the buffer holds `count` points.
        unsafe {
            self.gl.disable(glow::DEPTH_TEST);
            self.gl.enable(glow::PROGRAM_POINT_SIZE);
            self.gl.draw_arrays(glow::POINTS, 0, count as i32);
            self.gl.disable(glow::PROGRAM_POINT_SIZE);
        }
    }

    /// Leaves no program and no vertex array bound, and polygons filled.
    fn release(&self) {
        self.vertex_array.unbind();
        self.parts_array.unbind();
        // SAFETY: the context is current (see the type).
        unsafe {
            self.gl.polygon_mode(glow::FRONT_AND_BACK, glow::FILL);
            self.gl.use_program(None);
        }
    }
}

fn set_matrices(program: &Program, model: &DMat4, projection: &Projection) {
    program.set_mat4(location::MODEL, &model.as_mat4());
    program.set_mat4(location::VIEW, &projection.view.as_mat4());
    program.set_mat4(location::PROJECTION, &projection.projection.as_mat4());
}
