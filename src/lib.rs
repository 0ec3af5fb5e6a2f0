//! Trimmed Bézier surfaces, drawn from their control points with OpenGL 4.5 tessellation.
//!
//! The crate is a port of a thesis' `FreeFormSurface` class (Schank, *Rendering von
//! Freiformflächen*, Koblenz 2018): patches of 4×4 control points, cut by circles, intervals,
//! ellipses and Bézier curves in the fragment stage; and of a report's renderer of 5×5 points.
//! Beside that [`Method::Thesis`] stands [`Method::Exact`], the default: any trims at all, decided
//! right at every sample through a [`TrimGrid`]. With them come headless contexts, a scene format, and
//! a renderer on the CPU in `f64` that tells whether the GPU's pictures are right
//! ([`mod@reference`]).
//!
//! With the feature `headless`:
//!
#![cfg_attr(feature = "headless", doc = "```no_run")]
#![cfg_attr(not(feature = "headless"), doc = "```ignore")]
//! use freeform_surface::{Backend, Frame, Headless, PreparedScene, Renderer, Scene};
//! use freeform_surface::gpu::Framebuffer;
//!
//! # fn main() -> freeform_surface::Result<()> {
//! let scene = Scene::load("resources/surfaces/teapot.bpt".as_ref())?;
//! let context = Headless::new(Backend::Auto)?;
//! let target = Framebuffer::new(context.gl(), 1000, 600)?;
//! let mut renderer = Renderer::new(context.gl())?;
//! let frame = Frame {
//!     projection: scene.projection(1000, 600),
//!     settings: scene.settings,
//! };
//! target.bind();
//! let stats = PreparedScene::new(&renderer, &scene)?.draw(&mut renderer, &frame)?;
//! assert_eq!(stats.unmet, None, "how far off it is where the tolerance could not be met");
//! let picture = target.read();
//! # Ok(())
//! # }
//! ```
//!
//! In an OpenGL context of your own, leave `Headless` and `Framebuffer` away: [`gpu::Gl::new`]
//! takes any `glow::Context` of version 4.5, and [`FreeFormSurface::render`] draws into whatever
//! framebuffer is bound.
//!
//! # Conventions
//!
//! | what | how |
//! |---|---|
//! | space | right-handed; view space looks along −z; clip space is OpenGL's |
//! | matrices | column vectors, glam's layout; `f64` on the CPU, `f32` in shaders |
//! | control points | row by row, u along a row, v from row to row; (x, y, z, weight) |
//! | domain | (u, v) in \[0, 1\]² for each patch; trims are given in it |
//! | meshes | triangles counter-clockwise from outside; half-edge 3·t + k of triangle t begins at its corner k |
//! | pictures on surfaces | the first row of pixels is v = 1; 8-bit values are taken as they are, no sRGB |
//! | rendered pictures | the first row is the upper one; alpha is 1 where a surface is |
//! | angles | radians, unless the name says degrees |
//! | counts | indices and segment numbers in errors begin at 0, lines of files at 1 |
//!
//! ```text
//!  v
//!  ^   12 13 14 15      the control points of a bicubic patch
//!  |    8  9 10 11
//!  |    4  5  6  7
//!  |    0  1  2  3
//!  +-------------> u
//! ```
//!
//! # Features
//!
//! `cli` (default) builds the `freeform` program; `viewer` its window; `headless` the contexts without a
//! display; `svg` takes SVG documents as trims. With `default-features = false` the library brings neither clap
//! nor glutin nor usvg.

mod aov;
mod bezier;
mod camera;
mod error;
pub mod gpu;
#[cfg(feature = "headless")]
mod headless;
pub mod measure;
mod mesh;
pub mod reference;
pub mod renderer;
mod scene;
mod surface;
mod tessellation;
mod trim;

// The versions that this crate's own types are made of.
pub use {glam, glow, image};

pub use aov::{AovKind, Aovs};
pub use bezier::{
    DeCasteljau, Degree, Patch, SurfacePoint, bernstein, check_control_point, de_casteljau,
    homogeneous,
};
pub use camera::{Camera, Lens, ViewProjection};
pub use error::{Cause, Error, Result};
#[cfg(feature = "headless")]
pub use headless::{Backend, Headless};
pub use mesh::{
    Alpha, Corner, CreaseAngle, CurvedTriangle, HalfedgeMesh, Mesh, PhongTriangle, PnTriangle,
    SharedBorders, SmoothTriangle, Smoothing, smooth,
};
pub use renderer::{DrawnVertex, Frame, PreparedScene, PreparedSurface, Renderer};
pub use scene::{
    Cull, Image, Light, LoadOptions, Material, MeshModel, Method, Normals, Paint, RenderSettings,
    Samples, Scene, SceneText, Shading, Surface, TessLevel, Tessellation, Tolerance, UpAxis,
    default_control_points, load_texture,
};
pub use surface::FreeFormSurface;
pub use tessellation::FrameStats;
pub use trim::{
    Circle, Ellipse, FillRule, Interval, Keep, Newton, NewtonTrims, Segment, TrimGrid, TrimLoop,
    TrimPath, Trims, inside_loops, ray_crossings, winding_number,
};
