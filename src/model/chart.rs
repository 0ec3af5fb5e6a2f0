//! The surfaces of faces as NURBS surfaces, exactly. Arcs are rational quadratic curves, so their parameters there are
//! not angles; an [`Axis`] converts between them.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3, DVec4};

use super::{BoundedCurve, Curve, FaceSurface, Frame};
use crate::bezier::{Degree, NurbsSurface, points_between};
use crate::error::Result;

/// How a parameter of a face's surface becomes that of the NURBS surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Axis {
    /// They are the same.
    Same,
    /// An angle: equal arcs, at whose ends both are the same.
    Arcs {
        /// Where the first arc begins.
        start: f64,
        /// The angle of an arc, at most π/2.
        step: f64,
        /// The number of arcs.
        count: usize,
    },
}

impl Axis {
    /// As few arcs as cover an interval of angles.
    pub(super) fn arcs([low, high]: [f64; 2]) -> Self {
        let count = ((high - low) / FRAC_PI_2 - 1e-9).ceil().max(1.0);
        Self::Arcs { start: low, step: (high - low) / count, count: count as usize }
    }

    /// The parameter of the NURBS surface, and its derivative. Beyond the interval, further arcs continue it.
    pub(super) fn drawn(&self, own: f64) -> [f64; 2] {
        let Self::Arcs { start, step, .. } = *self else { return [own, 1.0] };
        let half = 0.5 * step;
        let low = start + ((own - start) / step).floor() * step;
        let (tan, scale) = ((0.5 * (own - low - half)).tan(), (0.5 * half).tan());
        let x = tan / scale;
        [low + half * (1.0 + x), half * 0.5 * (1.0 + tan * tan) / scale]
    }

    /// The parameters where arcs begin or end.
    pub(super) fn ends_of_arcs(&self) -> Vec<f64> {
        let Self::Arcs { start, step, count } = *self else { return Vec::new() };
        (0..=count).map(|i| start + i as f64 * step).collect()
    }

    /// The unit circle over the interval as a B-spline curve: its knots and its control points (cos, sin, weight).
    fn circle(&self) -> (Vec<f64>, Vec<DVec3>) {
        let ends = self.ends_of_arcs();
        let Self::Arcs { step, .. } = *self else { return (ends, Vec::new()) };
        let weight = (0.5 * step).cos();
        let mut knots = vec![ends[0]];
        let mut points = Vec::with_capacity(2 * ends.len());
        for (i, end) in ends.iter().enumerate() {
            if i > 0 {
                points.push((unit(end - 0.5 * step) / weight).extend(weight));
            }
            points.push(unit(*end).extend(1.0));
            knots.extend([*end; 2]);
        }
        knots.push(ends[ends.len() - 1]);
        (knots, points)
    }
}

/// The point of the unit circle at an angle. Multiples of π/2 give zeros without rounding.
fn unit(angle: f64) -> DVec2 {
    let (sin, cos) = angle.sin_cos();
    let exact = |x: f64| if x.abs() < 4.0 * f64::EPSILON * angle.abs().max(1.0) { 0.0 } else { x };
    DVec2::new(exact(cos), exact(sin))
}

/// A curve as a B-spline curve of control points (x, y, z, weight).
pub(super) struct Profile {
    pub(super) degree: usize,
    pub(super) knots: Vec<f64>,
    pub(super) points: Vec<DVec4>,
}

impl Profile {
    /// The part of a curve between two parameters. A B-spline curve keeps whole spans.
    pub(super) fn new(curve: &Curve, [low, high]: [f64; 2]) -> Self {
        let arcs = |frame: &Frame, radii: [f64; 2]| {
            let axis = Axis::arcs([low, high]);
            let (knots, circle) = axis.circle();
            let place = |c: &DVec3| {
                let off = radii[0] * c.x * frame.x + radii[1] * c.y * frame.y;
                (frame.origin + off).extend(c.z)
            };
            Self { degree: 2, knots, points: circle.iter().map(place).collect() }
        };
        match curve {
            Curve::Line { .. } => Self {
                degree: 1,
                knots: vec![low, low, high, high],
                points: [low, high].map(|t| curve.at(t)[0].extend(1.0)).to_vec(),
            },
            Curve::Circle { frame, radius } => arcs(frame, [*radius; 2]),
            Curve::Ellipse { frame, radii } => arcs(frame, *radii),
            Curve::Nurbs(curve) => {
                let degree = curve.degree();
                let range = points_between(degree, curve.knots(), [low, high]);
                Self {
                    degree,
                    knots: curve.knots()[range.start..range.end + degree + 1].to_vec(),
                    points: curve.control_points()[range].to_vec(),
                }
            }
        }
    }

    /// The curve of a bounded one, over its range.
    pub(super) fn of(curve: &BoundedCurve) -> Self {
        Self::new(&curve.curve, curve.range)
    }
}

/// The axes of a surface over a box of its parameters.
pub(super) fn axes(surface: &FaceSurface, [low, high]: [DVec2; 2]) -> [Axis; 2] {
    let arcs = |axis: usize| Axis::arcs([low[axis], high[axis]]);
    let of_curve = |curve: &BoundedCurve, axis: usize| match curve.curve {
        Curve::Circle { .. } | Curve::Ellipse { .. } => arcs(axis),
        Curve::Line { .. } | Curve::Nurbs(_) => Axis::Same,
    };
    match surface {
        FaceSurface::Plane(_) | FaceSurface::Nurbs(_) => [Axis::Same; 2],
        FaceSurface::Cylinder { .. } | FaceSurface::Cone { .. } => [arcs(0), Axis::Same],
        FaceSurface::Sphere { .. } | FaceSurface::Torus { .. } => [arcs(0), arcs(1)],
        FaceSurface::Revolution { curve, .. } => [arcs(0), of_curve(curve, 1)],
        FaceSurface::Extrusion { curve, .. } => [of_curve(curve, 0), Axis::Same],
    }
}

/// The surface over a box of its parameters. A B-spline surface keeps whole spans.
///
/// # Errors
/// Coordinates that are too large, a box without area.
pub(super) fn drawn_surface(
    surface: &FaceSurface,
    bounds: [DVec2; 2],
    [along_u, along_v]: [Axis; 2],
) -> Result<NurbsSurface> {
    let [low, high] = bounds;
    let line = |axis: usize| vec![low[axis], low[axis], high[axis], high[axis]];
    match surface {
        FaceSurface::Plane(_) => {
            let corner = |i: usize| {
                let place = DVec2::new([low.x, high.x][i % 2], [low.y, high.y][i / 2]);
                surface.at(place.x, place.y).position.extend(1.0)
            };
            let points = (0..4).map(corner).collect();
            NurbsSurface::new(Degree::new(1, 1)?, [line(0), line(1)], points)
        }
        FaceSurface::Cylinder { frame, radius } => {
            let rows = [low.y, high.y].map(|v| DVec2::new(*radius, v));
            turned(frame, along_u, (1, line(1), &rows.map(|row| row.extend(1.0))))
        }
        FaceSurface::Cone { frame, radius, half_angle } => {
            let (sin, cos) = half_angle.sin_cos();
            // The apex is one point.
            let exact = |r: f64| if r.abs() < 1e-14 * radius { 0.0 } else { r };
            let row = |v: f64| DVec3::new(exact(radius + v * sin), v * cos, 1.0);
            turned(frame, along_u, (1, line(1), &[low.y, high.y].map(row)))
        }
        FaceSurface::Sphere { frame, radius } => {
            turned_circle(frame, [0.0, *radius], along_u, along_v)
        }
        FaceSurface::Torus { frame, major_radius, minor_radius } => {
            turned_circle(frame, [*major_radius, *minor_radius], along_u, along_v)
        }
        FaceSurface::Revolution { origin, axis, curve } => {
            let profile = Profile::new(&curve.curve, [low.y, high.y]);
            let (knots, circle) = along_u.circle();
            let place = |point: &DVec4, c: &DVec3| {
                let off = point.truncate() - *origin;
                let along = off.dot(*axis) * *axis;
                let turned = along + c.x * (off - along) + c.y * axis.cross(off);
                (*origin + turned).extend(point.w * c.z)
            };
            let rows = profile.points.iter();
            let points = rows.flat_map(|p| circle.iter().map(move |c| place(p, c))).collect();
            NurbsSurface::new(Degree::new(2, profile.degree)?, [knots, profile.knots], points)
        }
        FaceSurface::Extrusion { direction, curve } => {
            let profile = Profile::new(&curve.curve, [low.x, high.x]);
            let row = |v: f64| {
                let off = (v * *direction).extend(0.0);
                profile.points.iter().map(move |point| *point + off)
            };
            let points = row(low.y).chain(row(high.y)).collect();
            NurbsSurface::new(Degree::new(profile.degree, 1)?, [profile.knots, line(1)], points)
        }
        FaceSurface::Nurbs(surface) => {
            let degree = surface.degree();
            let [u, v] = surface.knots();
            let columns = points_between(degree.u(), u, [low.x, high.x]);
            let rows = points_between(degree.v(), v, [low.y, high.y]);
            let knots = [
                u[columns.start..columns.end + degree.u() + 1].to_vec(),
                v[rows.start..rows.end + degree.v() + 1].to_vec(),
            ];
            let all = surface.control_points().chunks_exact(surface.columns());
            let points = all.skip(rows.start).take(rows.len());
            let points = points.flat_map(|row| row[columns.clone()].iter().copied()).collect();
            NurbsSurface::new(degree, knots, points)
        }
    }
}

/// A circle of the second radius, at the distance of the first from the axis, turned about it.
fn turned_circle(
    frame: &Frame,
    [major, minor]: [f64; 2],
    along_u: Axis,
    along_v: Axis,
) -> Result<NurbsSurface> {
    let (knots, circle) = along_v.circle();
    let row = |c: &DVec3| DVec3::new(major + minor * c.x, minor * c.y, c.z);
    turned(frame, along_u, (2, knots, &circle.iter().map(row).collect::<Vec<_>>()))
}

/// A curve turned about the z axis of a frame: its degree, its knots and its control points (distance from the axis,
/// distance along it, weight).
fn turned(
    frame: &Frame,
    along_u: Axis,
    (degree, along_v, rows): (usize, Vec<f64>, &[DVec3]),
) -> Result<NurbsSurface> {
    let (along_u, circle) = along_u.circle();
    let place = |row: &DVec3, c: &DVec3| {
        let around = c.x * frame.x + c.y * frame.y;
        (frame.origin + row.x * around + row.y * frame.z).extend(row.z * c.z)
    };
    let points = rows.iter().flat_map(|row| circle.iter().map(move |c| place(row, c))).collect();
    NurbsSurface::new(Degree::new(2, degree)?, [along_u, along_v], points)
}
