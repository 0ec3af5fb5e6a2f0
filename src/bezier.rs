//! Bézier curves and patches in `f64`: the oracle that everything drawn is measured against.
//!
//! A patch of degrees m and n holds (m + 1)×(n + 1) control points row by row: `u` runs along a row,
//! `v` from row to row. A bicubic patch:
//!
//! ```text
//!  v
//!  ^   12 13 14 15        row 3        A point is (x, y, z, w): a place and its weight.
//!  |    8  9 10 11        row 2        Weight 1 everywhere makes the patch polynomial,
//!  |    4  5  6  7        row 1        anything else rational.
//!  |    0  1  2  3        row 0
//!  +-------------> u
//! ```

mod bounds;
mod bspline;
mod curvature;
mod elevate;
mod nurbs;
mod parabola;
mod product;
mod split;

use glam::{DVec3, DVec4};

pub(crate) use bounds::bounding_box;
pub(crate) use bspline::{bezier_curves, check_knots, knots_of_bezier_curves, points_between};
pub use curvature::{CurvedPoint, SurfaceCurvature};
pub(crate) use elevate::{elevate, elevate_curve};
pub use nurbs::NurbsSurface;
pub(crate) use nurbs::{PatchGrid, span_of};
pub(crate) use parabola::{Difference, Parabola};
pub(crate) use product::{binomials, compositions, product};
pub(crate) use split::{split, split_slice};

use crate::error::{Error, Result};

/// The maximum number of control points along one side of a patch.
const MAX_SIDE: usize = Degree::MAX + 1;

/// Degrees of a patch along u and along v, each from 1 to 15. They fix the number of control points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Degree {
    u: u8,
    v: u8,
}

impl Degree {
    /// The largest degree along a direction.
    pub const MAX: usize = 15;
    /// Degree 3 along both directions: 4×4 control points, as in the thesis.
    pub const CUBIC: Self = Self { u: 3, v: 3 };
    /// Degree 4 along both directions: 5×5 control points, as in the report.
    pub const QUARTIC: Self = Self { u: 4, v: 4 };

    /// The degrees along u and along v.
    ///
    /// # Errors
    /// A degree that is not from 1 to 15.
    pub fn new(u: usize, v: usize) -> Result<Self> {
        let checked = |name: &str, degree: usize| match u8::try_from(degree) {
            Ok(checked) if (1..=Self::MAX).contains(&degree) => Ok(checked),
            _ => Err(Error::invalid(format!("degree along {name}"), degree, "1 to 15")),
        };
        Ok(Self { u: checked("u", u)?, v: checked("v", v)? })
    }

    /// The degree along u.
    #[must_use]
    pub const fn u(self) -> usize {
        self.u as usize
    }

    /// The degree along v.
    #[must_use]
    pub const fn v(self) -> usize {
        self.v as usize
    }

    /// Control points along u, in one row: 2 to 16.
    #[must_use]
    pub const fn columns(self) -> usize {
        self.u() + 1
    }

    /// Control points along v, in one column: 2 to 16.
    #[must_use]
    pub const fn rows(self) -> usize {
        self.v() + 1
    }

    /// Control points of a whole patch: 4 to 256.
    #[must_use]
    pub const fn points(self) -> usize {
        self.columns() * self.rows()
    }

    /// Whether a control point of a patch belongs to its border.
    pub(crate) const fn is_on_border(self, index: usize) -> bool {
        let (row, column) = (index / self.columns(), index % self.columns());
        row == 0 || row == self.v() || column == 0 || column == self.u()
    }

    /// Refuses degrees that the thesis' method does not draw.
    ///
    /// # Errors
    /// Any degrees but (3, 3) and (4, 4).
    pub fn check_for_thesis(self) -> Result<()> {
        if self == Self::CUBIC || self == Self::QUARTIC {
            return Ok(());
        }
        Err(Error::invalid("degree", self, "(3, 3) or (4, 4) with the thesis' method"))
    }

    /// The degree of a patch of `count` control points as the thesis and the report have them.
    ///
    /// # Errors
    /// Any count but 16 and 25.
    pub fn from_point_count(count: usize) -> Result<Self> {
        match count {
            16 => Ok(Self::CUBIC),
            25 => Ok(Self::QUARTIC),
            _ => Err(Error::invalid(
                "number of control points",
                count,
                "16 (4×4) or 25 (5×5), or the degrees beside them",
            )),
        }
    }
}

impl std::fmt::Display for Degree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({}, {})", self.u, self.v)
    }
}

/// The largest coordinate that is allowed, because shaders square differences of coordinates in `f32`.
pub(crate) const MAX_COORDINATE: f64 = 1e15;
/// Weights lie within this factor of 1, for the same reason.
const MAX_WEIGHT: f64 = 1e9;

/// Refuses a point that is not finite or too far away for `f32`.
pub(crate) fn check_coordinates(name: impl Into<String>, point: DVec3) -> Result<()> {
    if point.is_finite() && point.abs().max_element() <= MAX_COORDINATE {
        Ok(())
    } else {
        Err(Error::invalid(name, point, "finite coordinates of at most 1e15"))
    }
}

/// Refuses a control point that is not finite, further away than 1e15, or whose weight is not
/// between 1e-9 and 1e9.
///
/// # Errors
/// Names the point by its index.
pub fn check_control_point(point: DVec4, index: usize) -> Result<()> {
    check_coordinates(format!("control point {index}"), point.truncate())?;
    if !(1.0 / MAX_WEIGHT..=MAX_WEIGHT).contains(&point.w) {
        return Err(Error::invalid(
            format!("weight of control point {index}"),
            point.w,
            "a number above 0, from 1e-9 to 1e9",
        ));
    }
    Ok(())
}

/// A control point in homogeneous coordinates: (x·w, y·w, z·w, w).
#[must_use]
pub fn homogeneous(point: DVec4) -> DVec4 {
    (point.truncate() * point.w).extend(point.w)
}

/// Bernstein polynomial `i` of the given degree at `t`.
#[must_use]
pub fn bernstein(degree: usize, i: usize, t: f64) -> f64 {
    let mut binomial = 1.0;
    for j in 1..=i {
        binomial *= (degree + 1 - j) as f64 / j as f64;
    }
    binomial * t.powi(i as i32) * (1.0 - t).powi((degree - i) as i32)
}

/// The result of de Casteljau's algorithm: the point of the curve, and the last two points that it blends. The
/// difference of these two points, after projection, is the direction of the tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeCasteljau {
    /// The point of the curve.
    pub point: DVec4,
    /// The two points before the last blend.
    pub last: [DVec4; 2],
}

/// De Casteljau's algorithm on 2 to 16 points, at `t`.
///
/// # Panics
/// With fewer than 2 or more than 16 points.
#[must_use]
pub fn de_casteljau(points: &[DVec4], t: f64) -> DeCasteljau {
    assert!(
        (2..=MAX_SIDE).contains(&points.len()),
        "a curve of a patch has 2 to 16 control points"
    );
    let mut blended = [DVec4::ZERO; MAX_SIDE];
    blended[..points.len()].copy_from_slice(points);
    for count in (2..points.len()).rev() {
        for i in 0..count {
            blended[i] = blended[i] * (1.0 - t) + blended[i + 1] * t;
        }
    }
    DeCasteljau { point: blended[0] * (1.0 - t) + blended[1] * t, last: [blended[0], blended[1]] }
}

/// Value and first derivatives of a patch at one (u, v).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The point S(u, v).
    pub position: DVec3,
    /// ∂S/∂u.
    pub du: DVec3,
    /// ∂S/∂v.
    pub dv: DVec3,
}

/// One patch, borrowed from the control points of its surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch<'a> {
    degree: Degree,
    points: &'a [DVec4],
}

impl<'a> Patch<'a> {
    /// A patch over `degree.points()` control points (x, y, z, weight).
    ///
    /// # Panics
    /// If the number of points is not that of the degree.
    #[must_use]
    pub fn new(degree: Degree, points: &'a [DVec4]) -> Self {
        assert_eq!(points.len(), degree.points(), "control points of a patch");
        Self { degree, points }
    }

    /// The degree in both directions.
    #[must_use]
    pub const fn degree(&self) -> Degree {
        self.degree
    }

    /// The control points, row by row.
    #[must_use]
    pub const fn points(&self) -> &'a [DVec4] {
        self.points
    }

    /// Homogeneous control points of a row, in the first `columns()` entries.
    pub(crate) fn homogeneous_row(&self, row: usize) -> [DVec4; MAX_SIDE] {
        let columns = self.degree.columns();
        let mut points = [DVec4::ZERO; MAX_SIDE];
        for (to, from) in points.iter_mut().zip(&self.points[row * columns..][..columns]) {
            *to = homogeneous(*from);
        }
        points
    }

    /// The homogeneous point H(u, v) with ∂H/∂u and ∂H/∂v, by Bernstein polynomials.
    fn homogeneous_at(&self, u: f64, v: f64) -> [DVec4; 3] {
        let basis = |degree: usize, t: f64| {
            let mut value = [0.0; MAX_SIDE];
            let mut slope = [0.0; MAX_SIDE];
            for i in 0..=degree {
                value[i] = bernstein(degree, i, t);
                let below = if i > 0 { bernstein(degree - 1, i - 1, t) } else { 0.0 };
                let here = if i < degree { bernstein(degree - 1, i, t) } else { 0.0 };
                slope[i] = degree as f64 * (below - here);
            }
            (value, slope)
        };
        let (bu, bu_slope) = basis(self.degree.u(), u);
        let (bv, bv_slope) = basis(self.degree.v(), v);
        let mut sum = [DVec4::ZERO; 3];
        for (row, points) in self.points.chunks_exact(self.degree.columns()).enumerate() {
            for (column, point) in points.iter().enumerate() {
                let point = homogeneous(*point);
                sum[0] += point * (bu[column] * bv[row]);
                sum[1] += point * (bu_slope[column] * bv[row]);
                sum[2] += point * (bu[column] * bv_slope[row]);
            }
        }
        sum
    }

    /// Value and first derivatives at (u, v); for rational patches by the quotient rule.
    #[must_use]
    pub fn at(&self, u: f64, v: f64) -> SurfacePoint {
        let [value, du, dv] = self.homogeneous_at(u, v);
        let position = value.truncate() / value.w;
        SurfacePoint {
            position,
            du: (du.truncate() - position * du.w) / value.w,
            dv: (dv.truncate() - position * dv.w) / value.w,
        }
    }

    /// Unit normal Su × Sv, or `None` where the tangents are parallel or one of them vanishes. The test is relative
    /// to the longer tangent, so that neither the size of the model nor rounding errors matter.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> Option<DVec3> {
        const PARALLEL: f64 = 1e-12;
        let point = self.at(u, v);
        let cross = point.du.cross(point.dv);
        let scale = point.du.length_squared().max(point.dv.length_squared());
        (scale > 0.0 && cross.length() > PARALLEL * scale).then(|| cross.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bump(degree: Degree) -> Vec<DVec4> {
        let columns = degree.columns();
        (0..degree.points())
            .map(|i| {
                let (x, z) = ((i % columns) as f64, (i / columns) as f64);
                DVec4::new(x, (x * 1.3).sin() + (z * 0.7).cos(), -z, 1.0)
            })
            .collect()
    }

    #[test]
    fn bernstein_polynomials_sum_to_one_and_match_the_closed_forms() {
        for degree in [2, 3, 4] {
            for step in 0..=10 {
                let t = f64::from(step) / 10.0;
                let sum: f64 = (0..=degree).map(|i| bernstein(degree, i, t)).sum();
                assert!((sum - 1.0).abs() < 1e-14);
            }
        }
        assert!((bernstein(3, 1, 0.25) - 3.0 * 0.25 * 0.75 * 0.75).abs() < 1e-15);
        assert!((bernstein(4, 2, 0.5) - 6.0 / 16.0).abs() < 1e-15);
    }

    #[test]
    fn de_casteljau_and_bernstein_agree() {
        for (u, v) in [(1, 1), (2, 1), (3, 3), (4, 4), (1, 7), (15, 15)] {
            let degree = Degree::new(u, v).unwrap();
            let points = bump(degree);
            let patch = Patch::new(degree, &points);
            for step in 0..=100 {
                let (u, v) = (f64::from(step % 11) / 10.0, f64::from(step / 11) / 9.0);
                let mut column = [DVec4::ZERO; MAX_SIDE];
                for (row, point) in column.iter_mut().enumerate().take(degree.rows()) {
                    *point = de_casteljau(&patch.homogeneous_row(row)[..degree.columns()], u).point;
                }
                let end = de_casteljau(&column[..degree.rows()], v);
                let expected = patch.at(u, v);
                assert!((end.point.truncate() - expected.position).length() < 1e-13);
                let tangent = (end.last[1] - end.last[0]).truncate() * degree.v() as f64;
                assert!((tangent - expected.dv).length() < 1e-12);
            }
        }
    }

    #[test]
    fn derivatives_match_central_differences_on_a_rational_patch() {
        let mut points = bump(Degree::CUBIC);
        for (i, point) in points.iter_mut().enumerate() {
            point.w = 0.5 + (i % 5) as f64 * 0.4;
        }
        let patch = Patch::new(Degree::CUBIC, &points);
        let h = 1e-6;
        for (u, v) in [(0.2, 0.3), (0.5, 0.9), (0.71, 0.11)] {
            let at = patch.at(u, v);
            let du = (patch.at(u + h, v).position - patch.at(u - h, v).position) / (2.0 * h);
            let dv = (patch.at(u, v + h).position - patch.at(u, v - h).position) / (2.0 * h);
            assert!((at.du - du).length() < 1e-7 && (at.dv - dv).length() < 1e-7);
        }
    }

    #[test]
    fn a_rational_quarter_circle_is_round() {
        // The classic quadratic arc (weights 1, √½, 1), raised to degree 3 along u, straight along v.
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let w = (1.0 + 2.0 * s) / 3.0;
        let arc = [
            DVec4::new(1.0, 0.0, 0.0, 1.0),
            DVec4::new(1.0, 2.0 * s / (1.0 + 2.0 * s), 0.0, w),
            DVec4::new(2.0 * s / (1.0 + 2.0 * s), 1.0, 0.0, w),
            DVec4::new(0.0, 1.0, 0.0, 1.0),
        ];
        let points: Vec<DVec4> = (0..16).map(|i| arc[i % 4] + DVec4::Z * (i / 4) as f64).collect();
        let patch = Patch::new(Degree::CUBIC, &points);
        for step in 0..=20 {
            let p = patch.at(f64::from(step) / 20.0, 0.4).position;
            assert!((p.truncate().length() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_collapsed_edge_has_no_normal_at_any_scale() {
        for scale in [1e-6, 1.0, 1e6] {
            let mut points = bump(Degree::CUBIC);
            for point in &mut points {
                *point = (point.truncate() * scale).extend(1.0);
            }
            assert!(Patch::new(Degree::CUBIC, &points).normal(0.5, 0.0).is_some());
            for i in 0..4 {
                points[i] = points[0];
            }
            assert!(Patch::new(Degree::CUBIC, &points).normal(0.5, 0.0).is_none());
        }
    }

    #[test]
    fn only_16_and_25_points_make_a_patch() {
        assert_eq!(Degree::from_point_count(16).unwrap(), Degree::CUBIC);
        assert_eq!(Degree::from_point_count(25).unwrap(), Degree::QUARTIC);
        for count in [0, 15, 17, 24, 26] {
            let text = Degree::from_point_count(count).unwrap_err().to_string();
            assert!(text.contains(&count.to_string()) && text.contains("16"));
        }
    }

    #[test]
    fn degrees_are_1_to_15() {
        assert_eq!(Degree::new(3, 3).unwrap(), Degree::CUBIC);
        let degree = Degree::new(2, 1).unwrap();
        assert_eq!((degree.columns(), degree.rows(), degree.points()), (3, 2, 6));
        for (u, v, name) in [(0, 3, "u"), (16, 3, "u"), (3, 0, "v"), (3, 300, "v")] {
            let text = Degree::new(u, v).unwrap_err().to_string();
            assert!(text.contains(&format!("degree along {name}")) && text.contains("1 to 15"));
        }
    }

    #[test]
    fn bad_control_points_are_refused_by_index() {
        assert!(check_control_point(DVec4::new(1.0, 2.0, 3.0, 0.5), 0).is_ok());
        for (point, word) in [
            (DVec4::new(f64::NAN, 0.0, 0.0, 1.0), "control point 7"),
            (DVec4::new(0.0, f64::INFINITY, 0.0, 1.0), "finite"),
            (DVec4::new(0.0, 1e39, 0.0, 1.0), "at most 1e15"),
            (DVec4::new(0.0, 0.0, 0.0, 1e-50), "weight"),
            (DVec4::new(0.0, 0.0, 0.0, 0.0), "weight"),
            (DVec4::new(0.0, 0.0, 0.0, -1.0), "above 0"),
            (DVec4::new(0.0, 0.0, 0.0, f64::NAN), "weight"),
        ] {
            let text = check_control_point(point, 7).unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
    }
}
