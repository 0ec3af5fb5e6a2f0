//! OpenGL objects, each with one owner that frees it and a label that a debugger shows.
//!
//! Every call here needs the context that made the object to be current on the calling thread, as
//! with any OpenGL call; a library cannot check that. This room, the renderer and the headless
//! contexts are the only places with `unsafe`.
#![allow(unsafe_code, reason = "every call of OpenGL is unsafe in glow")]

mod buffer;
mod debug;
mod float_target;
mod framebuffer;
mod program;
mod texel_buffer;
mod texture;
mod timer;
mod vertex_array;

use glam::{IVec2, UVec2, Vec4};
use glow::HasContext;

pub use buffer::Buffer;
pub use debug::DebugLog;
pub use float_target::FloatTarget;
pub use framebuffer::Framebuffer;
pub use program::{Program, ShaderPart, Stage, StageKind};
pub use texel_buffer::TexelBuffer;
pub use texture::Texture;
pub use timer::Timer;
pub use vertex_array::VertexArray;

use crate::tessellation::DrawSize;
use crate::{Error, Result};

/// What the driver is and how much it can do, as far as the program relies on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DriverInfo {
    /// `GL_RENDERER`.
    pub renderer: String,
    /// `GL_VENDOR`.
    pub vendor: String,
    /// `GL_VERSION`.
    pub version: String,
    /// `GL_SHADING_LANGUAGE_VERSION`.
    pub glsl_version: String,
    /// `GL_MAX_PATCH_VERTICES`; a 5×5 patch needs 25.
    pub max_patch_vertices: i32,
    /// `GL_MAX_TESS_GEN_LEVEL`; the program goes to 64.
    pub max_tess_level: i32,
    /// The largest picture, in pixels a side.
    pub max_size: i32,
    /// `GL_MAX_TEXTURE_SIZE` in texels a side.
    pub max_texture_size: i32,
    /// `GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS`; the trims need 2.
    pub max_fragment_storage_blocks: i32,
    /// `GL_MAX_SAMPLES`.
    pub max_samples: i32,
}

impl DriverInfo {
    /// Whether the driver draws with the processor itself, and so shares its cores: one of Mesa's.
    #[must_use]
    pub fn is_software(&self) -> bool {
        ["llvmpipe", "softpipe", "swr"].iter().any(|name| self.renderer.contains(name))
    }

    /// Reads the current context's names and limits.
    #[must_use]
    pub fn of(gl: &glow::Context) -> Self {
        // SAFETY: the context is current (see the module); all parameters exist since OpenGL 4.3.
        unsafe {
            let mut viewport = [0; 2];
            gl.get_parameter_i32_slice(glow::MAX_VIEWPORT_DIMS, &mut viewport);
            let renderbuffer = gl.get_parameter_i32(glow::MAX_RENDERBUFFER_SIZE);
            Self {
                renderer: gl.get_parameter_string(glow::RENDERER),
                vendor: gl.get_parameter_string(glow::VENDOR),
                version: gl.get_parameter_string(glow::VERSION),
                glsl_version: gl.get_parameter_string(glow::SHADING_LANGUAGE_VERSION),
                max_patch_vertices: gl.get_parameter_i32(glow::MAX_PATCH_VERTICES),
                max_tess_level: gl.get_parameter_i32(glow::MAX_TESS_GEN_LEVEL),
                max_size: renderbuffer.min(viewport[0]).min(viewport[1]),
                max_texture_size: gl.get_parameter_i32(glow::MAX_TEXTURE_SIZE),
                max_fragment_storage_blocks: gl
                    .get_parameter_i32(glow::MAX_FRAGMENT_SHADER_STORAGE_BLOCKS),
                max_samples: gl.get_parameter_i32(glow::MAX_SAMPLES),
            }
        }
    }
}

/// Refuses a context older than OpenGL 4.5.
pub(crate) fn check_version(gl: &glow::Context) -> Result<()> {
    let version = gl.version();
    if version.is_embedded || (version.major, version.minor) < (4, 5) {
        return Err(Error::Context(format!(
            "the OpenGL context has version {}.{}{}; expected 4.5 or later, core profile",
            version.major,
            version.minor,
            if version.is_embedded { " ES" } else { "" },
        )));
    }
    Ok(())
}

/// How large draws of parts the driver likes.
pub(crate) fn draw_size(gl: &glow::Context) -> DrawSize {
    // SAFETY: the context is current (see the module).
    let renderer = unsafe { gl.get_parameter_string(glow::RENDERER) };
    if renderer.contains("llvmpipe") { DrawSize::Small } else { DrawSize::Large }
}

/// Has the process keep the memory that a software driver asks for and gives back with every draw, where
/// the system's allocator can be told so: else each frame of Mesa's takes it from the system anew, page by
/// page, for a tenth of the frame's time. GNU's allocator keeps up to twice the largest block that it ever
/// saw go; this one is never touched, and so costs nothing itself.
pub(crate) fn keep_memory(gl: &glow::Context) {
    if let DrawSize::Small = draw_size(gl) {
        drop(std::hint::black_box(Vec::<u8>::with_capacity(16 << 20)));
    }
}

/// What is drawn into.
pub(crate) struct Target {
    /// The viewport's first pixel.
    pub(crate) first: IVec2,
    /// Width and height of the viewport in pixels, at least 1.
    pub(crate) size: UVec2,
    /// Samples a pixel.
    pub(crate) samples: u32,
}

impl Target {
    /// The viewport as `common/aov.frag` has it: its first pixel, half of its width and height.
    pub(crate) fn viewport(&self) -> Vec4 {
        let (first, half) = (self.first.as_vec2(), 0.5 * self.size.as_vec2());
        Vec4::new(first.x, first.y, half.x, half.y)
    }

    /// What is bound now.
    pub(crate) fn bound(gl: &glow::Context) -> Self {
        let mut viewport = [0; 4];
        // SAFETY: the context is current (see the module); a viewport has four numbers.
        let samples = unsafe {
            gl.get_parameter_i32_slice(glow::VIEWPORT, &mut viewport);
            gl.get_parameter_i32(glow::SAMPLES)
        };
        let at_least_1 = |number: i32| u32::try_from(number).unwrap_or(0).max(1);
        Self {
            first: IVec2::new(viewport[0], viewport[1]),
            size: UVec2::new(at_least_1(viewport[2]), at_least_1(viewport[3])),
            samples: at_least_1(samples),
        }
    }
}

/// Waits until the driver has done everything it was told.
pub fn finish(gl: &glow::Context) {
    // SAFETY: the context is current (see the module).
    unsafe { gl.finish() }
}

/// Makes pixels go to and from memory row by row without gaps, whatever the caller of the library
/// had set: other settings would have the driver read and write beyond the pixels.
fn transfer_plainly(gl: &glow::Context) {
    // SAFETY: the context is current (see the module); the parameters exist since OpenGL 4.5.
    unsafe {
        gl.bind_buffer(glow::PIXEL_PACK_BUFFER, None);
        gl.bind_buffer(glow::PIXEL_UNPACK_BUFFER, None);
        for parameter in [
            glow::PACK_ROW_LENGTH,
            glow::PACK_SKIP_PIXELS,
            glow::PACK_SKIP_ROWS,
            glow::PACK_SWAP_BYTES,
            glow::UNPACK_ROW_LENGTH,
            glow::UNPACK_SKIP_PIXELS,
            glow::UNPACK_SKIP_ROWS,
            glow::UNPACK_SWAP_BYTES,
        ] {
            gl.pixel_store_i32(parameter, 0);
        }
        gl.pixel_store_i32(glow::PACK_ALIGNMENT, 4);
        gl.pixel_store_i32(glow::UNPACK_ALIGNMENT, 4);
    }
}

fn create<T>(what: &str, made: std::result::Result<T, String>) -> Result<T> {
    made.map_err(|reason| Error::Driver { what: what.to_owned(), reason })
}

/// The two sides of a picture as the driver counts them.
fn checked_size(name: &str, (width, height): (u32, u32), most: i32) -> Result<[i32; 2]> {
    let side = |size: u32| i32::try_from(size).ok().filter(|size| (1..=most).contains(size));
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok([width, height]),
        _ => Err(Error::invalid(
            name,
            format!("{width}x{height}"),
            format!("1 to {most} pixels a side with this driver"),
        )),
    }
}

/// The driver counts in `i32`.
fn size_i32(what: &str, size: usize) -> Result<i32> {
    i32::try_from(size).map_err(|_| Error::Driver {
        what: what.to_owned(),
        reason: format!("{size} is more than an OpenGL size can hold"),
    })
}
