//! OpenGL objects, each with one owner that frees it and a label that a debugger shows.
//!
//! Every call here needs the context that made the object to be current on the calling thread. The caller who hands a
//! context to [`Gl::new`] promises that; every object holds the handle, which stays on its thread. This room, the
//! renderer and the headless contexts are the only places with `unsafe`.
#![allow(unsafe_code, reason = "every call of OpenGL is unsafe in glow")]

mod buffer;
mod debug;
mod driver;
mod float_target;
mod framebuffer;
mod handle;
mod program;
mod texel_buffer;
mod texture;
mod timer;
mod vertex_array;

use glow::HasContext;

pub use buffer::Buffer;
pub use debug::DebugLog;
pub(crate) use driver::check_context;
pub use driver::{DriverInfo, Need};
pub use float_target::FloatTarget;
pub use framebuffer::Framebuffer;
pub use handle::Gl;
pub use program::{Program, ShaderPart, Stage, StageKind};
pub use texel_buffer::TexelBuffer;
pub use texture::Texture;
pub use timer::Timer;
pub(crate) use vertex_array::{Attribute, Vertex, VertexArray};

use crate::error::{Error, Result};
use crate::tessellation::DrawSize;

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

/// Samples of each pixel of the bound framebuffer, at least 1.
pub(crate) fn samples_of_target(gl: &glow::Context) -> u32 {
    // SAFETY: the context is current (see the module).
    let samples = unsafe { gl.get_parameter_i32(glow::SAMPLES) };
    u32::try_from(samples).unwrap_or(0).max(1)
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

/// An error if the driver has run out of memory since OpenGL's errors were last asked for: the object that
/// was just given its size has none. Drivers raise it at once or never.
fn check_memory(gl: &glow::Context, what: &str, bytes: u64) -> Result<()> {
    let mut out_of_memory = false;
    // A lost context may say so for ever; there are few kinds of errors.
    for _ in 0..8 {
        // SAFETY: the context is current (see the module).
        match unsafe { gl.get_error() } {
            glow::NO_ERROR => break,
            glow::OUT_OF_MEMORY => out_of_memory = true,
            _ => {}
        }
    }
    if out_of_memory {
        let reason = format!("it has no memory for {bytes} bytes");
        return Err(Error::Driver { what: what.to_owned(), reason });
    }
    Ok(())
}

fn create<T>(what: &str, made: std::result::Result<T, String>) -> Result<T> {
    made.map_err(|reason| Error::Driver { what: what.to_owned(), reason })
}

/// The two sides of a picture as the driver counts them.
fn checked_size(name: &str, (width, height): (u32, u32), max: i32) -> Result<[i32; 2]> {
    let side = |size: u32| i32::try_from(size).ok().filter(|size| (1..=max).contains(size));
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok([width, height]),
        _ => Err(Error::invalid(
            name,
            format!("{width}x{height}"),
            format!("1 to {max} pixels a side with this driver"),
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
