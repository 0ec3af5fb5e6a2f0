//! The port of the thesis, whole: the class [`FreeFormSurface`](surface::FreeFormSurface) under its own calls, its
//! draws (`draw.rs`), its trims for the shaders (`trims.rs`) and in `f64` by Newton's method (`newton.rs`), and its
//! normal (`normal.rs`). The shaders are in `glsl/thesis` and `glsl/report`.

mod draw;
pub(crate) mod newton;
pub(crate) mod normal;
pub(crate) mod surface;
pub(crate) mod trims;
