//! Internals for tests, benchmarks and `freeform report`: the reference renderer in `f64`,
//! measurements of pictures, and the components of the renderer.
//!
//! Only with the feature `inspect`. Its content may change with any version.

pub use crate::bezier::{DeCasteljau, bernstein, check_control_point, de_casteljau, homogeneous};
pub use crate::gpu::{Buffer, Need, Program, ShaderPart, Stage, StageKind, TexelBuffer, Timer};
pub use crate::mesh::{
    CurvedTriangle, HalfedgeMesh, PhongTriangle, PnTriangle, SharedBorders, SmoothTriangle,
};
pub use crate::prepared::sample_offsets;
pub use crate::renderer::{DrawnVertex, StaticMesh, StaticStyle, StaticVertex};
pub use crate::thesis::newton::NewtonTrims;
pub use crate::thesis::normal::thesis_normal;
pub use crate::trim::{TrimGrid, inside_loops, ray_crossings, winding_number};

/// Measurements of the distance between pictures and their surfaces.
pub mod measure {
    pub use crate::measure::*;
}

/// The shader programs and their interface.
pub mod programs {
    pub use crate::programs::*;
}

/// The reference renderer in `f64`.
pub mod reference {
    pub use crate::reference::*;
}
