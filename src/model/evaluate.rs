//! Curves and surfaces at given parameters.

use glam::{DVec2, DVec3, DVec4};

use super::{Curve, FaceSurface, Frame, NurbsCurve};
use crate::bezier::{Degree, NurbsSurface, SurfacePoint, span_of};

/// The B-spline basis functions that are not 0 at a parameter, and their derivatives.
pub(super) struct Basis {
    /// The number of the first of them.
    pub(super) first: usize,
    pub(super) values: [f64; Degree::MAX + 1],
    pub(super) slopes: [f64; Degree::MAX + 1],
}

impl Basis {
    /// Parameters outside the domain continue the first or the last span.
    fn new(degree: usize, knots: &[f64], t: f64) -> Self {
        Self::in_span(degree, knots, span_of(degree, knots, t), t)
    }

    /// By the recursion of Cox and de Boor, in the span that begins at a knot.
    pub(super) fn in_span(degree: usize, knots: &[f64], span: usize, t: f64) -> Self {
        let first = span - degree;
        let mut values = [0.0; Degree::MAX + 1];
        values[0] = 1.0;
        let mut lower = values;
        for round in 1..=degree {
            lower = values;
            let mut carried = 0.0;
            for r in 0..round {
                let [low, high] = [knots[span + r + 1 - round], knots[span + r + 1]];
                let part = values[r] / (high - low);
                values[r] = carried + (high - t) * part;
                carried = (t - low) * part;
            }
            values[round] = carried;
        }
        let slopes = derivatives(degree, knots, first, &lower);
        Self { first, values, slopes }
    }
}

/// The derivatives of the basis functions of a degree from those of the next lower degree, or from their values.
pub(super) fn derivatives(
    degree: usize,
    knots: &[f64],
    first: usize,
    lower: &[f64; Degree::MAX + 1],
) -> [f64; Degree::MAX + 1] {
    let mut derivatives = [0.0; Degree::MAX + 1];
    for (r, derivative) in derivatives.iter_mut().enumerate().take(degree + 1) {
        let share = |j: usize, i: usize| lower[j] / (knots[i + degree] - knots[i]);
        let before = if r > 0 { share(r - 1, first + r) } else { 0.0 };
        let after = if r < degree { share(r, first + r + 1) } else { 0.0 };
        *derivative = degree as f64 * (before - after);
    }
    derivatives
}

impl Frame {
    /// Its x axis turned by an angle towards its y axis, and the derivative.
    pub(super) fn turned(&self, angle: f64) -> [DVec3; 2] {
        let (sin, cos) = angle.sin_cos();
        [cos * self.x + sin * self.y, cos * self.y - sin * self.x]
    }

    /// The coordinates of a point in the frame.
    pub(super) fn local(&self, point: DVec3) -> DVec3 {
        let off = point - self.origin;
        DVec3::new(off.dot(self.x), off.dot(self.y), off.dot(self.z))
    }
}

impl NurbsCurve<DVec4> {
    /// Point and derivative at a parameter.
    #[must_use]
    pub fn at(&self, t: f64) -> [DVec3; 2] {
        let [value, slope] = self.blended(t, |point| (point.truncate() * point.w).extend(point.w));
        let position = value.truncate() / value.w;
        [position, (slope.truncate() - position * slope.w) / value.w]
    }
}

impl NurbsCurve<DVec3> {
    /// Point and derivative at a parameter.
    #[must_use]
    pub fn at(&self, t: f64) -> [DVec2; 2] {
        let [value, slope] = self.blended(t, |point| (point.truncate() * point.z).extend(point.z));
        let position = value.truncate() / value.z;
        [position, (slope.truncate() - position * slope.z) / value.z]
    }
}

impl<P: Copy + Default + std::ops::AddAssign + std::ops::Mul<f64, Output = P>> NurbsCurve<P> {
    /// The homogeneous point at a parameter, and its derivative.
    fn blended(&self, t: f64, homogeneous: impl Fn(P) -> P) -> [P; 2] {
        let basis = Basis::new(self.degree(), self.knots(), t);
        let (mut value, mut slope) = (P::default(), P::default());
        for (i, point) in self.control_points()[basis.first..][..=self.degree()].iter().enumerate()
        {
            let point = homogeneous(*point);
            value += point * basis.values[i];
            slope += point * basis.slopes[i];
        }
        [value, slope]
    }
}

impl Curve {
    /// Point and derivative at a parameter.
    #[must_use]
    pub fn at(&self, t: f64) -> [DVec3; 2] {
        match self {
            Self::Line { origin, direction } => [*origin + t * *direction, *direction],
            Self::Circle { frame, radius } => {
                let [x, y] = frame.turned(t);
                [frame.origin + *radius * x, *radius * y]
            }
            Self::Ellipse { frame, radii: [a, b] } => {
                let (sin, cos) = t.sin_cos();
                let (x, y) = (*a * frame.x, *b * frame.y);
                [frame.origin + cos * x + sin * y, cos * y - sin * x]
            }
            Self::Nurbs(curve) => curve.at(t),
        }
    }
}

impl FaceSurface {
    /// Point and first derivatives at the parameters (u, v).
    #[must_use]
    pub fn at(&self, u: f64, v: f64) -> SurfacePoint {
        match self {
            Self::Plane(frame) => SurfacePoint {
                position: frame.origin + u * frame.x + v * frame.y,
                du: frame.x,
                dv: frame.y,
            },
            Self::Cylinder { frame, radius } => {
                let [x, y] = frame.turned(u);
                let position = frame.origin + *radius * x + v * frame.z;
                SurfacePoint { position, du: *radius * y, dv: frame.z }
            }
            Self::Cone { frame, radius, half_angle } => {
                let [x, y] = frame.turned(u);
                let (sin, cos) = half_angle.sin_cos();
                let radius = radius + v * sin;
                let position = frame.origin + radius * x + v * cos * frame.z;
                SurfacePoint { position, du: radius * y, dv: sin * x + cos * frame.z }
            }
            Self::Sphere { frame, radius } => tube(frame, [0.0, *radius], u, v),
            Self::Torus { frame, major_radius, minor_radius } => {
                tube(frame, [*major_radius, *minor_radius], u, v)
            }
            Self::Revolution { origin, axis, curve } => {
                let [point, slope] = curve.curve.at(v);
                let turn = turn_about(*axis, u);
                let off = turn(point - *origin);
                SurfacePoint { position: *origin + off, du: axis.cross(off), dv: turn(slope) }
            }
            Self::Extrusion { direction, curve } => {
                let [point, slope] = curve.curve.at(u);
                SurfacePoint { position: point + v * *direction, du: slope, dv: *direction }
            }
            Self::Nurbs(surface) => nurbs_at(surface, u, v),
        }
    }
}

/// Turns vectors about an axis by an angle.
pub(super) fn turn_about(axis: DVec3, angle: f64) -> impl Fn(DVec3) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    move |off| {
        let along = off.dot(axis) * axis;
        along + cos * (off - along) + sin * axis.cross(off)
    }
}

/// A circle of the second radius, at the distance of the first from the axis, turned about it.
fn tube(frame: &Frame, [major, minor]: [f64; 2], u: f64, v: f64) -> SurfacePoint {
    let [x, y] = frame.turned(u);
    let (sin, cos) = v.sin_cos();
    let radius = major + minor * cos;
    SurfacePoint {
        position: frame.origin + radius * x + minor * sin * frame.z,
        du: radius * y,
        dv: minor * (cos * frame.z - sin * x),
    }
}

/// The same as [`NurbsSurface::at`], without allocations.
pub(super) fn nurbs_at(surface: &NurbsSurface, u: f64, v: f64) -> SurfacePoint {
    let [along_u, along_v] = surface.knots();
    let degree = surface.degree();
    let (u, v) = (Basis::new(degree.u(), along_u, u), Basis::new(degree.v(), along_v, v));
    let (mut value, mut du, mut dv) = (DVec4::ZERO, DVec4::ZERO, DVec4::ZERO);
    let columns = surface.columns();
    for j in 0..=degree.v() {
        let row = &surface.control_points()[(v.first + j) * columns + u.first..][..=degree.u()];
        let (mut of_row, mut slope) = (DVec4::ZERO, DVec4::ZERO);
        for (i, point) in row.iter().enumerate() {
            let point = (point.truncate() * point.w).extend(point.w);
            of_row += point * u.values[i];
            slope += point * u.slopes[i];
        }
        value += of_row * v.values[j];
        du += slope * v.values[j];
        dv += of_row * v.slopes[j];
    }
    let position = value.truncate() / value.w;
    let derivative = |of: DVec4| (of.truncate() - position * of.w) / value.w;
    SurfacePoint { position, du: derivative(du), dv: derivative(dv) }
}
