//! Trimmed Bézier surfaces on OpenGL 4.5 tessellation.

mod bezier;
mod camera;
mod error;
pub mod gpu;
#[cfg(feature = "headless")]
mod headless;
pub mod reference;
pub mod renderer;
mod scene;
mod surface;
mod tessellation;
mod trim;

pub use bezier::*;
pub use camera::*;
pub use error::*;
#[cfg(feature = "headless")]
pub use headless::{Backend, Headless};
pub use renderer::{Frame, PreparedScene, Renderer};
pub use scene::*;
pub use surface::FreeFormSurface;
pub use trim::*;
