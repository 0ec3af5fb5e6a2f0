//! The driver's names and limits, and whether the limits suffice.

use std::fmt;

use glow::HasContext;

use crate::error::{Error, Result};

/// The driver's names and the limits that the library relies on.
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
    /// `GL_MAX_PATCH_VERTICES`: vertices per patch.
    pub max_patch_vertices: i32,
    /// `GL_MAX_TESS_GEN_LEVEL`.
    pub max_tess_level: i32,
    /// `GL_MAX_TESS_PATCH_COMPONENTS`: components of the control stage's per-patch outputs.
    pub max_patch_components: i32,
    /// `GL_MAX_TEXTURE_BUFFER_SIZE`: texels of a buffer texture.
    pub max_texel_buffer: i32,
    /// The maximum width and height of a picture in pixels: the smallest of
    /// `GL_MAX_RENDERBUFFER_SIZE` and both values of `GL_MAX_VIEWPORT_DIMS`.
    pub max_size: i32,
    /// `GL_MAX_TEXTURE_SIZE`: maximum width and height of a texture in texels.
    pub max_texture_size: i32,
    /// `GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS`; the trims of the thesis' method use two.
    pub max_fragment_storage_blocks: i32,
    /// `GL_MAX_SAMPLES`.
    pub max_samples: i32,
}

/// The renderer and the version in one line.
impl fmt::Display for DriverInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, OpenGL {}", self.renderer, self.version)
    }
}

/// A limit of the driver, and the value that the library needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Need {
    /// The name of the limit.
    pub what: &'static str,
    /// The driver's limit.
    pub limit: i32,
    /// The minimum that is needed.
    pub needed: i32,
}

impl DriverInfo {
    /// Whether the driver draws on the CPU, that is, whether it is one of Mesa's software drivers.
    #[must_use]
    pub fn is_software(&self) -> bool {
        ["llvmpipe", "softpipe", "swr"].iter().any(|name| self.renderer.contains(name))
    }

    /// Reads the current context's names and limits.
    #[must_use]
    pub fn of(gl: &glow::Context) -> Self {
        // SAFETY: the context is current (see the module); the parameters exist since OpenGL 4.3.
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
                max_patch_components: gl.get_parameter_i32(glow::MAX_TESS_PATCH_COMPONENTS),
                max_texel_buffer: gl.get_parameter_i32(glow::MAX_TEXTURE_BUFFER_SIZE),
                max_size: renderbuffer.min(viewport[0]).min(viewport[1]),
                max_texture_size: gl.get_parameter_i32(glow::MAX_TEXTURE_SIZE),
                max_fragment_storage_blocks: gl
                    .get_parameter_i32(glow::MAX_FRAGMENT_SHADER_STORAGE_BLOCKS),
                max_samples: gl.get_parameter_i32(glow::MAX_SAMPLES),
            }
        }
    }

    /// The limits that the library relies on, with the minimum that it needs. OpenGL 4.5 guarantees
    /// all of them (tables of implementation-dependent values in the specification), so only a
    /// faulty driver has less.
    #[must_use]
    pub fn needs(&self) -> [Need; 5] {
        let need = |what, limit, needed| Need { what, limit, needed };
        [
            // A 5×5 patch of the thesis' method.
            need("patch vertices", self.max_patch_vertices, 25),
            need("tessellation level", self.max_tess_level, 64),
            // 25 homogeneous control points, two uvec4 that describe the sub-patch, and two
            // lengths.
            need("numbers of a patch", self.max_patch_components, 110),
            need("texels of a buffer", self.max_texel_buffer, 65_536),
            need("storage blocks in the fragment stage", self.max_fragment_storage_blocks, 2),
        ]
    }

    /// Refuses a driver whose limits are too low.
    ///
    /// # Errors
    /// The first limit that is too low, with the minimum that is needed.
    pub fn check(&self) -> Result<()> {
        for Need { what, limit, needed } in self.needs() {
            if limit < needed {
                return Err(Error::Context(format!(
                    "the driver's limit of {what} is {limit}; expected {needed} or more ({})",
                    self.renderer
                )));
            }
        }
        Ok(())
    }
}

/// Refuses OpenGL ES, contexts older than OpenGL 4.5, and drivers whose limits are too low.
pub(crate) fn check_context(gl: &glow::Context) -> Result<()> {
    let version = gl.version();
    if version.is_embedded || (version.major, version.minor) < (4, 5) {
        return Err(Error::Context(format!(
            "the OpenGL context has version {}.{}{}; expected 4.5 or later, core profile",
            version.major,
            version.minor,
            if version.is_embedded { " ES" } else { "" },
        )));
    }
    DriverInfo::of(gl).check()
}
