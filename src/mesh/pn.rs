//! Curved PN triangles.

use glam::DVec3;

use super::step::CurvedTriangle;
use super::vectors::{along, direction, mean, sum};
use super::{SmoothTriangle, normals};

/// A curved PN triangle: a cubic Bézier triangle for the shape and a quadratic one for the normals
/// (Vlachos, Peters, Boyd, Mitchell, *Curved PN Triangles*, 2001).
///
/// ```text
///              p2                      n2
///             /  \                    /  \        edge k runs from corner k to the next:
///         e20      e11            m2        m1    ek0 is its control point near corner k,
///        /   middle   \           /          \    ek1 the one near the next, mk its normal
///     e21              e10       n0----m0----n1
///      /                \
///    p0---e00------e01---p1
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PnTriangle {
    positions: [DVec3; 3],
    /// The offsets of the two inner control points of each edge from the thirds of the edge.
    edges: [[DVec3; 2]; 3],
    /// The offset of the middle control point from the centroid.
    middle: DVec3,
    normals: [DVec3; 3],
    edge_normals: [DVec3; 3],
}

impl PnTriangle {
    /// The control points over a triangle. An edge is straight at an end whose normal is zero.
    #[must_use]
    pub fn new(triangle: &SmoothTriangle) -> Self {
        let SmoothTriangle { positions, normals, edge_normals } = *triangle;
        // Projecting a third of the edge into the tangent plane moves it along the normal.
        let moved = |edge: DVec3, normal: DVec3| along(edge, normal) / -3.0;
        let edges = [0, 1, 2].map(|k| {
            let edge = positions[(k + 1) % 3] - positions[k];
            [moved(edge, edge_normals[k][0]), moved(-edge, edge_normals[k][1])]
        });
        let [a, b, c] = edges.map(|[near, far]| near + far);
        Self {
            positions,
            edges,
            // The mean of the thirds of all edges is the centroid V. So E − V is the mean of the offsets of the
            // edges' control points, and the paper's E + (E − V)/2 is V + 3/2 (E − V).
            middle: sum(a, b, c) / 4.0,
            normals,
            edge_normals: [0, 1, 2].map(|k| {
                let next = (k + 1) % 3;
                mirrored(positions[next] - positions[k], normals[k] + normals[next])
            }),
        }
    }

    /// The ten control points: the corners, then the two of each edge, near its first corner and
    /// near its second, then the middle.
    #[must_use]
    pub fn control_points(&self) -> [DVec3; 10] {
        let [a, b, c] = self.positions;
        let [ab, bc, ca] = self.edges;
        let near = |from: DVec3, to: DVec3, moved: DVec3| from + ((to - from) / 3.0 + moved);
        [
            a,
            b,
            c,
            near(a, b, ab[0]),
            near(b, a, ab[1]),
            near(b, c, bc[0]),
            near(c, b, bc[1]),
            near(c, a, ca[0]),
            near(a, c, ca[1]),
            a + (((b - a) + (c - a)) / 3.0 + self.middle),
        ]
    }

    /// The six coefficients of the normals: those of the corners, then one for each edge.
    #[must_use]
    pub const fn normal_coefficients(&self) -> [DVec3; 6] {
        let [a, b, c] = self.normals;
        let [ab, bc, ca] = self.edge_normals;
        [a, b, c, ab, bc, ca]
    }
}

impl CurvedTriangle for PnTriangle {
    fn position(&self, u: f64, v: f64, w: f64) -> DVec3 {
        let [a, b, c] = self.edges;
        let edge = |[near, far]: [DVec3; 2], s: f64, t: f64| {
            (near * (3.0 * s * s * t)) + (far * (3.0 * t * t * s))
        };
        let moved =
            sum(edge(a, u, v), edge(b, v, w), edge(c, w, u)) + self.middle * (6.0 * u * v * w);
        mean(self.positions, [u, v, w]) + moved
    }

    fn normal(&self, u: f64, v: f64, w: f64) -> DVec3 {
        let corners = mean(self.normals, [u * u, v * v, w * w]);
        let edges = mean(self.edge_normals, [u * v, v * w, w * u]);
        direction(corners + edges)
            .unwrap_or_else(|| normals::shading(self.normals, self.positions, [u, v, w]))
    }
}

/// The normal in the middle of an edge: the sum of the normals at its ends, reflected in the plane that bisects the
/// edge. If the edge has no length, nothing is reflected. The result is zero if the normals are opposite.
fn mirrored(edge: DVec3, sum: DVec3) -> DVec3 {
    let axis = edge.try_normalize().unwrap_or(DVec3::ZERO);
    direction(sum - 2.0 * along(sum, axis)).unwrap_or(DVec3::ZERO)
}
