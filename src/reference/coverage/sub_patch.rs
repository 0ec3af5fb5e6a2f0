//! Sub-patches of patches in clip space, and the number of triangles that each needs.

use glam::{DMat4, DVec2, DVec4, UVec2};

use super::{Corner, TOLERANCE_PX};
use crate::bezier::{Degree, Patch, homogeneous};

/// The maximum number of cells along a side of a sub-patch; a sub-patch that needs more is cut into four.
const MAX_CELLS: usize = 16;
/// The maximum number of times that a sub-patch is cut into four.
const MAX_CUTS: u32 = 9;
/// The maximum number of control points along a side of a patch.
const MAX_SIDE: usize = Degree::MAX + 1;

/// A square region of a patch, in clip space.
#[derive(Clone)]
pub(super) struct SubPatch {
    /// Homogeneous control points, row by row.
    points: Vec<DVec4>,
    degree: Degree,
    /// The minimum w of points in front of the near plane.
    near_w: f64,
    /// The corner with the minimum (u, v), and the length of the sides.
    corner: DVec2,
    length: f64,
    cuts: u32,
}

impl SubPatch {
    /// `near_w` is the one for points whose weight is 1.
    pub(super) fn whole(patch: &Patch<'_>, to_clip: &DMat4, near_w: f64) -> Self {
        let points = patch.points().iter().map(|point| *to_clip * homogeneous(*point)).collect();
        let min_weight = patch.points().iter().map(|point| point.w).fold(f64::INFINITY, f64::min);
        Self {
            points,
            degree: patch.degree(),
            near_w: near_w * min_weight,
            corner: DVec2::ZERO,
            length: 1.0,
            cuts: 0,
        }
    }

    /// Cuts it into sub-patches that need few enough cells in a picture of `size` pixels. Passes those that may
    /// be visible to `draw`, with their number of cells along a side.
    pub(super) fn cut_up(&self, size: UVec2, draw: &mut dyn FnMut(&Self, usize)) {
        if self.is_out_of_sight() {
            return;
        }
        let cells = self.cells(size);
        if cells > MAX_CELLS as f64 && self.cuts < MAX_CUTS {
            for quarter in 0..4 {
                self.quarter(quarter & 1, quarter >> 1).cut_up(size, draw);
            }
        } else {
            draw(self, cells.min(MAX_CELLS as f64) as usize);
        }
    }

    /// The corners of `cells` × `cells` cells, row by row.
    pub(super) fn corners(&self, cells: usize) -> impl Iterator<Item = Corner> {
        let at = move |i: usize| i as f64 / cells as f64;
        (0..=cells).flat_map(move |j| {
            let row = self.row(at(j));
            (0..=cells).map(move |i| Corner {
                clip: curve(&row, self.degree.columns(), 1, at(i)),
                uv: self.corner + DVec2::new(at(i), at(j)) * self.length,
            })
        })
    }

    /// z / w of the point at a place of the patch.
    pub(super) fn depth(&self, uv: DVec2) -> f64 {
        let at = (uv - self.corner) / self.length;
        let point = curve(&self.row(at.y), self.degree.columns(), 1, at.x);
        point.z / point.w
    }

    /// The control points of the curve along u at a place along v, in the first `columns()` entries.
    fn row(&self, v: f64) -> [DVec4; MAX_SIDE] {
        let (columns, rows) = (self.degree.columns(), self.degree.rows());
        let mut row = [DVec4::ZERO; MAX_SIDE];
        for (column, point) in row[..columns].iter_mut().enumerate() {
            *point = curve(&self.points[column..], rows, columns, v);
        }
        row
    }

    /// Whether all control points, and therefore the sub-patch, lie beyond one plane of the view frustum.
    fn is_out_of_sight(&self) -> bool {
        let all = |beyond: fn(&DVec4) -> bool| self.points.iter().all(beyond);
        all(|p| p.x > p.w)
            || all(|p| p.x < -p.w)
            || all(|p| p.y > p.w)
            || all(|p| p.y < -p.w)
            || all(|p| p.z > p.w)
            || all(|p| p.z < -p.w)
    }

    /// The number of cells along a side, at least 1, that keeps triangles within the tolerance where the
    /// picture shows them.
    ///
    /// Let H be the sub-patch, L the triangles and e = H − L, both at the same (u, v). The distance on the
    /// screen is that of (e.xy − L.xy / L.w · e.w) / H.w, where L.xy / L.w lies in the picture. With n cells,
    /// |e| ≤ (|Huu| + 2|Huv| + |Hvv|) / 8n², and the control points bound the derivatives.
    fn cells(&self, size: UVec2) -> f64 {
        let (columns, rows, points) = (self.degree.columns(), self.degree.rows(), &self.points);
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        let mut min_w = f64::INFINITY;
        for point in points {
            let place = point.truncate().truncate() / point.w;
            (low, high) = (low.min(place), high.max(place));
            min_w = min_w.min(point.w);
        }
        let [low, high] = if min_w > 0.0 {
            [low, high].map(|place| place.clamp(DVec2::NEG_ONE, DVec2::ONE))
        } else {
            [DVec2::NEG_ONE, DVec2::ONE]
        };
        let half_size = size.as_dvec2() * 0.5;
        let on_screen = |e: DVec4| {
            let xy = e.truncate().truncate();
            ((xy - low * e.w).abs().max((xy - high * e.w).abs()) * half_size).length_squared()
        };
        let at = |column: usize, row: usize| points[row * columns + column];
        let (mut uu, mut uv, mut vv) = (0_f64, 0_f64, 0_f64);
        for row in 0..rows {
            for i in 2..columns {
                uu = uu.max(on_screen(at(i, row) - 2.0 * at(i - 1, row) + at(i - 2, row)));
            }
        }
        for column in 0..columns {
            for i in 2..rows {
                vv = vv.max(on_screen(at(column, i) - 2.0 * at(column, i - 1) + at(column, i - 2)));
            }
        }
        for row in 1..rows {
            for column in 1..columns {
                let twist = at(column, row) - at(column - 1, row) - at(column, row - 1)
                    + at(column - 1, row - 1);
                uv = uv.max(on_screen(twist));
            }
        }
        let (m, n) = (self.degree.u() as f64, self.degree.v() as f64);
        let second =
            m * (m - 1.0) * uu.sqrt() + 2.0 * m * n * uv.sqrt() + n * (n - 1.0) * vv.sqrt();
        (second / (8.0 * TOLERANCE_PX * min_w.max(self.near_w))).sqrt().ceil().max(1.0)
    }

    /// The lower (0) or upper (1) half in u and v, by de Casteljau's algorithm.
    fn quarter(&self, u: usize, v: usize) -> Self {
        let mut quarter = self.clone();
        let (columns, rows) = (self.degree.columns(), self.degree.rows());
        for row in 0..rows {
            halve(&mut quarter.points[row * columns..], columns, 1, u);
        }
        for column in 0..columns {
            halve(&mut quarter.points[column..], rows, columns, v);
        }
        quarter.length *= 0.5;
        quarter.corner += DVec2::new(u as f64, v as f64) * quarter.length;
        quarter.cuts += 1;
        quarter
    }
}

/// Replaces a curve by its first (0) or second (1) half; its points are `step` apart.
fn halve(points: &mut [DVec4], count: usize, step: usize, half: usize) {
    for round in 1..count {
        if half == 0 {
            for i in (round..count).rev() {
                points[i * step] = (points[i * step] + points[(i - 1) * step]) * 0.5;
            }
        } else {
            for i in 0..count - round {
                points[i * step] = (points[i * step] + points[(i + 1) * step]) * 0.5;
            }
        }
    }
}

/// The point at `t` of a Bézier curve whose points are `step` apart.
fn curve(points: &[DVec4], count: usize, step: usize, t: f64) -> DVec4 {
    // Horner's scheme in t / s, times the powers of s.
    let s = 1.0 - t;
    let mut sum = points[0] * s;
    let mut power = t;
    let mut binomial = 1.0;
    let degree = count - 1;
    for i in 1..degree {
        binomial *= (degree + 1 - i) as f64 / i as f64;
        sum = (sum + points[i * step] * (binomial * power)) * s;
        power *= t;
    }
    sum + points[degree * step] * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_parts_of_the_curve() {
        let points: Vec<DVec4> =
            (0..5).map(|i| DVec4::new(f64::from(i), f64::from(i * i % 3), 0.5, 1.0)).collect();
        for half in [0, 1] {
            let mut sub_patch = points.clone();
            halve(&mut sub_patch, 5, 1, half);
            for t in [0.0, 0.3, 1.0] {
                let whole = curve(&points, 5, 1, 0.5 * (t + half as f64));
                assert!((curve(&sub_patch, 5, 1, t) - whole).length() < 1e-14);
            }
        }
        let expected = crate::bezier::de_casteljau(&points, 0.3).point;
        assert!((curve(&points, 5, 1, 0.3) - expected).length() < 1e-14);
    }
}
