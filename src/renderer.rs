//! All draw calls: they take a surface and a frame, and write pixels to the bound framebuffer.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

mod aovs;
mod capture;
mod curvature;
mod draw_list;
mod draws;
mod frame;
mod meshes;
mod patches;
mod points;
mod solids;
mod static_mesh;
mod strokes;
mod surface;
mod trims;
mod uniforms;

use std::collections::HashMap;
use std::rc::Rc;

use glam::Vec4;
use glow::HasContext;

pub use capture::DrawnVertex;
pub(crate) use draw_list::DrawList;
pub use frame::{Frame, Viewport};
pub(crate) use meshes::PreparedMesh;
use meshes::{BareCorner, FlatCorner, SmoothCorner};
pub(crate) use points::{ControlPoints, LocalFrame};
pub(crate) use solids::Solids;
pub use static_mesh::{StaticMesh, StaticStyle, StaticVertex};
pub(crate) use strokes::{Strokes, SurfaceJoint};
pub use surface::PreparedSurface;
use surface::to_bytes;
pub(crate) use surface::{PatchShapes, RaisedPatches};
pub(crate) use uniforms::{analysis_of, set_aovs, set_depth, set_lights, set_matrices};

use crate::error::Result;
use crate::gpu::{Gl, Program, Texture, VertexArray, check_context, draw_size, keep_memory};
use crate::programs::{Output, Pipeline, ProgramKey, Sources, TrimFeatures, location};
use crate::scene::{CONTROL_POINT_PX, Paint, RenderSettings, Shading};
use crate::tessellation::DrawSize;

/// Draws surfaces with the OpenGL context of its caller.
///
/// The context must be current whenever the renderer or something made with it is used or dropped.
///
/// If the clip planes of a perspective projection lie far apart, depth is the distance along the view axis divided by
/// the far plane's distance. Otherwise it is OpenGL's depth. Both grow with the distance and are cleared to 1.
///
/// Drawing sets the following state and leaves it set: depth test, depth function and depth mask; blending, culling,
/// stencil test, rasterizer discard and program point size off; filled polygons; the viewport; the patch size; the
/// textures of units 0 to 8 and the sampler of unit 0; the storage buffers 1 and 2; no program, no vertex array and
/// no buffer texture bound. Uploading a texture resets the pixel transfer state to plain transfers. All other state
/// belongs to the caller and affects drawing: framebuffer, scissor, colour mask and logic operation, depth range and
/// clip control, polygon offset, sample masks, sRGB conversion, and line width.
pub struct Renderer {
    gl: Gl,
    sources: Sources,
    programs: HashMap<ProgramKey, Rc<Program>>,
    points_array: VertexArray,
    sub_patches_array: VertexArray,
    corners_array: VertexArray,
    flat_array: VertexArray,
    bare_array: VertexArray,
    /// Textures of one texel for the ported methods, which have no other way to draw a colour.
    colors: HashMap<[u8; 3], Rc<Texture>>,
    draw_size: DrawSize,
}

impl std::fmt::Debug for Renderer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Renderer").field("programs", &self.programs).finish_non_exhaustive()
    }
}

impl Renderer {
    /// Creates a renderer for the current context. Each program is compiled when it is first needed.
    ///
    /// # Errors
    /// A context older than OpenGL 4.5.
    pub fn new(gl: &Gl) -> Result<Self> {
        Self::with_sources(gl, Sources::default())
    }

    /// Creates a renderer whose shaders replace some files of `glsl/`.
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
            sub_patches_array: VertexArray::of::<()>(gl, "sub-patches")?,
            corners_array: VertexArray::of::<SmoothCorner>(gl, "corners of smooth triangles")?,
            flat_array: VertexArray::of::<FlatCorner>(gl, "corners of flat triangles")?,
            bare_array: VertexArray::of::<BareCorner>(gl, "bare corners of flat triangles")?,
            colors: HashMap::new(),
            draw_size: draw_size(gl),
        })
    }

    /// A texture of one colour.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn color_texture(&mut self, rgb: [f32; 3]) -> Result<Rc<Texture>> {
        let bytes = to_bytes(rgb);
        if let Some(texture) = self.colors.get(&bytes) {
            return Ok(Rc::clone(texture));
        }
        let texture = Rc::new(Paint::Color(rgb).upload(&self.gl)?);
        self.colors.insert(bytes, Rc::clone(&texture));
        Ok(texture)
    }

    /// The context's OpenGL functions.
    #[must_use]
    pub const fn gl(&self) -> &Gl {
        &self.gl
    }

    /// The draw size that suits the driver.
    pub(crate) const fn draw_size(&self) -> DrawSize {
        self.draw_size
    }

    /// Clears the bound framebuffer to the background colour and the farthest depth.
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

    /// Returns the program of a key; compiles it on first use.
    ///
    /// # Errors
    /// A shader that the driver rejects.
    pub fn program(&mut self, key: ProgramKey) -> Result<Rc<Program>> {
        if let Some(program) = self.programs.get(&key) {
            return Ok(Rc::clone(program));
        }
        let program = Rc::new(self.sources.link(&self.gl, key)?);
        self.programs.insert(key, Rc::clone(&program));
        Ok(program)
    }

    /// The number of programs that were compiled until now.
    #[must_use]
    pub fn program_count(&self) -> usize {
        self.programs.len()
    }

    /// Sets the OpenGL state for drawing patches.
    pub(crate) fn set_state(&self, frame: &Frame, patch_vertices: usize, wireframe: bool) {
        let gl = &self.gl;
        frame.viewport.set(gl);
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

    /// Draws the control points of a surface as blue squares on top of the framebuffer's contents.
    ///
    /// # Errors
    /// A shader that the driver rejects.
    pub(crate) fn draw_control_points(
        &mut self,
        surface: &mut PreparedSurface,
        frame: &Frame,
    ) -> Result<()> {
        let texture = self.color_texture(RED)?;
        let program = self.program(ProgramKey {
            pipeline: Pipeline::Points,
            shading: Shading::Unlit,
            analysis: None,
            light: frame.settings.light,
            trims: TrimFeatures::NONE,
            output: Output::Picture,
            cut_out: false,
            far_depth: false,
        })?;
        program.bind();
        set_matrices(&program, &surface.points_to_world(), &frame.camera);
        program.set_f32(location::POINT_SIZE, CONTROL_POINT_PX);
        program.set_i32(location::SHOW_CONTROL_POINTS, 1);
        texture.bind(0);
        self.set_state(frame, surface.degree().points(), false);
        let count = surface.surface().control_points().len() as i32;
        let (points, first) = surface.net(&self.gl)?;
        self.points_array.bind(points);
        // SAFETY: the context is current (see the type); the buffer holds the points, whose number was checked to fit
        // an i32 when the buffer was made.
        unsafe {
            self.gl.disable(glow::DEPTH_TEST);
            self.gl.enable(glow::PROGRAM_POINT_SIZE);
            self.gl.draw_arrays(glow::POINTS, first as i32, count);
            self.gl.disable(glow::PROGRAM_POINT_SIZE);
        }
        self.release();
        Ok(())
    }

    /// Binds the control points of a surface as vertex input.
    pub(crate) fn bind_points(&self, surface: &PreparedSurface) {
        self.points_array.bind(surface.uploaded_points().buffer());
    }

    /// Unbinds the program and the vertex array, and resets the polygon mode to filled.
    pub(crate) fn release(&self) {
        self.points_array.unbind();
        self.sub_patches_array.unbind();
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

/// The colour of the report's wireframe lines.
pub(crate) const RED: [f32; 3] = [1.0, 0.0, 0.0];

/// Whether the frame is drawn as a red wireframe.
pub(crate) fn in_lines(settings: &RenderSettings, output: Output) -> bool {
    settings.wireframe && settings.red_lines && output == Output::Picture
}
