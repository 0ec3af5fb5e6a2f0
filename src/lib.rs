//! Trimmed Bézier surfaces, drawn from their control points with OpenGL 4.5 tessellation.
//!
//! A [`Scene`] describes the objects to draw; an [`Offscreen`] renders it to an image without a display (feature
//! `headless`):
//!
#![cfg_attr(feature = "headless", doc = "```no_run")]
#![cfg_attr(not(feature = "headless"), doc = "```ignore")]
//! use freeform_surface::{Offscreen, Scene};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let scene = Scene::load("resources/surfaces/teapot.bpt".as_ref())?;
//!     let mut offscreen = Offscreen::new(1000, 600)?;
//!     let (picture, stats) = offscreen.render(&scene)?;
//!     picture.save("teapot.png")?;
//!     println!("{} triangles in {} draws", stats.triangles, stats.draws);
//!     assert_eq!(stats.unmet, None, "how far off it is where the tolerance could not be met");
//!     Ok(())
//! }
//! ```
//!
//! # What to call
//!
//! | to | call |
//! |---|---|
//! | read a scene file | [`Scene::load`] (`.toml`, `.bpt`, `.obj`), [`Scene::from_toml`] |
//! | read, make, check and write a CAD model | [`model::Model`] |
//! | measure how the faces of a CAD model meet | [`model::Model::continuity`] |
//! | make a scene in code | [`Surface::new`] or [`MeshModel::new`], put into a [`Scene`] |
//! | cut holes | [`Surface::trims`]: [`Circle`], [`Rect`], [`Ellipse`], [`TrimLoop`], [`TrimCurve`] (NURBS), [`TrimPath`] (SVG) |
//! | draw in an OpenGL context of your own | [`Gl::new`], [`Renderer::new`], then [`PreparedScene::draw`] with a [`Frame`] |
//! | draw one surface through the thesis' interface | [`FreeFormSurface::render`] |
//! | change the viewpoint | [`Camera::projection`] or [`Camera::framing`], into [`Frame::new`] |
//! | change points and trims between frames | [`PreparedScene::surfaces_mut`], [`PreparedSurface`] |
//! | read positions, normals and depth per pixel | [`PreparedScene::aovs`] |
//! | choose accuracy, normals, samples, background | [`RenderSettings`] |
//!
//! # Two methods
//!
//! [`Method::Exact`], the default, keeps every pixel within a tolerance of the surface. It evaluates trims exactly
//! at every sample and accepts any trims. [`Method::Thesis`] is the port of a thesis' `FreeFormSurface` class
//! (Schank, *Rendering von Freiformflächen*, Koblenz 2018) and of a report's renderer for patches of 5×5 control
//! points, including their limits.
//!
//! # Conventions
//!
//! | subject | convention |
//! |---|---|
//! | space | right-handed; view space looks along −z; clip space is OpenGL's |
//! | matrices | column vectors, glam's layout; `f64` on the CPU, `f32` in shaders |
//! | control points | stored row by row, u along a row, v from row to row; (x, y, z, weight) |
//! | domain | (u, v) in \[0, 1\]² for each Bézier patch, in its own parameters for a NURBS surface; trims use them |
//! | meshes | triangles counter-clockwise from outside; half-edge 3·t + k of triangle t starts at its corner k |
//! | textures | the first row of pixels is at v = 1; 8-bit values are used unchanged, without sRGB conversion |
//! | rendered images | the first row is the top row; alpha is 1 where a surface is visible |
//! | angles | radians, unless the name says degrees |
//! | counts | indices and segment numbers in errors start at 0, line numbers of files at 1 |
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
//! | feature | adds |
//! |---|---|
//! | `cli` (default) | the program `freeform` and the features `headless`, `inspect` and `svg` |
//! | `headless` | contexts without a display: [`Offscreen`], [`Headless`] |
//! | `svg` | SVG documents as trims |
//! | `viewer` | the window of `freeform view` |
//! | `inspect` | the module [`inspect`]: internals for the tests and the report |
//!
//! With `default-features = false` the library depends on neither clap nor glutin nor usvg.

#![cfg_attr(
    not(feature = "inspect"),
    allow(
        dead_code,
        unreachable_pub,
        unused_imports,
        reason = "some code is for the module `inspect` alone"
    )
)]

mod aov;
mod bezier;
mod camera;
mod error;
mod gpu;
#[cfg(feature = "headless")]
mod headless;
#[cfg(feature = "inspect")]
pub mod inspect;
#[cfg(feature = "inspect")]
mod measure;
mod mesh;
pub mod model;
mod parallel;
mod prepared;
mod programs;
#[cfg(feature = "inspect")]
mod reference;
mod renderer;
mod scene;
mod tessellation;
mod thesis;
mod trim;

// Crates whose types appear in this crate's public API, in matching versions.
pub use {glam, glow, image};

// Scenes: the objects to draw, and how to draw them.
pub use bezier::{CurvedPoint, Degree, NurbsSurface, Patch, SurfaceCurvature, SurfacePoint};
pub use camera::{Camera, CameraKey, CameraPath, Lens, Turntable, ViewProjection};
pub use mesh::{Alpha, Corner, CreaseAngle, Mesh, Smoothing, smooth};
pub use scene::{
    Analysis, AnalysisChange, AnalysisKind, CadModel, Cull, CurvatureKind, CurvatureLimit,
    Direction, Draft, DraftLimit, EdgeColor, Edges, FaceOfModel, Image, IsolineCount, Isolines,
    Light, LineWidth, LoadOptions, Material, MeshModel, Method, Normals, Paint, RenderSettings,
    Samples, ScaleColors, Scene, SceneText, Shading, StripeCount, Stripes, Surface, TessLevel,
    Tessellation, Tolerance, UpAxis, Viewpoint, default_control_points, load_texture,
};
pub use thesis::newton::Newton;
pub use trim::{
    Circle, Ellipse, FillRule, Keep, ParameterSizes, Rect, Segment, TrimCurve, TrimLoop, TrimPath,
    Trims,
};

// Drawing, in any OpenGL context.
pub use aov::{AovKind, Aovs};
pub use gpu::{DebugLog, DriverInfo, FloatTarget, Framebuffer, Gl, Texture};
#[cfg(feature = "headless")]
pub use headless::{Backend, Headless, Offscreen};
pub use prepared::PreparedScene;
pub use renderer::{Frame, PreparedSurface, Renderer, Viewport};
pub use tessellation::FrameStats;
pub use thesis::surface::FreeFormSurface;

pub use error::{Cause, Error, Result};
