//! libGLU's NURBS tessellator (`GLU_NURBS_TESSELLATOR`). It takes patches and returns, through callbacks,
//! triangles within an error on the screen.
#![allow(unsafe_code, reason = "a C library that is loaded while the program runs")]

use std::ffi::{c_float, c_int, c_uint, c_void};
use std::sync::atomic::{AtomicU32, Ordering};

use freeform_surface::inspect::StaticVertex;
use freeform_surface::{Degree, Scene, Surface, ViewProjection};
use libloading::Library;

type Nurbs = *mut c_void;
type Property = unsafe extern "C" fn(Nurbs, c_uint, c_float);
type Callback = unsafe extern "C" fn(Nurbs, c_uint, *const c_void);
type WithData = unsafe extern "C" fn(Nurbs, *mut c_void);
type WithNurbs = unsafe extern "C" fn(Nurbs);
type Matrices = unsafe extern "C" fn(Nurbs, *const c_float, *const c_float, *const c_int);
type Curve = unsafe extern "C" fn(Nurbs, c_int, *mut c_float, c_int, *mut c_float, c_int, c_uint);
type NurbsSurface = unsafe extern "C" fn(
    Nurbs,
    c_int,
    *mut c_float,
    c_int,
    *mut c_float,
    c_int,
    c_int,
    *mut c_float,
    c_int,
    c_int,
    c_uint,
);

// The constants of GL/glu.h and GL/gl.h.
const GLU_NURBS_MODE: c_uint = 100_160;
const GLU_NURBS_TESSELLATOR: c_float = 100_161.0;
const GLU_AUTO_LOAD_MATRIX: c_uint = 100_200;
const GLU_CULLING: c_uint = 100_201;
const GLU_PARAMETRIC_TOLERANCE: c_uint = 100_202;
const GLU_DISPLAY_MODE: c_uint = 100_204;
const GLU_SAMPLING_METHOD: c_uint = 100_205;
const GLU_PARAMETRIC_ERROR: c_float = 100_216.0;
const GLU_FILL: c_float = 100_012.0;
const GLU_ERROR: c_uint = 100_103;
const GLU_NURBS_BEGIN_DATA: c_uint = 100_170;
const GLU_NURBS_VERTEX_DATA: c_uint = 100_171;
const GLU_NURBS_NORMAL_DATA: c_uint = 100_172;
const GLU_NURBS_TEXTURE_COORD_DATA: c_uint = 100_174;
const GLU_NURBS_END_DATA: c_uint = 100_175;
const GLU_MAP1_TRIM_2: c_uint = 100_210;
const GL_MAP2_TEXTURE_COORD_2: c_uint = 0x0DB4;
const GL_MAP2_VERTEX_3: c_uint = 0x0DB7;
const GL_TRIANGLES: c_uint = 4;
const GL_TRIANGLE_FAN: c_uint = 6;

/// The last error that the library reported; 0 if none. It is global because the error callback does not
/// receive the tessellator.
static ERROR: AtomicU32 = AtomicU32::new(0);

/// The functions that make triangles, and the library that they belong to.
struct Functions {
    property: Property,
    callback_data: WithData,
    load_matrices: Matrices,
    begin_surface: WithNurbs,
    surface: NurbsSurface,
    end_surface: WithNurbs,
    begin_trim: WithNurbs,
    curve: Curve,
    end_trim: WithNurbs,
    delete: WithNurbs,
    _library: Library,
}

/// A tessellator with the triangles that it last made.
pub(super) struct Glu {
    nurbs: Nurbs,
    functions: Functions,
    made: Triangles,
}

/// The triangles that the callbacks collect.
#[derive(Debug, Default)]
pub(super) struct Triangles {
    pub(super) vertices: Vec<StaticVertex>,
    pub(super) indices: Vec<u32>,
    /// The mode of the primitive in progress.
    mode: c_uint,
    first: usize,
    normal: [f32; 3],
    uv: [f32; 2],
    patch: u32,
}

/// The patches of a scene in the library's layout.
#[derive(Debug)]
pub(super) struct Patches {
    /// World space, x, y and z; u varies fastest.
    points: Vec<[c_float; 3]>,
    side: usize,
}

impl Patches {
    /// The patches of a scene's surfaces.
    ///
    /// # Errors
    /// Surfaces are rational or of several degrees; the simple calls made here do not support this.
    pub(super) fn of(scene: &Scene) -> Result<Self, String> {
        let degree = scene.surfaces.first().map_or(Degree::CUBIC, Surface::degree);
        if degree.u() != degree.v() {
            return Err("two degrees in one surface".into());
        }
        let mut points = Vec::new();
        for surface in &scene.surfaces {
            if surface.degree() != degree {
                return Err("surfaces of two degrees".into());
            }
            for point in surface.control_points() {
                if point.w != 1.0 {
                    return Err("a rational surface".into());
                }
                let world = surface.transform.transform_point3(point.truncate());
                points.push(world.as_vec3().to_array());
            }
        }
        Ok(Self { points, side: degree.columns() })
    }
}

impl Glu {
    /// Loads the library.
    ///
    /// # Errors
    /// The library is not installed or lacks a function; the text gives the reason.
    pub(super) fn load() -> Result<Self, String> {
        let fail = |error: libloading::Error| error.to_string();
        // SAFETY: the library is a C library whose initialisers have no effect that matters here. Its functions
        // have the types of GL/glu.h and stay valid as long as the library is loaded, which is as long as the
        // tessellator exists.
        unsafe {
            let library = Library::new("libGLU.so.1").map_err(fail)?;
            macro_rules! function {
                ($name:literal: $type:ty) => {
                    *library.get::<$type>($name.as_bytes()).map_err(fail)?
                };
            }
            let new = function!("gluNewNurbsRenderer": unsafe extern "C" fn() -> Nurbs);
            let callback = function!("gluNurbsCallback": Callback);
            let functions = Functions {
                property: function!("gluNurbsProperty": Property),
                callback_data: function!("gluNurbsCallbackData": WithData),
                load_matrices: function!("gluLoadSamplingMatrices": Matrices),
                begin_surface: function!("gluBeginSurface": WithNurbs),
                surface: function!("gluNurbsSurface": NurbsSurface),
                end_surface: function!("gluEndSurface": WithNurbs),
                begin_trim: function!("gluBeginTrim": WithNurbs),
                curve: function!("gluNurbsCurve": Curve),
                end_trim: function!("gluEndTrim": WithNurbs),
                delete: function!("gluDeleteNurbsRenderer": WithNurbs),
                _library: library,
            };
            let nurbs = new();
            if nurbs.is_null() {
                return Err("libGLU has no memory for a tessellator".into());
            }
            for (property, value) in [
                (GLU_NURBS_MODE, GLU_NURBS_TESSELLATOR),
                (GLU_AUTO_LOAD_MATRIX, 0.0),
                (GLU_CULLING, 1.0),
                (GLU_DISPLAY_MODE, GLU_FILL),
                (GLU_SAMPLING_METHOD, GLU_PARAMETRIC_ERROR),
            ] {
                (functions.property)(nurbs, property, value);
            }
            for (which, function) in [
                (GLU_NURBS_BEGIN_DATA, begin as *const c_void),
                (GLU_NURBS_VERTEX_DATA, vertex as *const c_void),
                (GLU_NURBS_NORMAL_DATA, normal as *const c_void),
                (GLU_NURBS_TEXTURE_COORD_DATA, texture_coordinate as *const c_void),
                (GLU_NURBS_END_DATA, end as *const c_void),
                (GLU_ERROR, error as *const c_void),
            ] {
                callback(nurbs, which, function);
            }
            Ok(Self { nurbs, functions, made: Triangles::default() })
        }
    }

    /// The triangles of patches for a camera and a size in pixels, with an error of at most `tolerance` pixels.
    ///
    /// # Errors
    /// The library reports an error; the text contains its number.
    pub(super) fn tessellate(
        &mut self,
        patches: &Patches,
        projection: &ViewProjection,
        (width, height): (u32, u32),
        tolerance: f64,
    ) -> Result<&Triangles, String> {
        let view = projection.view.as_mat4().to_cols_array();
        let to_clip = projection.projection.as_mat4().to_cols_array();
        let viewport = [0, 0, width as c_int, height as c_int];
        self.made.vertices.clear();
        self.made.indices.clear();
        ERROR.store(0, Ordering::Relaxed);
        let (nurbs, call) = (self.nurbs, &self.functions);
        // Until the last call, all access is through this pointer, which the callbacks share.
        let made: *mut Triangles = &raw mut self.made;
        // SAFETY: the matrices and the viewport have the lengths that the library reads. It calls back on this
        // thread, with `made`, only within the calls of `patch`.
        unsafe {
            (call.callback_data)(nurbs, made.cast());
            (call.load_matrices)(nurbs, view.as_ptr(), to_clip.as_ptr(), viewport.as_ptr());
            (call.property)(nurbs, GLU_PARAMETRIC_TOLERANCE, tolerance as c_float);
            let all = patches.points.chunks_exact(patches.side * patches.side);
            for (number, points) in (0..).zip(all) {
                (*made).patch = number;
                call.patch(nurbs, points.as_flattened(), patches.side);
            }
        }
        match ERROR.load(Ordering::Relaxed) {
            0 => Ok(&self.made),
            error => Err(format!("libGLU calls error {error}")),
        }
    }
}

impl Functions {
    /// Makes the triangles of one patch from the x, y and z of its control points.
    ///
    /// # Safety
    /// The tessellator exists, and its callbacks can write to its data.
    unsafe fn patch(&self, nurbs: Nurbs, points: &[c_float], side: usize) {
        let mut points = points.to_vec();
        // The knots of a Bézier patch: all of them are at its two ends.
        let mut knots = [0.0; 10];
        knots[side..].fill(1.0);
        let mut ends = [0.0, 0.0, 1.0, 1.0];
        let mut domain = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        // Counter-clockwise around the domain.
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0_f32]];
        let n = side as c_int;
        // SAFETY: all arrays have the lengths passed beside them and outlive the calls that read them. The last
        // of these calls is `end_surface`.
        unsafe {
            let (knots, ends) = (knots.as_mut_ptr(), ends.as_mut_ptr());
            let (points, domain) = (points.as_mut_ptr(), domain.as_mut_ptr());
            (self.begin_surface)(nurbs);
            let texture = GL_MAP2_TEXTURE_COORD_2;
            (self.surface)(nurbs, 4, ends, 4, ends, 2, 4, domain, 2, 2, texture);
            let vertex = GL_MAP2_VERTEX_3;
            (self.surface)(nurbs, 2 * n, knots, 2 * n, knots, 3, 3 * n, points, n, n, vertex);
            (self.begin_trim)(nurbs);
            // Passed as curves, the sides are sampled as finely as the surface next to them.
            for line in corners.windows(2) {
                let mut line = line.as_flattened().to_vec();
                (self.curve)(nurbs, 4, ends, 2, line.as_mut_ptr(), 2, GLU_MAP1_TRIM_2);
            }
            (self.end_trim)(nurbs);
            (self.end_surface)(nurbs);
        }
    }
}

impl Drop for Glu {
    fn drop(&mut self) {
        // SAFETY: this value owns the tessellator and no longer uses it; the library is still loaded.
        unsafe { (self.functions.delete)(self.nurbs) }
    }
}

impl Triangles {
    /// Adds the triangles of a finished primitive, whose vertices start at `first`.
    fn close(&mut self) {
        let first = self.first as u32;
        let count = (self.vertices.len() - self.first) as u32;
        let last = count.saturating_sub(2);
        match self.mode {
            GL_TRIANGLES => self.indices.extend(first..first + count / 3 * 3),
            GL_TRIANGLE_FAN => {
                self.indices.extend((0..last).flat_map(|i| [first, first + i + 1, first + i + 2]));
            }
            // Triangle strips and quad strips.
            _ => self.indices.extend((0..last).flat_map(|i| {
                let [a, b] = if i % 2 == 0 { [i, i + 1] } else { [i + 1, i] };
                [first + a, first + b, first + i + 2]
            })),
        }
    }
}

// The library calls the following functions only within `tessellate`, with the triangles as its data. Nothing
// else reads or writes them during that time.

unsafe extern "C" fn begin(mode: c_uint, data: *mut Triangles) {
    // SAFETY: as above.
    let made = unsafe { &mut *data };
    (made.mode, made.first) = (mode, made.vertices.len());
}

unsafe extern "C" fn vertex(position: *const [f32; 3], data: *mut Triangles) {
    // SAFETY: as above; a position has three coordinates.
    let (made, position) = unsafe { (&mut *data, *position) };
    let [u, v] = made.uv;
    let (normal, patch) = (made.normal, made.patch);
    made.vertices.push(StaticVertex { position, u, normal, v, patch });
}

unsafe extern "C" fn normal(normal: *const [f32; 3], data: *mut Triangles) {
    // SAFETY: as above; a normal has three coordinates.
    let (made, normal) = unsafe { (&mut *data, *normal) };
    // The library's normal is Su × Sv; ours is Sv × Su.
    made.normal = normal.map(|coordinate| -coordinate);
}

unsafe extern "C" fn texture_coordinate(uv: *const [f32; 2], data: *mut Triangles) {
    // SAFETY: as above; the map has two coordinates.
    let (made, uv) = unsafe { (&mut *data, *uv) };
    made.uv = uv;
}

unsafe extern "C" fn end(data: *mut Triangles) {
    // SAFETY: as above.
    unsafe { &mut *data }.close();
}

unsafe extern "C" fn error(error: c_uint) {
    ERROR.store(error, Ordering::Relaxed);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_become_triangles_that_face_alike() {
        let indices = |mode: c_uint, vertices: usize| {
            let vertex = bytemuck::Zeroable::zeroed();
            let vertices = vec![vertex; 1 + vertices];
            let mut made = Triangles { vertices, mode, first: 1, ..Triangles::default() };
            made.close();
            made.indices
        };
        assert_eq!(indices(GL_TRIANGLES, 6), [1, 2, 3, 4, 5, 6]);
        assert_eq!(indices(GL_TRIANGLE_FAN, 4), [1, 2, 3, 1, 3, 4]);
        assert_eq!(indices(5, 4), [1, 2, 3, 3, 2, 4]);
        assert!(indices(5, 0).is_empty());
    }
}
