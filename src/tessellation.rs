//! Tessellation: how patches are divided into triangles.
//!
//! `bound.rs` computes how many triangles keep a patch within a screen-space tolerance. `edges.rs` finds neighbouring
//! patches. `sub_patches.rs` chooses sub-patches to suit the drivers and the trims, `surface_trims.rs` for each patch.
//! `raised.rs` makes neighbours of patches whose common edge has two degrees. `square_nets.rs` brings patches of any
//! degree to the sizes that the bound knows. `normal_cone.rs` bounds the directions of normals. `plan.rs` combines
//! these once per frame. `triangle.rs` bounds the error of meshes' smooth triangles. `strokes.rs` covers
//! the gaps between surfaces that meet, and draws the edges of CAD models.

mod bound;
mod disjoint_sets;
mod edges;
mod normal_cone;
mod plan;
mod raised;
mod square_nets;
mod strokes;
mod sub_patches;
mod surface_trims;
mod triangle;

pub(crate) use bound::{Rounding, Screen};
pub(crate) use edges::{EdgeSource, EdgeTable};
pub use normal_cone::PatchKind;
pub(crate) use normal_cone::{Eye, NormalCone};
pub use plan::FrameStats;
pub(crate) use plan::{Lists, Plan, SubPatch, SurfacePatches, TrimmedList, raise};
pub(crate) use raised::{Raised, raised};
pub(crate) use square_nets::SquareNets;
pub(crate) use strokes::{
    CurvaturePaint, PlacedJoint, SEGMENT_TEXELS, StrokeLine, StrokePaint, StrokeSegment,
    StrokeSide, StrokeView, kept_for_strokes,
};
pub(crate) use sub_patches::{DrawSize, Split, Tessellated, patches_of_next_draw};
pub(crate) use surface_trims::SurfaceTrims;
pub(crate) use triangle::{TriangleBound, triangles_of_triangle, vertices_of_triangle};
