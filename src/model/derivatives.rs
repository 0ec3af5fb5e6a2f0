//! Points of curves and surfaces with first and second derivatives. At a knot they are those of one side.

use glam::{DVec2, DVec3, DVec4};

use super::evaluate::{Basis, derivatives, turn_about};
use super::{Curve, FaceSurface, NurbsCurve};
use crate::bezier::{CurvedPoint, Degree, NurbsSurface, SurfacePoint, span_of};

/// The basis functions that are not 0 in a span, their first and their second derivatives.
struct Orders {
    /// The number of the first of them.
    first: usize,
    of: [[f64; Degree::MAX + 1]; 3],
}

impl Orders {
    /// At t, of the span that contains `side`.
    fn new(degree: usize, knots: &[f64], t: f64, side: f64) -> Self {
        let span = span_of(degree, knots, side);
        let Basis { first, values, slopes } = Basis::in_span(degree, knots, span, t);
        let lower = Basis::in_span(degree - 1, knots, span, t);
        let bends = derivatives(degree, knots, first, &lower.slopes);
        Self { first, of: [values, slopes, bends] }
    }
}

impl Curve {
    /// Point, first and second derivative at t; at a knot those of the span that contains `side`.
    fn curved(&self, t: f64, side: f64) -> [DVec3; 3] {
        let [point, slope] = self.at(t);
        match self {
            Self::Line { .. } => [point, slope, DVec3::ZERO],
            Self::Circle { frame, .. } | Self::Ellipse { frame, .. } => {
                [point, slope, frame.origin - point]
            }
            Self::Nurbs(curve) => curve.curved(t, side),
        }
    }
}

impl NurbsCurve<DVec4> {
    fn curved(&self, t: f64, side: f64) -> [DVec3; 3] {
        let orders = Orders::new(self.degree(), self.knots(), t, side);
        let mut sums = [DVec4::ZERO; 3];
        for (i, point) in self.control_points()[orders.first..][..=self.degree()].iter().enumerate()
        {
            let point = (point.truncate() * point.w).extend(point.w);
            for (sum, basis) in sums.iter_mut().zip(&orders.of) {
                *sum += point * basis[i];
            }
        }
        let [value, first, second] = sums;
        let point = value.truncate() / value.w;
        let slope = (first.truncate() - point * first.w) / value.w;
        let bend = (second.truncate() - 2.0 * slope * first.w - point * second.w) / value.w;
        [point, slope, bend]
    }
}

impl FaceSurface {
    /// Point, first and second derivatives at (u, v); at a knot those of the span that contains `side`.
    pub(super) fn curved(&self, uv: DVec2, side: DVec2) -> CurvedPoint {
        let (u, v) = (uv.x, uv.y);
        let with = |[duu, duv, dvv]: [DVec3; 3]| CurvedPoint { at: self.at(u, v), duu, duv, dvv };
        match self {
            Self::Plane(_) => with([DVec3::ZERO; 3]),
            Self::Cylinder { frame, radius } => {
                with([-*radius * frame.turned(u)[0], DVec3::ZERO, DVec3::ZERO])
            }
            Self::Cone { frame, radius, half_angle } => {
                let ([x, y], sin) = (frame.turned(u), half_angle.sin());
                with([-(radius + v * sin) * x, sin * y, DVec3::ZERO])
            }
            Self::Sphere { frame, radius } => {
                with(tube(frame.turned(u), frame.z, [0.0, *radius], v))
            }
            Self::Torus { frame, major_radius, minor_radius } => {
                with(tube(frame.turned(u), frame.z, [*major_radius, *minor_radius], v))
            }
            Self::Revolution { origin, axis, curve } => {
                let [point, slope, bend] = curve.curve.curved(v, side.y);
                let turn = turn_about(*axis, u);
                let (off, dv) = (turn(point - *origin), turn(slope));
                let du = axis.cross(off);
                CurvedPoint {
                    at: SurfacePoint { position: *origin + off, du, dv },
                    duu: axis.cross(du),
                    duv: axis.cross(dv),
                    dvv: turn(bend),
                }
            }
            Self::Extrusion { direction, curve } => {
                let [point, du, duu] = curve.curve.curved(u, side.x);
                let position = point + v * *direction;
                let at = SurfacePoint { position, du, dv: *direction };
                CurvedPoint { at, duu, duv: DVec3::ZERO, dvv: DVec3::ZERO }
            }
            Self::Nurbs(surface) => nurbs(surface, uv, side),
        }
    }
}

/// The second derivatives of a circle of the second radius, at the distance of the first from the axis, turned about
/// it.
fn tube([x, y]: [DVec3; 2], z: DVec3, [major, minor]: [f64; 2], v: f64) -> [DVec3; 3] {
    let (sin, cos) = v.sin_cos();
    [-(major + minor * cos) * x, -minor * sin * y, -minor * (cos * x + sin * z)]
}

fn nurbs(surface: &NurbsSurface, uv: DVec2, side: DVec2) -> CurvedPoint {
    let ([along_u, along_v], degree) = (surface.knots(), surface.degree());
    let u = Orders::new(degree.u(), along_u, uv.x, side.x);
    let v = Orders::new(degree.v(), along_v, uv.y, side.y);
    // The derivative of order i along u and j along v.
    let mut sums = [[DVec4::ZERO; 3]; 3];
    for row in 0..=degree.v() {
        let first = (v.first + row) * surface.columns() + u.first;
        let mut of_row = [DVec4::ZERO; 3];
        for (i, point) in surface.control_points()[first..][..=degree.u()].iter().enumerate() {
            let point = (point.truncate() * point.w).extend(point.w);
            for (sum, basis) in of_row.iter_mut().zip(&u.of) {
                *sum += point * basis[i];
            }
        }
        for (sums, of_row) in sums.iter_mut().zip(of_row) {
            for (sum, basis) in sums.iter_mut().zip(&v.of) {
                *sum += of_row * basis[row];
            }
        }
    }
    let [[value, v1, v2], [u1, uv, _], [u2, _, _]] = sums;
    CurvedPoint::of_homogeneous([value, u1, v1, u2, uv, v2])
}
