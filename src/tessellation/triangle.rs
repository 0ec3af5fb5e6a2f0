//! Bounds the screen-space distance between a smooth triangle and the triangles that it is divided into.
//!
//! Over a straight line of length h, linear interpolation is off by at most h²/8 times the second
//! derivative along it, which is that of the control points' differences: for an edge of Phong
//! tessellation |p − 2b + q|/(4n²), exactly. Over a small triangle in a circle of radius ρ it is off by
//! at most ρ²/2 times the largest second derivative in any direction. Lengths are counted so that the
//! whole triangle has sides of 1. Of a direction with barycentric differences a, b and c the second
//! derivative is −(ab·A + bc·B + ca·C), where A, B and C are those along the sides: at most 5/3 of
//! their largest. OpenGL's tessellator keeps its triangles in circles of radius 1/(√3·n), which makes
//! 5/18 of the largest, over n².
//!
//! A triangle is cut evenly by the largest level m of its edges, and an edge has the larger need of its
//! two sides, so no edge's level n is below what the triangle needs by itself. Where n < m, vertices of
//! the edge move along it to its own places, less than 1/n towards the middle, as the diagonals of the
//! cells point that Mesa and Direct3D draw. Of the two triangles of a cell, which is 1/m long and
//! 1/(√3·m) high, the one that stands on the edge then is 1/n long (or nothing), with its third corner
//! above it; the other one has a third corner on the edge, less than 1/n along it from the others' ends.
//! Either lies in a circle of radius 1/(√3·n): the bound holds at borders too. Where a driver's diagonals
//! point the other way, triangles there may reach twice as far.

use glam::{DMat4, DVec3, DVec4};

use super::bound::{Rounding, SUBPIXEL, Screen, Seen};

/// The largest number of levels that OpenGL supports along an edge.
const MAX_LEVELS: f64 = 64.0;
/// The factor that the largest second derivative along a side is multiplied by.
const INSIDE: f64 = 5.0 / 18.0;

/// Control points that stand in a row along a side, for 10 and for 6 of them, in the order of
/// `PnTriangle::control_points` and `PhongTriangle::control_points`.
const CUBIC: [[usize; 3]; 9] = [
    [0, 3, 4],
    [3, 4, 1],
    [8, 9, 5], //
    [1, 5, 6],
    [5, 6, 2],
    [4, 9, 7], //
    [2, 7, 8],
    [7, 8, 0],
    [6, 9, 3],
];
const QUADRATIC: [[usize; 3]; 3] = [[0, 3, 1], [1, 4, 2], [2, 5, 0]];

/// Error bounds derived from the control points of a smooth triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TriangleBound {
    /// Upper bound of its second derivative along any side, in pixels.
    curvature: f64,
    /// Upper bound of the rounding error at visible points, in pixels.
    rounding: f64,
    /// Whether it crosses the near plane. If so, the bound is valid only up to the tolerance.
    crosses_near: bool,
}

impl TriangleBound {
    /// From the 10 control points of a PN triangle, the 6 of a Phong triangle or the 3 of a flat one; `None` if it is
    /// out of view.
    pub(crate) fn new(
        points: &[DVec3],
        to_clip: &DMat4,
        screen: &Screen,
        rounding: &Rounding,
    ) -> Option<Self> {
        let mut clip = [DVec4::ZERO; 10];
        for (clip, point) in clip.iter_mut().zip(points) {
            *clip = *to_clip * point.extend(1.0);
        }
        let clip = &clip[..points.len()];
        let is_outside = (0..3)
            .any(|axis| clip.iter().all(|p| p[axis] < -p.w) || clip.iter().all(|p| p[axis] > p.w));
        if is_outside {
            return None;
        }
        let min_w = clip.iter().map(|p| p.w).fold(f64::INFINITY, f64::min);
        let crosses_near = min_w < screen.near();
        let seen = if crosses_near {
            Seen::across_near(screen, screen.near())
        } else {
            let range = |axis: usize| {
                clip.iter().map(|p| p[axis] / p.w).fold([1.0_f64, -1.0_f64], |[low, high], at| {
                    [low.min(at).max(-1.0), high.max(at).min(1.0)]
                })
            };
            Seen::new(screen, min_w, [range(0), range(1)])
        };
        let (rows, second): (&[[usize; 3]], f64) = match points.len() {
            10 => (&CUBIC, 6.0),
            6 => (&QUADRATIC, 2.0),
            _ => (&[], 0.0),
        };
        let bend = |[a, b, c]: &[usize; 3]| {
            let bend = (clip[*a] - clip[*b]) - (clip[*b] - clip[*c]);
            seen.squared_in_clip([bend.x, bend.y, bend.w])
        };
        let largest = rows.iter().map(bend).fold(0.0, f64::max);
        Some(Self {
            curvature: second * largest.sqrt(),
            rounding: rounding.pixels(screen) / min_w.max(screen.near()),
            crosses_near,
        })
    }

    /// The level that it needs without regard to its neighbours.
    pub(crate) fn level(&self, screen: &Screen) -> u8 {
        let left = screen.left_by(self.rounding);
        (INSIDE * self.curvature / left).sqrt().ceil().clamp(1.0, MAX_LEVELS) as u8
    }

    /// Upper bound of its distance from the triangles of a level, in pixels; infinite where no bound is known.
    pub(crate) fn error(&self, level: u8, screen: &Screen) -> f64 {
        let level = f64::from(level);
        let error = INSIDE * self.curvature / (level * level) + self.rounding + SUBPIXEL;
        if self.crosses_near && error > screen.tolerance() { f64::INFINITY } else { error }
    }
}

/// The number of vertices that the tessellator generates for a triangle at a level.
pub(crate) const fn vertices_of_triangle(level: u32) -> u32 {
    match level {
        0 => 1,
        1 => 3,
        _ => 3 * level + vertices_of_triangle(level - 2),
    }
}

/// The number of triangles that the tessellator generates for a triangle at a level, including degenerate ones along
/// coarser edges.
pub(crate) const fn triangles_of_triangle(level: u32) -> u64 {
    match level {
        0 => 0,
        1 => 1,
        _ => 6 * (level as u64 - 1) + triangles_of_triangle(level - 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_of_the_tessellator() {
        assert_eq!([1, 2, 3, 4].map(vertices_of_triangle), [3, 7, 12, 19]);
        assert_eq!([0, 1, 2, 3, 4].map(triangles_of_triangle), [0, 1, 6, 13, 24]);
        // Euler's formula for a disc: V − E + F = 1, and 3F = 2E − (edges of the border).
        for level in 1..=64 {
            let faces = triangles_of_triangle(level) as i64;
            let edges = (3 * faces + 3 * i64::from(level)) / 2;
            assert_eq!(i64::from(vertices_of_triangle(level)) - edges + faces, 1, "{level}");
        }
    }
}
