//! OpenGL objects, each with one owner that deletes it. Most have a label, which graphics debuggers
//! show.
//!
//! Every call in this module requires the context that created the object to be current on the
//! calling thread. The caller of [`Gl::new`] guarantees this. Every object holds a [`Gl`], which is
//! not `Send`, so no object leaves its thread.
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

/// The draw size that suits the driver.
pub(crate) fn draw_size(gl: &glow::Context) -> DrawSize {
    // SAFETY: the context is current (see the module).
    let renderer = unsafe { gl.get_parameter_string(glow::RENDERER) };
    if renderer.contains("llvmpipe") { DrawSize::Small } else { DrawSize::Large }
}

/// On llvmpipe, makes glibc's allocator keep the memory that the driver allocates and frees with
/// every draw. Otherwise each frame requests this memory from the system again, page by page, which
/// takes a tenth of the frame's time.
///
/// When glibc frees a large block, it raises its trim threshold to twice the size of the block. The
/// block here is never written to, so the system reserves no pages for it. Other allocators may
/// ignore this.
pub(crate) fn keep_memory(gl: &glow::Context) {
    if let DrawSize::Small = draw_size(gl) {
        drop(std::hint::black_box(Vec::<u8>::with_capacity(16 << 20)));
    }
}

/// The number of samples per pixel of the bound framebuffer, at least 1.
pub(crate) fn samples_of_target(gl: &glow::Context) -> u32 {
    // SAFETY: the context is current (see the module).
    let samples = unsafe { gl.get_parameter_i32(glow::SAMPLES) };
    u32::try_from(samples).unwrap_or(0).max(1)
}

/// Resets the pixel transfer state, so that pixels are read and written row by row without gaps.
/// With other values, set by the library's caller, the driver would access memory outside the
/// slice.
fn transfer_plainly(gl: &glow::Context) {
    // SAFETY: the context is current (see the module); OpenGL 4.5 has all parameters.
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

/// Fails if `glGetError` reports that the driver has run out of memory. Called right after the
/// allocation of the object `what`, to which the error is attributed. Clears all pending OpenGL
/// errors.
fn check_memory(gl: &glow::Context, what: &str, bytes: u64) -> Result<()> {
    let mut out_of_memory = false;
    // A lost context may report an error forever. There are fewer than 8 kinds of errors.
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

/// Width and height as the driver takes them. An error if one is 0 or exceeds `max`.
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

/// A size in bytes as the driver takes it: an `i32`.
fn size_i32(what: &str, size: usize) -> Result<i32> {
    i32::try_from(size).map_err(|_| Error::Driver {
        what: what.to_owned(),
        reason: format!("{size} is more than an OpenGL size can hold"),
    })
}
