//! How patches are cut into triangles.
//!
//! `bound.rs` tells how many triangles keep a patch within a tolerance on the screen, `edges.rs` which
//! patches are neighbours, `sub-patches.rs` what the drivers and the trims ask for, `normal_cone.rs` where
//! normals point to, and `plan.rs` puts it all together once a frame. `triangle.rs` bounds the smooth triangles of
//! meshes.

mod bound;
mod edges;
mod normal_cone;
mod plan;
mod sub_patches;
mod triangle;

pub(crate) use bound::{Rounding, Screen};
pub(crate) use edges::{EdgeSource, EdgeTable};
pub use normal_cone::PatchKind;
pub(crate) use normal_cone::{Eye, NormalCone};
pub use plan::FrameStats;
pub(crate) use plan::{Lists, Plan, SubPatch, SurfacePatches, raise};
pub(crate) use sub_patches::{DrawSize, FixedSplit, Split, TrimSplits, patches_of_next_draw};
pub(crate) use triangle::{TriangleBound, triangles_of_triangle, vertices_of_triangle};
