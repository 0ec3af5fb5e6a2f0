//! A face's surface with what is needed to find points on it: where it ends, along which parameters it is closed, and
//! the parameters of the nearest point.

use std::cell::{Cell, OnceCell};
use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3, dvec2};

use super::{BoundedCurve, Curve, FaceSurface};
use crate::bezier::CurvedPoint;
use crate::bezier::{NurbsSurface, SurfacePoint, bounding_box};

/// A surface without the bounds of a face.
pub(super) struct Sheet<'a> {
    pub(super) surface: &'a FaceSurface,
    /// The periods along u and v, where it is closed.
    pub(super) periods: [Option<f64>; 2],
    /// The least and the largest parameters; infinite where it goes on or where it is closed by angles.
    pub(super) limits: [DVec2; 2],
    /// Distances in space below this do not count.
    pub(super) tolerance: f64,
    /// The largest distance of a point from the surface that is not taken for a wrong start.
    accepted: Cell<f64>,
    /// Points where searches begin.
    samples: OnceCell<Samples>,
    /// Points where a parameter has no meaning.
    poles: OnceCell<Vec<DVec3>>,
}

/// Points of a surface in rows along u.
struct Samples {
    points: Vec<(DVec2, DVec3)>,
    columns: usize,
}

/// The number of places along a B-spline curve or one direction of a surface where searches begin.
const MIN_SAMPLES: usize = 24;
const MAX_SAMPLES: usize = 200;

impl<'a> Sheet<'a> {
    /// Distances in space below `tolerance` do not count. Borders of B-splines that are closer than `closed` are the
    /// same.
    pub(super) fn new(surface: &'a FaceSurface, tolerance: f64, closed: f64) -> Self {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        let turn = (Some(TAU), everywhere);
        let of_curve = |curve: &BoundedCurve| match &curve.curve {
            Curve::Line { .. } => (None, everywhere),
            Curve::Circle { .. } | Curve::Ellipse { .. } => {
                if curve.range[1] - curve.range[0] > TAU - 1e-9 { turn } else { (None, everywhere) }
            }
            Curve::Nurbs(nurbs) => {
                let [low, high] = nurbs.domain();
                let is_closed = nurbs.at(low)[0].distance(nurbs.at(high)[0]) <= closed;
                (is_closed.then_some(high - low), [low, high])
            }
        };
        let infinite = (None, everywhere);
        let (u, v) = match surface {
            FaceSurface::Plane(_) => (infinite, infinite),
            FaceSurface::Cylinder { .. } | FaceSurface::Cone { .. } => (turn, infinite),
            FaceSurface::Sphere { .. } => (turn, (None, [-FRAC_PI_2, FRAC_PI_2])),
            FaceSurface::Torus { .. } => (turn, turn),
            FaceSurface::Revolution { origin, axis, curve } => {
                let off_axis =
                    |t: f64| (curve.curve.at(t)[0] - *origin).reject_from(*axis).length();
                let (period, limits) = of_curve(curve);
                // Between two poles there is nothing beyond the curve's ends, as on a sphere.
                let is_whole = curve.range.into_iter().all(|t| off_axis(t) <= tolerance);
                (turn, (period, if is_whole { curve.range } else { limits }))
            }
            FaceSurface::Extrusion { curve, .. } => (of_curve(curve), infinite),
            FaceSurface::Nurbs(nurbs) => {
                let [low, high] = nurbs.domain();
                let [u, v] = closed_directions(nurbs, closed);
                let period = |is_closed: bool, size: f64| is_closed.then_some(size);
                let size = high - low;
                ((period(u, size.x), [low.x, high.x]), (period(v, size.y), [low.y, high.y]))
            }
        };
        Self {
            surface,
            periods: [u.0, v.0],
            limits: [dvec2(u.1[0], v.1[0]), dvec2(u.1[1], v.1[1])],
            tolerance,
            accepted: Cell::new(10.0 * tolerance),
            samples: OnceCell::new(),
            poles: OnceCell::new(),
        }
    }

    /// The same sheet for searches that start near their points: they are never repeated from other places.
    pub(super) fn for_near_points(self) -> Self {
        self.accept(f64::INFINITY);
        self
    }

    /// The points where the surface is one point for all u or for all v.
    pub(super) fn poles(&self) -> &[DVec3] {
        self.poles.get_or_init(|| match self.surface {
            FaceSurface::Sphere { frame, radius } => {
                vec![frame.origin + *radius * frame.z, frame.origin - *radius * frame.z]
            }
            FaceSurface::Cone { frame, radius, half_angle } => {
                vec![frame.origin - radius / half_angle.tan() * frame.z]
            }
            FaceSurface::Revolution { curve, .. } => {
                let ends = curve.range.into_iter();
                let on_axis = ends.filter(|t| self.planar(*t)[0].x <= self.tolerance);
                on_axis.map(|t| curve.curve.at(t)[0]).collect()
            }
            FaceSurface::Nurbs(nurbs) => {
                let [low, high] = nurbs.domain();
                let corners = [low, dvec2(high.x, low.y), high, dvec2(low.x, high.y)];
                let sides = (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]);
                let at = |uv: DVec2| self.surface.at(uv.x, uv.y).position;
                let is_pole = |[from, to]: &[DVec2; 2]| {
                    let mut places = [0.2, 0.4, 0.7, 1.0].into_iter();
                    places.all(|t| at(from.lerp(*to, t)).distance(at(*from)) <= self.tolerance)
                };
                sides.filter(is_pole).map(|[from, _]| at(from)).collect()
            }
            _ => Vec::new(),
        })
    }

    /// Point and derivatives. Parameters may be periods off.
    pub(super) fn at(&self, uv: DVec2) -> SurfacePoint {
        let uv = self.wrapped(uv);
        self.surface.at(uv.x, uv.y)
    }

    /// Point and derivatives of the part of the surface that begins at (u, v) and lies in a direction from there. At a
    /// knot and where the surface closes, they depend on the side.
    pub(super) fn beside(&self, uv: DVec2, direction: DVec2) -> CurvedPoint {
        /// How far beside, as a share of the domain.
        const STEP: f64 = 1e-7;
        let size = DVec2::from([0, 1].map(|axis| {
            let between = self.limits[1][axis] - self.limits[0][axis];
            self.periods[axis].unwrap_or(if between.is_finite() { between } else { 1.0 })
        }));
        let place = uv + STEP * size * (direction / size).normalize_or_zero();
        let side = self.wrapped(place);
        self.surface.curved(uv + (side - place), side)
    }

    /// The parameters within the limits that stand for the same point.
    fn wrapped(&self, mut uv: DVec2) -> DVec2 {
        for axis in 0..2 {
            let [low, high] = self.limits.map(|limit| limit[axis]);
            if let (Some(period), true) = (self.periods[axis], low.is_finite())
                && !(low..=high).contains(&uv[axis])
            {
                uv[axis] -= period * ((uv[axis] - low) / period).floor();
            }
        }
        uv
    }

    /// The same parameters, whole periods off, as near as possible to others.
    pub(super) fn unwrapped(&self, mut uv: DVec2, near: DVec2) -> DVec2 {
        for axis in 0..2 {
            if let Some(period) = self.periods[axis] {
                uv[axis] += period * ((near[axis] - uv[axis]) / period).round();
            }
        }
        uv
    }

    /// The nearest parameters within the limits of directions that are not closed.
    fn clamped(&self, mut uv: DVec2) -> DVec2 {
        for axis in 0..2 {
            if self.periods[axis].is_none() {
                uv[axis] = uv[axis].clamp(self.limits[0][axis], self.limits[1][axis]);
            }
        }
        uv
    }

    /// Whether a change of u, or of v, by a period or between the limits moves the point by less than the tolerance.
    pub(super) fn singular(&self, point: &SurfacePoint) -> [bool; 2] {
        let size = |axis: usize| {
            let between = self.limits[1][axis] - self.limits[0][axis];
            self.periods[axis].unwrap_or(if between.is_finite() { between } else { 0.0 })
        };
        [(point.du, size(0)), (point.dv, size(1))]
            .map(|(slope, size)| size > 0.0 && slope.length() * size <= 10.0 * self.tolerance)
    }

    /// The parameters of the point of the surface that is nearest to a point in space; if `near` is given, the nearest
    /// one that can be reached from there.
    pub(super) fn nearest(&self, point: DVec3, near: Option<DVec2>) -> DVec2 {
        let found = match self.surface {
            FaceSurface::Plane(frame) => frame.local(point).truncate(),
            FaceSurface::Cylinder { frame, .. } => {
                let local = frame.local(point);
                dvec2(self.angle(local, near, false), local.z)
            }
            FaceSurface::Cone { frame, radius, half_angle } => {
                let local = frame.local(point);
                let (sin, cos) = half_angle.sin_cos();
                self.on_either_side(local, near, |rho| {
                    let v = (rho - radius) * sin + local.z * cos;
                    (v, (radius + v * sin - rho).hypot(v * cos - local.z))
                })
            }
            FaceSurface::Sphere { frame, .. } => {
                let local = frame.local(point);
                let v = local.z.atan2(local.truncate().length());
                dvec2(self.angle(local, near, false), v)
            }
            FaceSurface::Torus { frame, major_radius, minor_radius } => {
                let local = frame.local(point);
                self.on_either_side(local, near, |rho| {
                    let off = dvec2(rho - major_radius, local.z);
                    (off.y.atan2(off.x), (off.length() - minor_radius).abs())
                })
            }
            FaceSurface::Revolution { origin, axis, .. } => {
                let off = point - *origin;
                let along = off.dot(*axis);
                let target = dvec2((off - along * *axis).length(), along);
                let v = self.on_curve(target, near.map(|near| near.y));
                let start = self.surface.at(0.0, self.wrapped(dvec2(0.0, v)).y).position - *origin;
                let u = axis.dot(start.cross(off)).atan2(start.dot(off) - start.dot(*axis) * along);
                let is_on_axis = target.x <= 1e-3 * self.tolerance;
                dvec2(near.filter(|_| is_on_axis).map_or(u, |near| near.x), v)
            }
            FaceSurface::Extrusion { direction, curve } => {
                let [x, y] = across(*direction);
                let u = self.on_curve(dvec2(point.dot(x), point.dot(y)), near.map(|near| near.x));
                let on_curve = curve.curve.at(self.wrapped(dvec2(u, 0.0)).x)[0];
                dvec2(u, (point - on_curve).dot(*direction))
            }
            FaceSurface::Nurbs(nurbs) => self.on_nurbs(nurbs, point, near),
        };
        near.map_or(found, |near| self.unwrapped(found, near))
    }

    /// The angle u of a point in the frame, or that of its opposite. On the axis it is that of `near`.
    fn angle(&self, local: DVec3, near: Option<DVec2>, opposite: bool) -> f64 {
        if local.truncate().length() <= 1e-3 * self.tolerance {
            return near.map_or(0.0, |near| near.x);
        }
        let sign = if opposite { -1.0 } else { 1.0 };
        (sign * local.y).atan2(sign * local.x)
    }

    /// For surfaces that may lie on both sides of their axis: `of` gives v and the distance for a distance from the
    /// axis, which is below 0 on the other side.
    fn on_either_side(
        &self,
        local: DVec3,
        near: Option<DVec2>,
        of: impl Fn(f64) -> (f64, f64),
    ) -> DVec2 {
        let rho = local.truncate().length();
        let [here, there] = [of(rho), of(-rho)];
        let sides = [(here, false), (there, true)]
            .map(|((v, _), opposite)| dvec2(self.angle(local, near, opposite), v));
        let far = |uv: DVec2| near.map_or(0.0, |near| self.unwrapped(uv, near).distance(near));
        let is_there = if (here.1 - there.1).abs() <= self.tolerance {
            far(sides[1]) < far(sides[0])
        } else {
            there.1 < here.1
        };
        sides[usize::from(is_there)]
    }

    /// The curve that is turned or moved, in the half-plane of its distance from the axis and the place along it, or
    /// across the direction of movement: place and derivative.
    fn planar(&self, t: f64) -> [DVec2; 2] {
        match self.surface {
            FaceSurface::Revolution { origin, axis, curve } => {
                let [point, slope] = curve.curve.at(self.wrapped(dvec2(0.0, t)).y);
                let off = point - *origin;
                let along = off.dot(*axis);
                let from_axis = off - along * *axis;
                let rho = from_axis.length();
                let outwards = if rho > 0.0 { slope.dot(from_axis) / rho } else { slope.length() };
                [dvec2(rho, along), dvec2(outwards, slope.dot(*axis))]
            }
            FaceSurface::Extrusion { direction, curve } => {
                let [x, y] = across(*direction);
                let [point, slope] = curve.curve.at(self.wrapped(dvec2(t, 0.0)).x);
                [dvec2(point.dot(x), point.dot(y)), dvec2(slope.dot(x), slope.dot(y))]
            }
            _ => unreachable!("only these have a curve"),
        }
    }

    /// The parameter of that curve's point nearest to a target.
    fn on_curve(&self, target: DVec2, near: Option<f64>) -> f64 {
        let (axis, curve) = match self.surface {
            FaceSurface::Revolution { curve, .. } => (1, curve),
            FaceSurface::Extrusion { curve, .. } => (0, curve),
            _ => unreachable!("only these have a curve"),
        };
        let clamp = |t: f64| self.clamped(DVec2::splat(t))[axis];
        let newton = |mut t: f64| {
            let [mut here, mut slope] = self.planar(t);
            for _ in 0..30 {
                let mut step = (target - here).dot(slope) / slope.length_squared();
                if !step.is_finite() {
                    break;
                }
                let mut next = clamp(t + step);
                let mut there = self.planar(next);
                for _ in 0..8 {
                    if there[0].distance_squared(target) <= here.distance_squared(target) {
                        break;
                    }
                    step *= 0.25;
                    next = clamp(t + step);
                    there = self.planar(next);
                }
                let moved = (next - t).abs() * slope.length();
                (t, [here, slope]) = (next, there);
                if moved <= 1e-13 * target.abs().max_element().max(self.tolerance) {
                    break;
                }
            }
            (t, here.distance(target))
        };
        let mut best = near.map(newton);
        if best.is_none_or(|(_, distance)| distance > self.accepted.get()) {
            let samples = self.samples.get_or_init(|| {
                let places = places_of_curve(curve);
                let sample = |t: &f64| (DVec2::splat(*t), self.planar(*t)[0].extend(0.0));
                Samples { points: places.iter().map(sample).collect(), columns: places.len() }
            });
            for start in samples.starts(target.extend(0.0)) {
                let found = newton(start[axis]);
                if best.is_none_or(|best| found.1 < 0.5 * best.1) {
                    best = Some(found);
                }
            }
            self.accept(best.map_or(0.0, |best| best.1));
        }
        best.map_or(0.0, |best| best.0)
    }

    fn on_nurbs(&self, nurbs: &NurbsSurface, point: DVec3, near: Option<DVec2>) -> DVec2 {
        let mut best = near.map(|near| self.newton(point, self.clamped(near)));
        if best.is_none_or(|(_, distance)| distance > self.accepted.get()) {
            let samples = self.samples.get_or_init(|| {
                let [us, vs] = [0, 1].map(|axis| {
                    let degree = [nurbs.degree().u(), nurbs.degree().v()][axis];
                    places(&nurbs.knots()[axis], degree)
                });
                let place = |v: f64| us.iter().map(move |u| dvec2(*u, v));
                let all = vs.iter().flat_map(|v| place(*v));
                let sample = |uv: DVec2| (uv, self.surface.at(uv.x, uv.y).position);
                Samples { points: all.map(sample).collect(), columns: us.len() }
            });
            for start in samples.starts(point) {
                let found = self.newton(point, start);
                if best.is_none_or(|best| found.1 < 0.5 * best.1) {
                    best = Some(found);
                }
            }
            self.accept(best.map_or(0.0, |best| best.1));
        }
        best.map_or(self.limits[0], |best| best.0)
    }

    /// Searches everywhere do not find a nearer point than this.
    fn accept(&self, distance: f64) {
        self.accepted.set(self.accepted.get().max(2.0 * distance));
    }

    /// The nearest point by the Gauss–Newton method with damping: its parameters and the distance.
    fn newton(&self, point: DVec3, mut uv: DVec2) -> (DVec2, f64) {
        /// The longest step, as a share of the domain.
        const LONGEST: f64 = 0.2;
        let mut here = self.at(uv);
        let mut off = point - here.position;
        let mut damping = 0.0;
        let rounding = 1e-14 * point.abs().max_element().max(self.tolerance);
        let size = self.limits[1] - self.limits[0];
        for _ in 0..40 {
            let (mut step, _) = solve(&here, off, damping);
            // Where a derivative is almost 0, steps are long.
            step = step.clamp(-LONGEST * size, LONGEST * size);
            let mut next = self.clamped(uv + step);
            // Along a border the other parameter has a minimum of its own.
            for axis in 0..2 {
                if next[axis] != uv[axis] + step[axis] {
                    let slope = [here.dv, here.du][axis];
                    let rest = off - [here.du, here.dv][axis] * (next[axis] - uv[axis]);
                    let along = rest.dot(slope) / slope.length_squared() / (1.0 + damping);
                    if along.is_finite() {
                        next[1 - axis] = uv[1 - axis] + along;
                    }
                }
            }
            next = self.clamped(next);
            let there = self.at(next);
            let off_there = point - there.position;
            let moved = (here.du * (next.x - uv.x)).length() + (here.dv * (next.y - uv.y)).length();
            if off_there.length() > off.length() {
                if moved <= 1e3 * rounding || damping > 1e6 {
                    break;
                }
                damping = (10.0 * damping).max(1e-2);
                continue;
            }
            damping = if damping < 1e-3 { 0.0 } else { 0.1 * damping };
            (uv, here, off) = (next, there, off_there);
            if moved <= rounding {
                break;
            }
        }
        (uv, off.length())
    }
}

/// The change of (u, v) that moves a point of a surface by `off` as nearly as it can, and whether it is the only one.
pub(super) fn solve(at: &SurfacePoint, off: DVec3, damping: f64) -> (DVec2, bool) {
    let [a, b, c] = [at.du.length_squared(), at.du.dot(at.dv), at.dv.length_squared()];
    let [e, f] = [at.du.dot(off), at.dv.dot(off)];
    let (a, c) = (a * (1.0 + damping), c * (1.0 + damping));
    let determinant = a * c - b * b;
    if determinant > 1e-20 * a * c {
        let step = dvec2(e * c - b * f, a * f - b * e) / determinant;
        return (step, true);
    }
    // Along the larger of two parallel derivatives.
    let along = |of: f64, slope: f64| if slope > 0.0 { of / slope } else { 0.0 };
    let step = if a > c { dvec2(along(e, a), 0.0) } else { dvec2(0.0, along(f, c)) };
    (step, false)
}

/// Two directions across another one.
fn across(direction: DVec3) -> [DVec3; 2] {
    let x = direction.any_orthonormal_vector();
    [x, direction.cross(x)]
}

impl Samples {
    /// The samples that are nearer to a point than those beside them, the nearest ones first.
    fn starts(&self, point: DVec3) -> Vec<DVec2> {
        /// More than the sheets of a surface that come near each other.
        const MAX_STARTS: usize = 8;
        let (columns, count) = (self.columns, self.points.len());
        let distances: Vec<f64> =
            self.points.iter().map(|(_, sample)| sample.distance_squared(point)).collect();
        let mut starts: Vec<usize> = (0..count)
            .filter(|i| {
                let (column, own) = (i % columns, distances[*i]);
                (column == 0 || own <= distances[i - 1])
                    && (column + 1 == columns || own <= distances[i + 1])
                    && (*i < columns || own <= distances[i - columns])
                    && (i + columns >= count || own <= distances[i + columns])
            })
            .collect();
        starts.sort_by(|a, b| distances[*a].total_cmp(&distances[*b]));
        starts.truncate(MAX_STARTS);
        starts.into_iter().map(|i| self.points[i].0).collect()
    }
}

/// Parameters in every span of a knot vector.
fn places(knots: &[f64], degree: usize) -> Vec<f64> {
    let mut ends = knots[degree..knots.len() - degree].to_vec();
    ends.dedup();
    let spans = ends.len() - 1;
    let each = MIN_SAMPLES.div_ceil(spans).max(degree).min((MAX_SAMPLES / spans).max(1));
    let within = |i: usize, pair: &[f64]| pair[0] + (pair[1] - pair[0]) * i as f64 / each as f64;
    let inside = ends.windows(2).flat_map(|pair| (0..each).map(move |i| within(i, pair)));
    inside.chain([ends[spans]]).collect()
}

fn places_of_curve(curve: &BoundedCurve) -> Vec<f64> {
    let [low, high] = curve.range;
    let even = |low: f64, high: f64| {
        (0..=MIN_SAMPLES).map(move |i| low + (high - low) * i as f64 / MIN_SAMPLES as f64).collect()
    };
    match &curve.curve {
        Curve::Line { .. } => even(low, high),
        Curve::Circle { .. } | Curve::Ellipse { .. } => even(low, low + TAU),
        Curve::Nurbs(nurbs) => places(nurbs.knots(), nurbs.degree()),
    }
}

/// Whether opposite borders of a surface are the same, along u and along v.
fn closed_directions(nurbs: &NurbsSurface, tolerance: f64) -> [bool; 2] {
    const PLACES: usize = 17;
    let [low, high] = nurbs.domain();
    let [least, largest] = bounding_box(nurbs.control_points().iter().map(|p| p.truncate()));
    let tolerance = tolerance.min(1e-3 * least.distance(largest));
    let same = |a: DVec2, b: DVec2| {
        let at = |uv: DVec2| super::evaluate::nurbs_at(nurbs, uv.x, uv.y).position;
        at(a).distance(at(b)) <= tolerance
    };
    let share = |i: usize| i as f64 / (PLACES - 1) as f64;
    let size = high - low;
    [
        (0..PLACES).all(|i| {
            let v = low.y + share(i) * size.y;
            same(dvec2(low.x, v), dvec2(high.x, v))
        }),
        (0..PLACES).all(|i| {
            let u = low.x + share(i) * size.x;
            same(dvec2(u, low.y), dvec2(u, high.y))
        }),
    ]
}

#[cfg(test)]
mod tests;
