//! All draw calls: a surface and a frame in, pixels in the bound framebuffer out.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

mod aovs;
mod capture;
mod draw_list;
mod meshes;
mod multisample;
mod points;
mod prepared;
pub mod programs;
mod static_mesh;
mod surface;
mod trims;

use std::collections::HashMap;

use glam::{DMat4, Mat4, Vec4};
use glow::HasContext;

pub use capture::DrawnVertex;
use capture::Feedback;
use draw_list::Batch;
pub(crate) use draw_list::DrawList;
use meshes::{BareCorner, FlatCorner, SmoothCorner};
pub use multisample::sample_offsets;
pub use prepared::PreparedScene;
use programs::{
    CONTROL_POINTS_UNIT, Output, Pipeline, ProgramKey, SURFACES_UNIT, Sources, TrimFeatures,
    location,
};
pub use static_mesh::{StaticLook, StaticMesh, StaticVertex};
pub use surface::PreparedSurface;

use crate::camera::ViewProjection;
use crate::error::Result;
use crate::gpu::{
    Gl, Program, Target, Texture, VertexArray, check_context, draw_size, keep_memory,
};
use crate::scene::{CONTROL_POINT_PX, Method, Paint, RenderSettings, Shading};
use crate::tessellation::{DrawSize, FrameStats, Part, Parts};

/// Everything that is the same for all surfaces of one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Where the picture is seen from.
    pub projection: ViewProjection,
    /// How it is drawn.
    pub settings: RenderSettings,
}

/// Draws surfaces with the OpenGL context of its caller.
///
/// The context must be current whenever the renderer or something made with it is used or dropped.
///
/// Where the clip planes of a perspective lie far apart, depth is the distance along the view axis over that of
/// the farther plane; else it is OpenGL's. Either grows with the distance, and is cleared to 1.
///
/// Drawing sets, and leaves set: depth test, function and mask; no blending, culling, stencil test,
/// rasterizer discard or program point size; filled polygons; the patch size; the textures of units
/// 0 to 6 and the sampler of unit 0; the storage buffers 1 and 2; no program, no vertex array and no
/// buffer texture. Uploading a picture sets
/// plain pixel transfers. All other state is the caller's and holds for what is drawn: framebuffer,
/// viewport, scissor, colour mask and logic operation, depth range and clip control, polygon offset,
/// sample masks, sRGB conversion, the width of lines.
pub struct Renderer {
    gl: Gl,
    sources: Sources,
    programs: HashMap<ProgramKey, Program>,
    points_array: VertexArray,
    parts_array: VertexArray,
    corners_array: VertexArray,
    flat_array: VertexArray,
    bare_array: VertexArray,
    /// What lines are painted with.
    line_paint: Texture,
    draw_size: DrawSize,
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
    pub fn new(gl: &Gl) -> Result<Self> {
        Self::with_sources(gl, Sources::default())
    }

    /// A renderer with shaders of one's own in the place of some files of `glsl/`.
    ///
    /// # Errors
    /// A context older than OpenGL 4.5.
    pub fn with_sources(gl: &Gl, sources: Sources) -> Result<Self> {
        check_context(gl)?;
        keep_memory(gl);
        Ok(Self {
            gl: gl.clone(),
            sources,
            programs: HashMap::new(),
            points_array: VertexArray::of::<Vec4>(gl, "control points")?,
            parts_array: VertexArray::of::<Part>(gl, "parts of patches")?,
            corners_array: VertexArray::of::<SmoothCorner>(gl, "corners of smooth triangles")?,
            flat_array: VertexArray::of::<FlatCorner>(gl, "corners of flat triangles")?,
            bare_array: VertexArray::of::<BareCorner>(gl, "bare corners of flat triangles")?,
            line_paint: Paint::Color([1.0, 0.0, 0.0]).upload(gl)?,
            draw_size: draw_size(gl),
        })
    }

    /// The light and the picture that a surface is drawn with: its own, or as lines the report's red.
    fn look<'a>(
        &'a self,
        shading: Shading,
        texture: &'a Texture,
        settings: &RenderSettings,
        output: Output,
    ) -> (Shading, &'a Texture) {
        if in_lines(settings, output) {
            (Shading::Unlit, &self.line_paint)
        } else {
            (shading, texture)
        }
    }

    /// The functions of the context.
    #[must_use]
    pub const fn gl(&self) -> &Gl {
        &self.gl
    }

    /// How large draws of parts the driver likes.
    pub(crate) const fn draw_size(&self) -> DrawSize {
        self.draw_size
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

    /// Draws surfaces that are neighbours or at least in one picture.
    pub(crate) fn draw_surfaces(
        &mut self,
        surfaces: &mut [PreparedSurface],
        draw_list: &mut DrawList,
        frame: &Frame,
        output: Output,
    ) -> Result<FrameStats> {
        match frame.settings.method {
            Method::Thesis => self.draw_ported(surfaces, frame, output),
            Method::Exact => {
                let target = Target::bound(&self.gl);
                draw_list.update(&self.gl, surfaces, frame, target.size, self.draw_size)?;
                self.draw_exact(surfaces, draw_list, frame, &target, output, None)?;
                Ok(draw_list.stats())
            }
        }
    }

    /// Draws surfaces as the thesis or the report does.
    fn draw_ported(
        &mut self,
        surfaces: &mut [PreparedSurface],
        frame: &Frame,
        output: Output,
    ) -> Result<FrameStats> {
        let mut figures = FrameStats::default();
        for surface in surfaces {
            surface.upload_trims(&self.gl, &frame.settings)?;
            self.draw_ported_surface(surface, frame, output, &mut figures)?;
        }
        self.release();
        Ok(figures)
    }

    fn draw_ported_surface(
        &mut self,
        surface: &PreparedSurface,
        frame: &Frame,
        output: Output,
        figures: &mut FrameStats,
    ) -> Result<()> {
        let Some(trims) = &surface.uploaded_trims().thesis else { return Ok(()) };
        let aov = output == Output::Aovs;
        let pipeline = Pipeline::ported(surface.degree(), surface.shading());
        let settings = &frame.settings;
        let (shading, _) = self.look(surface.shading(), surface.texture(), settings, output);
        let key = ProgramKey {
            // The report's shaders hand on no position.
            pipeline: if aov { Pipeline::Thesis(surface.degree()) } else { pipeline },
            shading,
            trims: trims.features(&surface.surface().trims),
            output,
            cut_out: output == Output::Picture
                && !in_lines(settings, output)
                && surface.texture().has_holes(),
            far_depth: frame.projection.depth_scale().is_some(),
        };
        self.program(key)?;
        let program = &self.programs[&key];
        program.bind();
        set_depth(program, frame.projection.depth_scale());
        set_matrices(program, &surface.points_to_world(), &frame.projection);
        let parts = Parts::of(settings.tessellation.level());
        program.set_f32(location::TESS_LEVEL, parts.level as f32);
        if key.pipeline == Pipeline::Report {
            program.set_i32(location::WIREFRAME, i32::from(settings.wireframe));
            program.set_i32(location::SHOW_CONTROL_POINTS, 0);
        }
        if aov {
            set_for_aovs(program, frame, &Target::bound(&self.gl));
        }
        if shading == Shading::Phong && !aov {
            set_lights(program, frame);
        }
        trims.set(&surface.surface().trims, program, &settings.newton);
        self.look(shading, surface.texture(), settings, output).1.bind(0);
        let side = surface.degree().points();
        self.set_state(side, settings.wireframe);
        let at_once = parts.patches_per_draw(settings.wireframe);
        let patches = surface.cones().len();
        self.points_array.bind(surface.uploaded_points().buffer());
        for domain in parts.domains() {
            program.set_vec3(location::PART, domain);
            for first in (0..patches).step_by(at_once) {
                let count = at_once.min(patches - first);
                let first_patch = figures.patches + first;
                let first = surface.uploaded_points().first() + first * side;
                if aov {
                    program.set_i32(location::FIRST_PATCH, first_patch as i32);
                    program.set_i32(location::FIRST_POINT, first as i32);
                }
                // SAFETY: the context is current (see the type); the range lies within the buffer,
                // whose points fit an i32 since it was made.
                unsafe { self.gl.draw_arrays(glow::PATCHES, first as i32, (count * side) as i32) }
                figures.draws += 1;
            }
        }
        let level = u64::from(settings.tessellation.level().get());
        figures.patches += patches;
        figures.triangles += 2 * level * level * patches as u64;
        Ok(())
    }

    /// Draws what the plan of a frame holds: parts that are wholly kept without the trims' code, those
    /// that may be cut with it.
    fn draw_exact(
        &mut self,
        surfaces: &[PreparedSurface],
        draw_list: &DrawList,
        frame: &Frame,
        target: &Target,
        output: Output,
        mut kept: Option<&mut Vec<DrawnVertex>>,
    ) -> Result<()> {
        let Some(parts) = draw_list.parts() else { return Ok(()) };
        let settings = &frame.settings;
        let depth_scale = frame.projection.depth_scale();
        let aov = output == Output::Aovs;
        let key = |batch: &Batch| ProgramKey {
            pipeline: Pipeline::Exact {
                degree: batch.degree,
                samples: target.samples,
                patches: batch.patches,
                shared: batch.shared,
                normals: settings.normals,
            },
            shading: if in_lines(settings, output) { Shading::Unlit } else { batch.shading },
            trims: batch.trims,
            output,
            cut_out: output == Output::Picture
                && !in_lines(settings, output)
                && surfaces[batch.surface].texture().has_holes(),
            far_depth: depth_scale.is_some(),
        };
        // Before anything is bound: a program may be refused.
        let mut last = None;
        for draw in draw_list.draws() {
            if last != Some(draw.batch) {
                self.program(key(&draw_list.batches()[draw.batch]))?;
            }
            last = Some(draw.batch);
        }
        let mut last = None;
        for draw in draw_list.draws() {
            if last != Some(draw.batch) {
                let batch = &draw_list.batches()[draw.batch];
                let surface = &surfaces[batch.surface];
                let program = &self.programs[&key(batch)];
                program.bind();
                set_depth(program, depth_scale);
                let (shading, texture) =
                    self.look(batch.shading, surface.texture(), settings, output);
                if shading == Shading::Phong && !aov {
                    set_lights(program, frame);
                }
                if aov {
                    set_for_aovs(program, frame, target);
                }
                if batch.trims.any()
                    && let Some(trims) = &surface.uploaded_trims().exact
                {
                    trims.bind();
                }
                texture.bind(0);
                surface.uploaded_points().texels().bind(CONTROL_POINTS_UNIT);
                match draw_list.matrices().filter(|_| batch.shared) {
                    Some(matrices) => matrices.bind(SURFACES_UNIT),
                    None => set_columns(program, draw_list.columns(batch.surface), 1.0),
                }
                self.set_state(1, settings.wireframe);
                self.parts_array.bind(parts);
            }
            last = Some(draw.batch);
            let feedback = match kept {
                Some(_) => Some(
                    Feedback::begin(&self.gl, draw.triangles).inspect_err(|_| self.release())?,
                ),
                None => None,
            };
            // SAFETY: the context is current (see the type); the range lies within the buffer, whose
            // bytes fit an i32 since it was made.
            unsafe { self.gl.draw_arrays(glow::PATCHES, draw.first, draw.count) }
            if let (Some(feedback), Some(kept)) = (feedback, kept.as_deref_mut()) {
                feedback.end(kept);
            }
        }
        self.release();
        Ok(())
    }

    /// The state that patches are drawn with.
    fn set_state(&self, patch_vertices: usize, wireframe: bool) {
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
            gl.patch_parameter_i32(glow::PATCH_VERTICES, patch_vertices as i32);
        }
    }

    /// Draws the control points of a surface as blue squares, on top of what is there.
    ///
    /// # Errors
    /// A shader that the driver does not take.
    pub(crate) fn draw_control_points(
        &mut self,
        surface: &PreparedSurface,
        frame: &Frame,
    ) -> Result<()> {
        let program = self.program(ProgramKey {
            pipeline: Pipeline::Points,
            shading: Shading::Unlit,
            trims: TrimFeatures::NONE,
            output: Output::Picture,
            cut_out: false,
            far_depth: false,
        })?;
        program.bind();
        set_matrices(program, &surface.points_to_world(), &frame.projection);
        program.set_f32(location::POINT_SIZE, CONTROL_POINT_PX);
        program.set_i32(location::SHOW_CONTROL_POINTS, 1);
        surface.texture().bind(0);
        self.set_state(surface.degree().points(), false);
        let points = surface.uploaded_points();
        self.points_array.bind(points.buffer());
        // SAFETY: the context is current (see the type); the buffer holds the points, whose number
        // fits an i32 since it was made.
        unsafe {
            self.gl.disable(glow::DEPTH_TEST);
            self.gl.enable(glow::PROGRAM_POINT_SIZE);
            let count = surface.surface().control_points().len() as i32;
            self.gl.draw_arrays(glow::POINTS, points.first() as i32, count);
            self.gl.disable(glow::PROGRAM_POINT_SIZE);
        }
        self.release();
        Ok(())
    }

    /// Leaves no program and no vertex array bound, and polygons filled.
    fn release(&self) {
        self.points_array.unbind();
        self.parts_array.unbind();
        self.corners_array.unbind();
        self.flat_array.unbind();
        self.bare_array.unbind();
        // SAFETY: the context is current (see the type).
        unsafe {
            self.gl.polygon_mode(glow::FRONT_AND_BACK, glow::FILL);
            self.gl.use_program(None);
        }
    }
}

/// Whether what is drawn is red lines.
fn in_lines(settings: &RenderSettings, output: Output) -> bool {
    settings.wireframe && settings.red_lines && output == Output::Picture
}

/// Sets where the lights stand, in view space.
fn set_lights(program: &Program, frame: &Frame) {
    let [first, second] = frame.settings.light.positions(&frame.projection);
    program.set_vec3(location::LIGHT_POSITION, first.as_vec3());
    program.set_vec3(location::LIGHT_POSITION_2, second.as_vec3());
}

/// Sets what the distance becomes a depth by, if depth is written so.
fn set_depth(program: &Program, depth_scale: Option<f64>) {
    if let Some(scale) = depth_scale {
        program.set_f32(location::DEPTH_SCALE, scale as f32);
    }
}

fn set_for_aovs(program: &Program, frame: &Frame, target: &Target) {
    let to_world = frame.projection.view.inverse().as_mat4();
    program.set_mat4(location::VIEW_TO_WORLD, &to_world);
    program.set_vec4(location::VIEWPORT, target.viewport());
}

/// Sets the matrices of one surface or mesh by their columns ([`draw_list::matrices`]). Its normals are turned
/// round where `sign` is −1.
fn set_columns(program: &Program, columns: &[Vec4], sign: f32) {
    let matrix = |first: usize| {
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| columns[first + i]);
        Mat4::from_cols(x, y, z, w)
    };
    program.set_mat4(location::TO_CLIP, &matrix(0));
    program.set_mat4(location::TO_VIEW, &matrix(4));
    program.set_mat4(location::NORMAL_TO_VIEW, &(matrix(8) * sign));
}

/// Sets the listings' matrices. Their world begins at the eye: what is far from the origin would lose its digits
/// in `f32` else.
fn set_matrices(program: &Program, model: &DMat4, projection: &ViewProjection) {
    let eye = projection.view.inverse().w_axis.truncate();
    let to_eye = DMat4::from_translation(-eye);
    program.set_mat4(location::MODEL, &(to_eye * *model).as_mat4());
    program.set_mat4(location::VIEW, &(projection.view * DMat4::from_translation(eye)).as_mat4());
    program.set_mat4(location::PROJECTION, &projection.for_driver().as_mat4());
}
