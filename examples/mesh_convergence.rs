//! The distances of curved PN triangles and Phong tessellation from a sphere and a torus, compared with the
//! flat triangles of the same mesh.
//!
//! `cargo run --release --example mesh_convergence` prints `docs/mesh-convergence.md`.

#[path = "../tests/math/convergence.rs"]
mod convergence;
#[path = "../tests/math/shapes.rs"]
mod shapes;

fn main() {
    print!("{}", convergence::document());
}
