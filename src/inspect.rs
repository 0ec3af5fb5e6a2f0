//! The insides that tests, benches and `freeform report` look at: the renderer in `f64` that pictures are judged
//! by, what measures pictures against it, and the parts that drawing is made of.
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

/// How far pictures are from their surfaces.
pub mod measure {
    pub use crate::measure::*;
}

/// Which shaders a surface needs, and their interface.
pub mod programs {
    pub use crate::programs::*;
}

/// The renderer in `f64`.
pub mod reference {
    pub use crate::reference::*;
}
