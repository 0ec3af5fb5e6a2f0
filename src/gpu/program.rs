//! Shader programs assembled from GLSL files, with errors that name the stage, the file and the
//! line.

use std::borrow::Cow;
use std::fmt::Write as _;

use glam::{Mat4, Vec2, Vec3, Vec4};
use glow::{HasContext, NativeUniformLocation};

use super::Gl;
use super::create;
use crate::error::{Error, Result};

/// A shader stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageKind {
    /// Vertex.
    Vertex,
    /// Tessellation control.
    TessControl,
    /// Tessellation evaluation.
    TessEvaluation,
    /// Geometry.
    Geometry,
    /// Fragment.
    Fragment,
}

impl StageKind {
    const fn gl(self) -> u32 {
        match self {
            Self::Vertex => glow::VERTEX_SHADER,
            Self::TessControl => glow::TESS_CONTROL_SHADER,
            Self::TessEvaluation => glow::TESS_EVALUATION_SHADER,
            Self::Geometry => glow::GEOMETRY_SHADER,
            Self::Fragment => glow::FRAGMENT_SHADER,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex stage",
            Self::TessControl => "tessellation control stage",
            Self::TessEvaluation => "tessellation evaluation stage",
            Self::Geometry => "geometry stage",
            Self::Fragment => "fragment stage",
        }
    }
}

/// One file of GLSL; it has no `#version` line.
#[derive(Debug, Clone)]
pub struct ShaderPart {
    /// The name of the file, for errors.
    pub file: &'static str,
    /// Its text.
    pub text: Cow<'static, str>,
}

/// A shader stage, concatenated from files.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Which stage.
    pub kind: StageKind,
    /// Its files in order; the last one usually has `main`.
    pub parts: Vec<ShaderPart>,
}

/// A linked program.
pub struct Program {
    gl: Gl,
    raw: glow::Program,
}

impl std::fmt::Debug for Program {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Program").field("raw", &self.raw).finish()
    }
}

/// A compiled stage; needed until the program is linked.
struct Shader<'a> {
    gl: &'a glow::Context,
    raw: glow::Shader,
}

impl Drop for Shader<'_> {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); a linked program no longer needs
        // its shaders.
        unsafe { self.gl.delete_shader(self.raw) }
    }
}

impl Program {
    /// Compiles the stages and links them. `defines` are names and values of `#define` lines at the
    /// beginning of every stage. `kept` are the outputs of the last stage before the fragment stage
    /// that transform feedback captures.
    ///
    /// # Errors
    /// A stage does not compile; the error names its files and has the driver's log. Or the stages
    /// do not link.
    pub fn new(
        gl: &Gl,
        label: &str,
        defines: &[(&str, u32)],
        stages: &[Stage],
        kept: &[&str],
    ) -> Result<Self> {
        let mut shaders = Vec::with_capacity(stages.len());
        for stage in stages {
            shaders.push(compile(gl, defines, stage)?);
        }
        // SAFETY: the context is current (see the module); the program is new and ours, and `drop`
        // deletes it once `Self` holds it.
        unsafe {
            let program = Self { gl: gl.clone(), raw: create(label, gl.create_program())? };
            for shader in &shaders {
                gl.attach_shader(program.raw, shader.raw);
            }
            if !kept.is_empty() {
                gl.transform_feedback_varyings(program.raw, kept, glow::INTERLEAVED_ATTRIBS);
            }
            gl.link_program(program.raw);
            for shader in &shaders {
                gl.detach_shader(program.raw, shader.raw);
            }
            if !gl.get_program_link_status(program.raw) {
                return Err(Error::Shader {
                    what: format!("linking program {label}"),
                    log: gl.get_program_info_log(program.raw).trim().to_owned(),
                });
            }
            gl.object_label(glow::PROGRAM, program.raw.0.get(), Some(label));
            Ok(program)
        }
    }

    /// Uses the program for the next draws.
    pub fn bind(&self) {
        // SAFETY: the context is current (see the module); the program is linked.
        unsafe { self.gl.use_program(Some(self.raw)) }
    }

    /// The location of a uniform by its name in the source, if the linked program uses it.
    #[must_use]
    pub fn uniform_location(&self, name: &str) -> Option<u32> {
        // SAFETY: the context is current (see the module); the program is linked.
        unsafe { self.gl.get_uniform_location(self.raw, name) }.map(|location| location.0)
    }

    /// The value of an integer uniform, such as the texture unit of a sampler. `None` if the linked
    /// program does not use it.
    #[must_use]
    pub fn uniform_i32(&self, name: &str) -> Option<i32> {
        let location = NativeUniformLocation(self.uniform_location(name)?);
        let mut value = [0];
        // SAFETY: the context is current (see the module); the location was just found.
        unsafe { self.gl.get_uniform_i32(self.raw, &location, &mut value) };
        Some(value[0])
    }

    /// The OpenGL name of the program.
    #[must_use]
    pub const fn raw(&self) -> glow::Program {
        self.raw
    }

    /// Sets a `mat4`.
    pub fn set_mat4(&self, location: u32, value: &Mat4) {
        let location = NativeUniformLocation(location);
        // SAFETY: the context is current (see the module); for a location that the program
        // does not have, the driver only reports an error.
        unsafe {
            self.gl.program_uniform_matrix_4_f32_slice(
                self.raw,
                Some(&location),
                false,
                value.as_ref(),
            );
        }
    }

    /// Sets a `vec4`.
    pub fn set_vec4(&self, location: u32, value: Vec4) {
        let location = NativeUniformLocation(location);
        // SAFETY: as in `set_mat4`.
        unsafe {
            self.gl.program_uniform_4_f32(
                self.raw,
                Some(&location),
                value.x,
                value.y,
                value.z,
                value.w,
            );
        }
    }

    /// Sets a `vec2`.
    pub fn set_vec2(&self, location: u32, value: Vec2) {
        let location = NativeUniformLocation(location);
        // SAFETY: as in `set_mat4`.
        unsafe { self.gl.program_uniform_2_f32(self.raw, Some(&location), value.x, value.y) }
    }

    /// Sets a `vec3`.
    pub fn set_vec3(&self, location: u32, value: Vec3) {
        let location = NativeUniformLocation(location);
        // SAFETY: as in `set_mat4`.
        unsafe {
            self.gl.program_uniform_3_f32(self.raw, Some(&location), value.x, value.y, value.z);
        }
    }

    /// Sets a `float`.
    pub fn set_f32(&self, location: u32, value: f32) {
        let location = NativeUniformLocation(location);
        // SAFETY: as in `set_mat4`.
        unsafe { self.gl.program_uniform_1_f32(self.raw, Some(&location), value) }
    }

    /// Sets an `int` or `bool`.
    pub fn set_i32(&self, location: u32, value: i32) {
        let location = NativeUniformLocation(location);
        // SAFETY: as in `set_mat4`.
        unsafe { self.gl.program_uniform_1_i32(self.raw, Some(&location), value) }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the program.
        unsafe { self.gl.delete_program(self.raw) }
    }
}

fn compile<'a>(
    gl: &'a glow::Context,
    defines: &[(&str, u32)],
    stage: &Stage,
) -> Result<Shader<'a>> {
    let source = assemble(defines, &stage.parts);
    let name = stage.kind.name();
    // SAFETY: the context is current (see the module); the shader is new and ours, and
    // `drop` deletes it.
    unsafe {
        let shader = Shader { gl, raw: create(name, gl.create_shader(stage.kind.gl()))? };
        gl.shader_source(shader.raw, &source);
        gl.compile_shader(shader.raw);
        if !gl.get_shader_compile_status(shader.raw) {
            let files: Vec<&str> = stage.parts.iter().map(|part| part.file).collect();
            return Err(Error::Shader {
                what: format!("compiling the {name} of {}", files.join(" + ")),
                log: with_file_names(&gl.get_shader_info_log(shader.raw), &stage.parts),
            });
        }
        Ok(shader)
    }
}

/// The lines of the file with index i are numbered from i times this, plus 1. The file could also
/// be identified by the source string number that `#line` can set, but not all drivers print that
/// in their logs.
const LINES_PER_PART: usize = 10_000;

/// The source of a stage: version, defines, then the files, each after a `#line` that sets its line
/// numbers.
fn assemble(defines: &[(&str, u32)], parts: &[ShaderPart]) -> String {
    let mut source = String::from("#version 450 core\n");
    for (name, value) in defines {
        let _ = writeln!(source, "#define {name} {value}");
    }
    for (place, part) in parts.iter().enumerate() {
        let _ = writeln!(source, "#line {}", place * LINES_PER_PART + 1);
        source += &part.text;
        source.push('\n');
    }
    source
}

/// Replaces source string and line numbers in a driver's log by the name of the file and its own
/// line numbers. Drivers begin the lines of their logs with these numbers, as `0:12(5):` or `0(12)
/// :`.
fn with_file_names(log: &str, parts: &[ShaderPart]) -> String {
    let named = |line: &str| {
        let number = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
        let (source, rest) = line.split_at(number(line));
        let place = rest.strip_prefix([':', '(']).filter(|_| !source.is_empty());
        let in_file = place.and_then(|place| {
            let (digits, message) = place.split_at(number(place));
            let line: usize = digits.parse().ok()?;
            let part = parts.get(line / LINES_PER_PART)?;
            Some(format!("{}{}{}{message}", part.file, &rest[..1], line % LINES_PER_PART))
        });
        in_file.unwrap_or_else(|| line.to_owned())
    };
    log.trim().lines().map(named).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts() -> [ShaderPart; 2] {
        ["a.glsl", "b.frag"].map(|file| ShaderPart { file, text: format!("// {file}").into() })
    }

    #[test]
    fn parts_keep_their_line_numbers() {
        let source = assemble(&[("SIDE", 4)], &parts());
        let lines: Vec<&str> = source.lines().collect();
        assert_eq!(
            lines,
            [
                "#version 450 core",
                "#define SIDE 4",
                "#line 1",
                "// a.glsl",
                "#line 10001",
                "// b.frag"
            ]
        );
    }

    #[test]
    fn logs_of_both_styles_get_file_names() {
        let log = "0:10012(5): error: x\n0(3) : error C0000\nnote 1:2\n0:70001(1): y\n";
        assert_eq!(
            with_file_names(log, &parts()),
            "b.frag:12(5): error: x\na.glsl(3) : error C0000\nnote 1:2\n0:70001(1): y"
        );
    }
}
