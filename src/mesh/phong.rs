//! Phong tessellation.

use glam::DVec3;

use super::step::CurvedTriangle;
use super::vectors::{along, mean};
use super::{Alpha, SmoothTriangle, normals};

/// A triangle of Phong tessellation (Boubekeur, Alexa, *Phong Tessellation*, 2008), which is a
/// quadratic Bézier triangle: its corners are those of the triangle, and the control point of the
/// edge from p to q lies at (1 − α)(p + q)/2 + α(π_p(q) + π_q(p))/2, where π_p projects into the
/// tangent plane at p. Normals are interpolated linearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhongTriangle {
    positions: [DVec3; 3],
    /// The offset of the control point of each edge from the middle of the edge.
    edges: [DVec3; 3],
    normals: [DVec3; 3],
}

impl PhongTriangle {
    /// The control points over a triangle. Where a normal is zero, nothing is projected.
    #[must_use]
    pub fn new(triangle: &SmoothTriangle, alpha: Alpha) -> Self {
        let SmoothTriangle { positions, normals, edge_normals } = *triangle;
        Self {
            positions,
            edges: [0, 1, 2].map(|k| {
                let edge = positions[(k + 1) % 3] - positions[k];
                let [near, far] = edge_normals[k];
                (along(edge, near) + along(-edge, far)) * (-0.5 * alpha.get())
            }),
            normals,
        }
    }

    /// The six control points: the corners, then one for each edge from corner k to the next.
    #[must_use]
    pub fn control_points(&self) -> [DVec3; 6] {
        let [a, b, c] = self.positions;
        let [ab, bc, ca] = self.edges;
        let middle = |from: DVec3, to: DVec3, moved: DVec3| from + ((to - from) / 2.0 + moved);
        [a, b, c, middle(a, b, ab), middle(b, c, bc), middle(c, a, ca)]
    }
}

impl CurvedTriangle for PhongTriangle {
    fn position(&self, u: f64, v: f64, w: f64) -> DVec3 {
        let moved = mean(self.edges, [2.0 * u * v, 2.0 * v * w, 2.0 * w * u]);
        mean(self.positions, [u, v, w]) + moved
    }

    fn normal(&self, u: f64, v: f64, w: f64) -> DVec3 {
        normals::shading(self.normals, self.positions, [u, v, w])
    }
}
