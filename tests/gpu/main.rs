//! Pictures drawn by OpenGL, compared with references in `f64`: with EGL, and with OSMesa where it is
//! available.

#[path = "../harness/mod.rs"]
mod harness;

mod analysis;
mod comparison;
mod contexts;
mod curvature;
mod depth;
mod drivers;
mod edges;
mod figures;
mod isolines;
mod joined_surfaces;
mod leaks;
mod light;
mod mesh_colors;
mod mesh_errors;
mod mesh_stability;
mod mesh_triangles;
mod models;
mod nurbs;
mod obj_files;
mod program_interface;
#[cfg(feature = "svg")]
mod scene_text;
mod solids;
mod surface;
mod tessellation;
mod tessellation_errors;
mod tessellation_stability;
mod trim_curves;
mod trim_stability;
#[cfg(feature = "svg")]
mod trims;
