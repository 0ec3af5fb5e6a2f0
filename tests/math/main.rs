//! Tests of everything that is computed without OpenGL: trims, meshes and files. Also compares the imports of
//! the source with the tables of `ARCHITECTURE.md`.

#[path = "../harness/trim_text.rs"]
#[allow(dead_code, unreachable_pub, reason = "each crate of tests uses a part of it")]
mod trim_text;

mod cad_import;
mod cad_models;
mod continuity;
mod convergence;
mod edge_bounds;
mod joints;
mod mesh_borders;
mod mesh_convergence;
mod mesh_faults;
mod meshes;
mod model_repairs;
mod model_solids;
mod model_text;
mod nurbs;
mod obj_freeform;
mod obj_freeform_faults;
mod obj_meshes;
mod obj_scenes;
mod rooms;
mod shapes;
#[cfg(feature = "svg")]
mod svg;
