//! Edges as lines and cubics in the parameters of the drawn surface.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use super::chart::{Axis, Profile};
use super::joints::JointCurve as _;
use super::projection::{Trace, TracedCurve};
use super::{Curve, FaceSurface, Frame};
use crate::trim::{Segment, TrimCurve};

/// How accurate fitted curves are.
#[derive(Clone, Copy)]
pub(super) struct Accuracy {
    /// The largest distance in space.
    pub(super) in_space: f64,
    /// The largest distance in the drawn parameters, where that in space is larger.
    pub(super) in_domain: DVec2,
}

/// The part of the accuracy that may be used, because distances are known at samples only.
const SAFETY: f64 = 0.5;
const MAX_HALVINGS: u32 = 14;
/// An edge of more segments is taken as it is: its projection is rough.
const MAX_SEGMENTS: usize = 2000;
/// So many arcs of a circle are within every distance that a file can ask for.
const MAX_ARCS: u32 = 1000;

/// A place on an edge in drawn parameters.
#[derive(Clone, Copy)]
struct Place {
    t: f64,
    at: DVec2,
    slope: DVec2,
    /// Lengths in space of the derivatives of the drawn surface.
    scale: DVec2,
}

/// An edge with the parameters of the drawn surface.
pub(super) struct Fit<'a> {
    pub(super) trace: &'a Trace<'a>,
    /// Added to the edge's parameters: whole periods.
    pub(super) shift: DVec2,
    pub(super) axes: [Axis; 2],
    pub(super) accuracy: Accuracy,
    /// Values of u and of v where the drawn surface is less smooth.
    pub(super) breaks: &'a [Vec<f64>; 2],
}

/// Segments of an edge.
#[derive(Default)]
pub(super) struct Fitted {
    pub(super) segments: Vec<Segment>,
    /// Whether some of them are further from the edge than the accuracy allows.
    pub(super) is_rough: bool,
}

impl From<Vec<Segment>> for Fitted {
    fn from(segments: Vec<Segment>) -> Self {
        Self { segments, is_rough: false }
    }
}

impl Fit<'_> {
    /// The segments of the edge, from its start to its end.
    pub(super) fn segments(&self) -> Fitted {
        /// Exact curves of more segments are fitted too.
        const MANY: usize = 4;
        if let Some(arcs) = self.arcs() {
            return arcs.into();
        }
        let exact = self.exact();
        if let Some(segments) = exact.as_ref().filter(|segments| segments.len() == 1) {
            return segments.clone().into();
        }
        let [first, last] = self.trace.range;
        let ends = [self.place(first), self.place(last)];
        let between = || self.trace.samples.iter().map(|(t, _)| *t);
        let middles = self.trace.samples.windows(2).map(|pair| pair[0].0.midpoint(pair[1].0));
        let mut all = between().chain(middles).filter(|t| first < *t && *t < last);
        if all.all(|t| self.is_on_line(ends, &self.place(t))) {
            return vec![Segment::Line(ends.map(|end| end.at))].into();
        }
        match exact {
            Some(segments) if segments.len() <= MANY => segments.into(),
            Some(segments) => {
                let fitted = self.fitted(ends);
                let is_better = !fitted.is_rough && fitted.segments.len() < segments.len();
                if is_better { fitted } else { segments.into() }
            }
            None => self.fitted(ends),
        }
    }

    fn fitted(&self, ends: [Place; 2]) -> Fitted {
        let [first, last] = self.trace.range;
        let mut breaks = self.trace.breaks();
        for axis in 0..2 {
            for value in &self.breaks[axis] {
                self.trace.crossings(axis, value - self.shift[axis], &mut breaks);
            }
        }
        breaks.retain(|t| first < *t && *t < last);
        breaks.push(last);
        breaks.sort_by(f64::total_cmp);
        let shortest = 1e-9 * (last - first);
        let mut fitted = Fitted::default();
        let mut from = ends[0];
        for (i, t) in breaks.iter().enumerate() {
            let is_last = i + 1 == breaks.len();
            if !is_last && (*t - from.t < shortest || last - *t < shortest) {
                continue;
            }
            let to = if is_last { ends[1] } else { self.place(*t) };
            self.add(from, to, 0, &mut fitted);
            from = to;
        }
        fitted
    }

    /// Circles and ellipses on planes: of all cubics of arcs, the fewest that are near enough.
    fn arcs(&self) -> Option<Vec<Segment>> {
        let (TracedCurve::Edge(edge), FaceSurface::Plane(frame)) =
            (self.trace.curve, self.trace.sheet.surface)
        else {
            return None;
        };
        let radius = match edge.curve {
            Curve::Circle { radius, .. } => radius,
            Curve::Ellipse { radii, .. } => radii[0].max(radii[1]),
            _ => return None,
        };
        if self.axes != [Axis::Same; 2] {
            return None;
        }
        let [first, last] = self.trace.range;
        let count = f64::from(arcs_within(last - first, self.accuracy.in_space / radius)?);
        let at = |i: f64| first + i / count * (last - first);
        let arc = |i: u32| {
            let points = edge.cubic(at(i.into()), at(f64::from(i) + 1.0));
            Segment::Cubic(points.map(|point| frame.local(point).truncate() + self.shift))
        };
        Some((0..count as u32).map(arc).collect())
    }

    /// Curves that need no fit: p-curves whose parameters are those of the drawn surface, and edges of planes.
    fn exact(&self) -> Option<Vec<Segment>> {
        if self.axes != [Axis::Same; 2] {
            return None;
        }
        let curve = match (self.trace.curve, self.trace.sheet.surface) {
            (TracedCurve::Pcurve(curve), _) => {
                let shift = self.shift.extend(0.0);
                let points: Vec<_> = curve.control_points().iter().map(|p| *p + shift).collect();
                TrimCurve::nurbs(curve.degree(), curve.knots(), &points)
            }
            (TracedCurve::Edge(edge), FaceSurface::Plane(frame)) => {
                let profile = Profile::of(edge);
                let flat = |frame: &Frame, point: &glam::DVec4| {
                    frame.local(point.truncate()).truncate().extend(point.w)
                };
                let points: Vec<_> = profile.points.iter().map(|p| flat(frame, p)).collect();
                TrimCurve::nurbs_part(profile.degree, &profile.knots, &points, edge.range)
            }
            _ => return None,
        };
        let mut segments = Vec::new();
        curve.ok()?.segments(self.accuracy.in_domain * 1e8, &mut segments);
        Some(segments)
    }

    fn place(&self, t: f64) -> Place {
        let traced = self.trace.at(t);
        let uv = traced.uv + self.shift;
        let [[x, dx], [y, dy]] = [self.axes[0].drawn(uv.x), self.axes[1].drawn(uv.y)];
        let by = DVec2::new(dx, dy);
        Place { t, at: DVec2::new(x, y), slope: traced.slope * by, scale: traced.scale / by }
    }

    /// How far a point is from a place, as a share of what is allowed.
    fn excess(&self, place: &Place, off: DVec2) -> f64 {
        let in_space = (off.abs() * place.scale).element_sum() / self.accuracy.in_space;
        let in_domain = (off.abs() / self.accuracy.in_domain).max_element();
        in_space.min(in_domain) / SAFETY
    }

    fn is_on_line(&self, [from, to]: [Place; 2], place: &Place) -> bool {
        let scale = place.scale.max(DVec2::splat(1e-3 * place.scale.max_element()));
        let (along, off) = ((to.at - from.at) * scale, (place.at - from.at) * scale);
        let share = off.dot(along) / along.length_squared();
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
        self.excess(place, (off - share * along) / scale) <= 1.0
    }

    /// Appends the segments between two places.
    fn add(&self, from: Place, to: Place, halvings: u32, all: &mut Fitted) {
        let at = |share: f64| self.place(from.t + share * (to.t - from.t));
        let thirds = [at(1.0 / 3.0), at(2.0 / 3.0)];
        let middle = at(0.5);
        let is_line = |place: &Place| self.is_on_line([from, to], place);
        if is_line(&middle) && thirds.iter().all(is_line) && is_line(&at(0.2)) && is_line(&at(0.8))
        {
            all.segments.push(Segment::Line([from.at, to.at]));
            return;
        }
        let is_near = |cubic: &[DVec2; 4], place: &Place, share: f64| {
            let off = place.at - nearest(cubic, place, share);
            self.excess(place, off) <= 1.0
        };
        let cubic = through(&from, &thirds, &to);
        let candidates = [fitted(&from, &thirds, &to), Some(cubic)];
        let found = candidates.into_iter().flatten().find(|cubic| {
            is_near(cubic, &middle, 0.5)
                && is_near(cubic, &thirds[0], 1.0 / 3.0)
                && is_near(cubic, &thirds[1], 2.0 / 3.0)
                && [0.12, 0.24, 0.76, 0.88].into_iter().all(|by| is_near(cubic, &at(by), by))
        });
        if let Some(cubic) = found {
            all.segments.push(Segment::Cubic(cubic));
        } else if halvings >= MAX_HALVINGS || all.segments.len() > MAX_SEGMENTS {
            all.segments.push(Segment::Cubic(cubic));
            all.is_rough = true;
        } else {
            self.add(from, middle, halvings + 1, all);
            self.add(middle, to, halvings + 1, all);
        }
    }
}

/// The least number of equal arcs of a unit circle whose cubics are within a distance of them.
///
/// The square of the distance of such a cubic from the middle exceeds 1 by at most 4/27 sin⁶(a/4) / cos²(a/4) for an arc
/// of the angle a: Dokken and others, *Good approximation of circles by curvature-continuous Bézier curves*, 1990. A
/// distance from an ellipse is at most the longer radius times that.
fn arcs_within(angle: f64, distance: f64) -> Option<u32> {
    let is_within = |count: &u32| {
        let (sine, cosine) = (0.25 * angle / f64::from(*count)).sin_cos();
        2.0 / 27.0 * sine.powi(6) <= distance * cosine * cosine
    };
    let least = (angle / FRAC_PI_2).ceil().max(1.0) as u32;
    (least..least + MAX_ARCS).find(is_within)
}

/// The point of a cubic nearest to a place, in space, from a parameter nearby.
fn nearest(cubic: &[DVec2; 4], place: &Place, share: f64) -> DVec2 {
    let scale = place.scale.max(DVec2::splat(1e-3 * place.scale.max_element()));
    let mut t = share;
    for _ in 0..3 {
        let [at, slope] = with_slope(cubic, t);
        let (off, slope) = ((place.at - at) * scale, slope * scale);
        let step = off.dot(slope) / slope.length_squared();
        if !step.is_finite() {
            break;
        }
        t = (t + step).clamp(0.0, 1.0);
    }
    with_slope(cubic, t)[0]
}

fn with_slope([a, b, c, d]: &[DVec2; 4], t: f64) -> [DVec2; 2] {
    let s = 1.0 - t;
    let (ab, bc, cd) = (s * *a + t * *b, s * *b + t * *c, s * *c + t * *d);
    let (abc, bcd) = (s * ab + t * bc, s * bc + t * cd);
    [s * abc + t * bcd, 3.0 * (bcd - abc)]
}

/// The cubic through four places at equal distances of the parameter.
fn through(from: &Place, [a, b]: &[Place; 2], to: &Place) -> [DVec2; 4] {
    let first = (-5.0 * from.at + 18.0 * a.at - 9.0 * b.at + 2.0 * to.at) / 6.0;
    let second = (2.0 * from.at - 9.0 * a.at + 18.0 * b.at - 5.0 * to.at) / 6.0;
    [from.at, first, second, to.at]
}

/// The cubic with the directions of the edge at its ends that goes through two places between them.
fn fitted(from: &Place, thirds: &[Place; 2], to: &Place) -> Option<[DVec2; 4]> {
    // Lengths in space, so that directions compare.
    let scale = thirds[0].scale.max(thirds[1].scale);
    let scale = scale.max(DVec2::splat(1e-6 * scale.max_element()));
    let place = |place: &Place| place.at * scale;
    let length = to.t - from.t;
    let [start, end] = [place(from), place(to)];
    let [at_start, at_end] = [from.slope * scale * length, to.slope * scale * length];
    let mut by = [1.0, 1.0];
    let cubic =
        |by: [f64; 2]| [start, start + by[0] / 3.0 * at_start, end - by[1] / 3.0 * at_end, end];
    let mut on_cubic = [1.0 / 3.0, 2.0 / 3.0];
    for _ in 0..5 {
        let fit = cubic(by);
        let mut rows = [[0.0; 3]; 2];
        for k in 0..2 {
            let target = place(&thirds[k]);
            for _ in 0..2 {
                let [at, slope] = with_slope(&fit, on_cubic[k]);
                let step = (target - at).dot(slope) / slope.length_squared();
                on_cubic[k] = (on_cubic[k] + step).clamp(0.0, 1.0);
            }
            let [at, slope] = with_slope(&fit, on_cubic[k]);
            let normal = slope.try_normalize()?.perp();
            let (t, s) = (on_cubic[k], 1.0 - on_cubic[k]);
            rows[k] = [
                s * s * t * normal.dot(at_start),
                -s * t * t * normal.dot(at_end),
                normal.dot(target - at),
            ];
        }
        let [[a, b, c], [d, e, f]] = rows;
        let determinant = a * e - b * d;
        let change = [(c * e - b * f) / determinant, (a * f - c * d) / determinant];
        by = [by[0] + change[0], by[1] + change[1]];
        if !by.iter().all(|by| (0.2..5.0).contains(by)) {
            return None;
        }
    }
    Some(cubic(by).map(|point| point / scale))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::model::BoundedCurve;

    #[test]
    fn arcs_are_as_few_as_their_distance_from_the_circle_allows() {
        let frame = Frame { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
        let curve = Curve::Circle { frame, radius: 1.0 };
        for angle in [0.3, 1.0, FRAC_PI_2, 4.0, 2.0 * std::f64::consts::PI] {
            let edge = BoundedCurve { curve: curve.clone(), range: [0.0, angle] };
            let off = |count: u32| {
                let cubic = edge.cubic(0.0, angle / f64::from(count)).map(DVec3::truncate);
                let radius = |i: u32| with_slope(&cubic, f64::from(i) / 600.0)[0].length();
                (0..=600).map(|i| (radius(i) - 1.0).abs()).fold(0.0, f64::max)
            };
            for distance in [1e-3, 1e-5, 1e-7, 1e-9] {
                let count = arcs_within(angle, distance).unwrap();
                assert!(off(count) <= distance, "{count} arcs of {angle} within {distance}");
                let is_least =
                    angle / f64::from(count - 1) > FRAC_PI_2 || off(count - 1) > distance;
                assert!(count == 1 || is_least, "{count} arcs of {angle} within {distance}");
            }
        }
    }
}
