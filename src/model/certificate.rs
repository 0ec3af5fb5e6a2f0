//! How far the edges of drawn faces are from their curves at most, at every place.
//!
//! On a stretch where the drawn surface and the curve are one rational piece each, the drawn edge is S(c(s)) = A / w and
//! the curve is E(τ(s)) = B / v, with polynomials A, w, B and v of s. Here c is a segment of the trims, and τ is any
//! polynomial that stays within the piece of E. The difference is N / (w v) with N = A v − B w, a polynomial of degree
//! n ≤ deg c · (p + q) + deg τ · d. On an interval, a polynomial of degree n is nowhere larger than at m > n Chebyshev
//! nodes, divided by cos(π n / 2m) (Ehlich and Zeller, *Schwankung von Polynomen zwischen Gitterpunkten*, 1964). That
//! holds in every direction, so for the length of N too; applied to w v less its middle, it gives the least weight.
//!
//! τ goes through parameters of nearest points. From stretch to stretch it is continuous, and it begins and ends where
//! the curve does, so no place of the curve is further from the drawn edge either. A stretch whose bound is much above
//! the distances at samples is halved. What rounding may add in `f64` is estimated and added.

use std::cell::Cell;
use std::f64::consts::PI;

use glam::{DVec2, DVec3, DVec4};

use super::chart::{Axis, Profile};
use super::evaluate::Basis;
use super::projection::nearest_on;
use super::{BoundedCurve, Curve, DrawnEdge, DrawnFace, Model};
use crate::bezier::{NurbsSurface, span_of};
use crate::trim::Segment;

/// A distance in space that no place of an edge of a face exceeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CertifiedDeviation {
    /// The number of the edge.
    pub edge: usize,
    /// The drawn edge is nowhere further from its curve, nor the curve from the drawn edge. `None` if no bound was
    /// found: where weights vanish, or where a segment winds around a knot of the surface.
    pub drawn: Option<f64>,
}

/// The degree of τ.
const DEGREE: usize = 5;
/// Nodes for each degree of a polynomial: the bound is at most 1.035 times as large as the polynomial.
const NODES: usize = 6;
/// A bound is small enough if it is no larger than this many times the largest distance at samples.
const ENOUGH: f64 = 1.1;
/// Bounds below this share of the diagonal are small enough.
const SMALL: f64 = 1e-9;
/// How far a segment may reach over a knot, as a share of the span; what this may add to the distance is added.
const OVERRUN: f64 = 1e-3;
const MAX_HALVINGS: u32 = 14;
/// Places along a segment between two knots of the surface from which parameters of the curve are found.
const STEPS: u32 = 8;
/// Places along a curve where searches for the nearest one begin.
const SAMPLES: u32 = 200;

impl Model {
    /// Bounds of how far the edges of a face are from their curves, at every place. Edges that are a point are left
    /// out. `diagonal` is [`Model::diagonal`].
    ///
    /// # Panics
    /// If the drawn face is not of this model.
    #[must_use]
    pub fn certified_deviations(
        &self,
        drawn: &DrawnFace,
        diagonal: f64,
    ) -> Vec<CertifiedDeviation> {
        let of = |edge: &DrawnEdge| {
            let curve = self.edges[edge.edge].curve.as_ref()?;
            let found = Comparison::new(drawn, edge, curve, diagonal).bound();
            Some(CertifiedDeviation { edge: edge.edge, drawn: found })
        };
        drawn.edges.iter().filter_map(of).collect()
    }
}

/// An edge of a face beside its curve.
struct Comparison<'a> {
    face: &'a DrawnFace,
    edge: &'a DrawnEdge,
    curve: &'a BoundedCurve,
    /// The curve as a rational B-spline, with homogeneous control points.
    degree: usize,
    knots: Vec<f64>,
    points: Vec<DVec4>,
    /// How its parameters follow from those of the curve.
    axis: Axis,
    /// Where its pieces end.
    ends: Vec<f64>,
    samples: Vec<(f64, DVec3)>,
    small: f64,
    /// The largest distance of a place of the edge from the curve that is known.
    largest: Cell<f64>,
}

/// A place of a segment, and a parameter of the curve.
#[derive(Debug, Clone, Copy)]
struct Place {
    s: f64,
    t: f64,
}

impl<'a> Comparison<'a> {
    fn new(
        face: &'a DrawnFace,
        edge: &'a DrawnEdge,
        curve: &'a BoundedCurve,
        diagonal: f64,
    ) -> Self {
        let Profile { degree, knots, points } = Profile::of(curve);
        let points = points.into_iter().map(|p| (p.truncate() * p.w).extend(p.w)).collect();
        let [low, high] = curve.range;
        let axis = match curve.curve {
            Curve::Circle { .. } | Curve::Ellipse { .. } => Axis::arcs(curve.range),
            Curve::Line { .. } | Curve::Nurbs(_) => Axis::Same,
        };
        let inside = knots.iter().copied().filter(|t| low < *t && *t < high);
        let mut ends: Vec<f64> = [low].into_iter().chain(inside).chain([high]).collect();
        ends.dedup();
        let share = |i: u32| f64::from(i) / f64::from(SAMPLES);
        let samples = (0..=SAMPLES).map(|i| low * (1.0 - share(i)) + high * share(i));
        let samples = samples.map(|t| (t, curve.curve.at(t)[0])).collect();
        let (small, largest) = (SMALL * diagonal, Cell::new(0.0));
        Self { face, edge, curve, degree, knots, points, axis, ends, samples, small, largest }
    }

    /// The nearest parameter of the curve. `near` goes before others that are hardly nearer: a closed curve ends where
    /// it begins.
    fn nearest(&self, point: DVec3, near: f64) -> f64 {
        let found = nearest_on(self.curve, point, near);
        let distance = |(_, sample): &&(f64, DVec3)| sample.distance_squared(point);
        let closest = self.samples.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let other = nearest_on(self.curve, point, closest.map_or(near, |(t, _)| *t));
        let (t, distance) = if other.1 < found.1 - self.small { other } else { found };
        self.note(distance);
        t
    }

    /// The nearest parameter of the curve that can be reached from one near it.
    fn nearest_from(&self, point: DVec3, near: f64) -> f64 {
        let (t, distance) = nearest_on(self.curve, point, near);
        self.note(distance);
        t
    }

    fn note(&self, distance: f64) {
        self.largest.set(self.largest.get().max(distance));
    }

    /// Whether a bound is small enough.
    fn is_enough(&self, bound: f64) -> bool {
        bound <= self.small.max(ENOUGH * self.largest.get())
    }

    fn bound(&self) -> Option<f64> {
        let [first, last] = self.curve.range;
        let [start, end] = if self.edge.forward { [first, last] } else { [last, first] };
        let mut t = start;
        let mut stretches = Vec::new();
        for (i, segment) in self.edge.segments.iter().enumerate() {
            let is_last = i + 1 == self.edge.segments.len();
            let mut places = self.places(segment, t, is_last.then_some(end));
            self.add_ends(segment, &mut places);
            stretches.extend(places.windows(2).map(|pair| (segment, [pair[0], pair[1]])));
            t = places.last().map_or(t, |place| place.t);
        }
        let mut bounds = stretches.iter().map(|(segment, pair)| self.stretch(segment, *pair, 0));
        bounds.try_fold(0.0, |largest: f64, bound| Some(largest.max(bound?)))
    }

    /// The ends of a segment and the places where it crosses knots of the surface. `end` is the parameter of the curve
    /// at the end, if it is known.
    fn places(&self, segment: &Segment, start: f64, end: Option<f64>) -> Vec<Place> {
        let mut breaks = vec![0.0];
        for axis in 0..2 {
            crossings(self.face, segment, axis, &mut breaks);
        }
        breaks.push(1.0);
        breaks.sort_by(f64::total_cmp);
        let mut t = start;
        let mut places = vec![Place { s: 0.0, t }];
        for pair in breaks.windows(2).filter(|pair| pair[0] < pair[1]) {
            for i in 1..=STEPS {
                let s = pair[0] + f64::from(i) / f64::from(STEPS) * (pair[1] - pair[0]);
                t = self.nearest(self.point(segment, s), t);
            }
            places.push(Place { s: pair[1], t });
        }
        if let (Some(place), Some(end)) = (places.last_mut(), end) {
            place.t = end;
        }
        places
    }

    /// Adds the places where the curve goes on to its next piece.
    fn add_ends(&self, segment: &Segment, places: &mut Vec<Place>) {
        let inside = &self.ends[1..self.ends.len() - 1];
        let mut all = Vec::with_capacity(places.len());
        for pair in places.windows(2) {
            let mut from = pair[0];
            all.push(from);
            let [low, high] = [from.t.min(pair[1].t), from.t.max(pair[1].t)];
            let mut between: Vec<f64> =
                inside.iter().copied().filter(|end| low < *end && *end < high).collect();
            if pair[1].t < from.t {
                between.reverse();
            }
            for end in between {
                from = self.crossing(segment, from, pair[1], end);
                all.push(from);
            }
        }
        all.extend(places.last());
        *places = all;
    }

    /// The place where the nearest parameter of the curve has a value, about; any place would do.
    fn crossing(&self, segment: &Segment, mut low: Place, mut high: Place, t: f64) -> Place {
        let accuracy = 1e-11 * (self.curve.range[1] - self.curve.range[0]);
        for i in 0..40 {
            let share = (t - low.t) / (high.t - low.t);
            let share = if i % 3 == 2 || !share.is_finite() { 0.5 } else { share.clamp(0.0, 1.0) };
            let s = low.s + share * (high.s - low.s);
            let near = low.t + share * (high.t - low.t);
            let found = self.nearest_from(self.point(segment, s), near);
            if (found - t).abs() <= accuracy {
                return Place { s, t };
            }
            let is_low = (found < t) == (low.t < high.t);
            *if is_low { &mut low } else { &mut high } = Place { s, t: found };
        }
        Place { s: low.s.midpoint(high.s), t }
    }

    fn point(&self, segment: &Segment, s: f64) -> DVec3 {
        self.face.point(segment.point(s))
    }

    /// A bound on a stretch of a segment, which is halved if the bound is not small enough.
    fn stretch(&self, segment: &Segment, [from, to]: [Place; 2], halvings: u32) -> Option<f64> {
        let found = self.whole(segment, [from, to]);
        if found.is_some_and(|bound| self.is_enough(bound)) || halvings == MAX_HALVINGS {
            return found;
        }
        let s = from.s.midpoint(to.s);
        let t = self.nearest(self.point(segment, s), from.t.midpoint(to.t));
        // Within the piece of the curve.
        let middle = Place { s, t: t.clamp(from.t.min(to.t), from.t.max(to.t)) };
        let first = self.stretch(segment, [from, middle], halvings + 1)?;
        Some(first.max(self.stretch(segment, [middle, to], halvings + 1)?))
    }

    /// A bound on a stretch, as it is.
    fn whole(&self, segment: &Segment, [from, to]: [Place; 2]) -> Option<f64> {
        let surface = &self.face.surface;
        let degrees = [surface.degree().u(), surface.degree().v()];
        let middle = segment.point(from.s.midpoint(to.s));
        let shift = self.face.periods_into_domain(middle);
        let spans = [0, 1]
            .map(|axis| span_of(degrees[axis], &surface.knots()[axis], (middle + shift)[axis]));
        let [low, high] = surface.domain();
        let at = middle + shift;
        // Beyond the domain, places stand for the nearest ones on its border.
        let [is_below, is_above] = [at.cmplt(low), at.cmpgt(high)];
        let knot =
            |end: usize| DVec2::from([0, 1].map(|axis| surface.knots()[axis][spans[axis] + end]));
        let size = knot(1) - knot(0);
        let least = DVec2::select(is_above, high, knot(0));
        let least = DVec2::select(is_below, DVec2::NEG_INFINITY, least);
        let most = DVec2::select(is_below, low, knot(1));
        let most = DVec2::select(is_above, DVec2::INFINITY, most);
        let controls = part(segment, [from.s, to.s]).map(|control| control + shift);
        let overrun = controls.map(|at| (least - at).max(at - most)).fold(DVec2::ZERO, DVec2::max);
        if (overrun / size).max_element() > OVERRUN {
            return None;
        }
        let own = self.axis.drawn(from.t.midpoint(to.t))[0];
        let span = span_of(self.degree, &self.knots, own);
        let along = self.along(segment, [from, to], span);
        let n = (segment.points().len() - 1) * (degrees[0] + degrees[1]) + DEGREE * self.degree;
        let count = NODES * n;
        let by = (0.5 * PI / NODES as f64).cos();
        let (mut numerator, mut size): (f64, f64) = (0.0, 0.0);
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..count {
            let share = 0.5 + 0.5 * ((i as f64 + 0.5) * PI / count as f64).cos();
            let uv = segment.point(from.s + share * (to.s - from.s)) + shift;
            let uv = DVec2::select(is_below | is_above, uv.clamp(low, high), uv);
            let on_surface = homogeneous(surface, spans, uv);
            let basis = Basis::in_span(self.degree, &self.knots, span, bernstein(&along, share));
            let on_curve = self.points[basis.first..][..=self.degree].iter();
            let on_curve: DVec4 = on_curve.zip(basis.values).map(|(point, b)| *point * b).sum();
            let weight = on_surface.w * on_curve.w;
            let [a, b] = [on_surface, on_curve].map(|point| point.truncate() / point.w);
            numerator = numerator.max(a.distance(b) * weight.abs());
            size = size.max(a.abs().max_element() + b.abs().max_element());
            (least, greatest) = (least.min(weight), greatest.max(weight));
        }
        let weight = least.midpoint(greatest) - 0.5 * (greatest - least) / by;
        let rounding = (8 * (degrees[0] + degrees[1] + self.degree)) as f64 * f64::EPSILON * size;
        let beyond: f64 = (0..2)
            .filter(|axis| overrun[*axis] > 0.0)
            .map(|axis| overrun[axis] * 2.0 * steepest(surface, axis, spans))
            .sum();
        let bound = numerator / by / weight + rounding + beyond;
        (weight > 0.0 && bound.is_finite()).then_some(bound)
    }

    /// τ on a stretch: Bernstein coefficients within the piece of the curve.
    fn along(&self, segment: &Segment, [from, to]: [Place; 2], span: usize) -> [f64; DEGREE + 1] {
        let mut values = [from.t, 0.0, 0.0, 0.0, 0.0, to.t];
        for (i, value) in values.iter_mut().enumerate().take(DEGREE).skip(1) {
            let share = i as f64 / DEGREE as f64;
            let point = self.point(segment, from.s + share * (to.s - from.s));
            *value = self.nearest_from(point, from.t + share * (to.t - from.t));
        }
        let values = values.map(|t| self.axis.drawn(t)[0]);
        let [first, last] = self.curve.range;
        let [low, high] = [self.knots[span].max(first), self.knots[span + 1].min(last)];
        // Relative to the first one, so that few digits are lost.
        let off = values.map(|value| value - values[0]);
        let row = |row: [f64; 6]| std::iter::zip(row, off).map(|(a, b)| a * b).sum::<f64>();
        let inner = [
            row([-77.0, 300.0, -300.0, 200.0, -75.0, 12.0]) / 60.0,
            row([269.0, -1450.0, 2950.0, -2300.0, 925.0, -154.0]) / 240.0,
            row([-154.0, 925.0, -2300.0, 2950.0, -1450.0, 269.0]) / 240.0,
            row([12.0, -75.0, 200.0, -300.0, 300.0, -77.0]) / 60.0,
        ];
        let [a, b, c, d] = inner.map(|value| values[0] + value);
        [values[0], a, b, c, d, values[DEGREE]].map(|value| value.clamp(low, high))
    }
}

/// The control points of a part of a segment.
fn part(segment: &Segment, ends: [f64; 2]) -> impl Iterator<Item = DVec2> {
    let points = segment.points();
    let count = points.len() - 1;
    (0..=count).map(move |j| {
        // The blossom at count − j times the first and j times the second end.
        let mut blended = points.to_vec();
        for round in 0..count {
            let t = ends[usize::from(round < j)];
            for i in 0..count - round {
                blended[i] = blended[i].lerp(blended[i + 1], t);
            }
        }
        blended[0]
    })
}

fn bernstein(coefficients: &[f64; DEGREE + 1], t: f64) -> f64 {
    let mut blended = *coefficients;
    for round in 0..DEGREE {
        for i in 0..DEGREE - round {
            blended[i] += t * (blended[i + 1] - blended[i]);
        }
    }
    blended[0]
}

/// The homogeneous point of the polynomial patch of a surface in the given spans.
fn homogeneous(surface: &NurbsSurface, spans: [usize; 2], uv: DVec2) -> DVec4 {
    let degree = surface.degree();
    let [u, v] = surface.knots();
    let u = Basis::in_span(degree.u(), u, spans[0], uv.x);
    let v = Basis::in_span(degree.v(), v, spans[1], uv.y);
    let rows = surface.control_points().chunks_exact(surface.columns());
    let mut value = DVec4::ZERO;
    for (row, by) in rows.skip(v.first).zip(&v.values[..=degree.v()]) {
        for (point, b) in row[u.first..][..=degree.u()].iter().zip(u.values) {
            value += (point.truncate() * point.w).extend(point.w) * (b * by);
        }
    }
    value
}

/// A bound of the length of the derivative of a patch of a surface along u (0) or v (1).
fn steepest(surface: &NurbsSurface, axis: usize, spans: [usize; 2]) -> f64 {
    let degrees = [surface.degree().u(), surface.degree().v()];
    let [columns, rows] = [0, 1].map(|axis| spans[axis] - degrees[axis]..spans[axis] + 1);
    let points = rows.flat_map(|row| {
        surface.control_points()[row * surface.columns()..][columns.clone()].iter()
    });
    let first = points.clone().next().map_or(DVec3::ZERO, |point| point.truncate());
    let (mut radius, mut weights) = (0.0_f64, [f64::INFINITY, 0.0_f64]);
    for point in points {
        radius = radius.max(point.truncate().distance(first));
        weights = [weights[0].min(point.w), weights[1].max(point.w)];
    }
    // The derivative is a blend of differences of weight times (point − surface), divided by the weight.
    let (degree, knots) = (degrees[axis], &surface.knots()[axis]);
    let span = spans[axis];
    let shortest = (span + 1 - degree..=span)
        .map(|i| knots[i + degree] - knots[i])
        .fold(f64::INFINITY, f64::min);
    degree as f64 * 4.0 * radius * weights[1] / weights[0] / shortest
}

/// Places where a segment crosses knots of the surface along u (0) or v (1).
fn crossings(face: &DrawnFace, segment: &Segment, axis: usize, found: &mut Vec<f64>) {
    /// A cubic changes its direction twice.
    const PARTS: u32 = 12;
    let degree = [face.surface.degree().u(), face.surface.degree().v()][axis];
    let knots = &face.surface.knots()[axis];
    let mut knots: Vec<f64> = knots[degree..knots.len() - degree].to_vec();
    knots.dedup();
    let controls = || segment.points().iter().map(|point| point[axis]);
    let [low, high] =
        [controls().fold(f64::INFINITY, f64::min), controls().fold(f64::NEG_INFINITY, f64::max)];
    let period = face.periods[axis];
    let turns = period.map_or(0..=0, |period| {
        let turn = |x: f64| (x / period).floor() as i32;
        turn(low - knots[knots.len() - 1])..=turn(high - knots[0]) + 1
    });
    for turn in turns {
        for knot in &knots {
            let value = knot + f64::from(turn) * period.unwrap_or(0.0);
            if !(low < value && value < high) {
                continue;
            }
            let off = |s: f64| segment.point(s)[axis] - value;
            for i in 0..PARTS {
                let [mut from, mut to] = [i, i + 1].map(|i| f64::from(i) / f64::from(PARTS));
                let is_above = off(from) > 0.0;
                if is_above == (off(to) > 0.0) {
                    continue;
                }
                for _ in 0..60 {
                    let middle = from.midpoint(to);
                    *if (off(middle) > 0.0) == is_above { &mut from } else { &mut to } = middle;
                }
                found.push(from.midpoint(to));
            }
        }
    }
}
