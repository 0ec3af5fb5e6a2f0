//! Edges in the parameters of the surfaces of their faces: the file's p-curve if it is accurate, else the projection of
//! the curve in space.

use glam::{DVec2, DVec3};

use super::sheet::{Sheet, solve};
use super::{BoundedCurve, Coedge, Curve, NurbsCurve};

/// An edge in the parameters of a face's surface, at any place along it.
pub(super) struct Trace<'a> {
    pub(super) sheet: &'a Sheet<'a>,
    pub(super) curve: TracedCurve<'a>,
    /// The first and the last parameter of the edge's curve or of the p-curve.
    pub(super) range: [f64; 2],
    /// Places along the edge and their (u, v). Neighbours are less than half a period apart.
    pub(super) samples: Vec<(f64, DVec2)>,
    /// (u, v) at the ends if they are singular points of the surface: the limit along the edge.
    limits: [Option<DVec2>; 2],
}

/// What an edge is computed from.
#[derive(Clone, Copy)]
pub(super) enum TracedCurve<'a> {
    /// The curve in space.
    Edge(&'a BoundedCurve),
    /// The file's p-curve.
    Pcurve(&'a NurbsCurve<DVec3>),
}

/// A place on an edge.
#[derive(Clone, Copy)]
pub(super) struct Traced {
    pub(super) uv: DVec2,
    /// The derivative of (u, v) along the edge.
    pub(super) slope: DVec2,
    /// The lengths of the surface's derivatives.
    pub(super) scale: DVec2,
}

/// Where p-curves are compared with their edges.
const CHECKS: usize = 33;

impl<'a> Trace<'a> {
    /// The file's p-curve.
    pub(super) fn of_pcurve(sheet: &'a Sheet<'a>, pcurve: &'a NurbsCurve<DVec3>) -> Self {
        let range = pcurve.domain();
        let places = places(range, pcurve.knots(), pcurve.degree(), 16);
        let samples = places.into_iter().map(|t| (t, pcurve.at(t)[0])).collect();
        Self { sheet, curve: TracedCurve::Pcurve(pcurve), range, samples, limits: [None; 2] }
    }

    /// The projection of an edge between two of its parameters. `near` are (u, v) near its start, or near its end if it
    /// is not followed forward.
    pub(super) fn of_edge(
        sheet: &'a Sheet<'a>,
        edge: &'a BoundedCurve,
        range: [f64; 2],
        forward: bool,
        near: Option<DVec2>,
    ) -> Self {
        let mut places = match &edge.curve {
            Curve::Line { .. } => even(range, 8),
            Curve::Circle { .. } | Curve::Ellipse { .. } => {
                even(range, ((range[1] - range[0]) / 0.3).ceil().clamp(8.0, 64.0) as u32)
            }
            Curve::Nurbs(curve) => places(range, curve.knots(), curve.degree(), 16),
        };
        if !forward {
            places.reverse();
        }
        let curve = TracedCurve::Edge(edge);
        let mut trace = Self { sheet, curve, range, samples: Vec::new(), limits: [None; 2] };
        let first = edge.curve.at(places[0])[0];
        let mut last = sheet.nearest(first, near);
        trace.samples.push((places[0], last));
        for pair in places.windows(2) {
            last = trace.march([pair[0], pair[1]], last, 0);
        }
        if !forward {
            trace.samples.reverse();
        }
        trace.find_limits();
        trace
    }

    /// Follows the edge from one place to the next, and appends the samples.
    fn march(&mut self, [from, to]: [f64; 2], last: DVec2, depth: u32) -> DVec2 {
        const MAX_DEPTH: u32 = 8;
        let TracedCurve::Edge(edge) = self.curve else { return last };
        let [_, slope] = edge.curve.at(from);
        let here = self.sheet.at(last);
        let (step, is_regular) = solve(&here, slope * (to - from), 0.0);
        let is_regular = is_regular && !self.sheet.singular(&here).contains(&true);
        let [point, slope_there] = edge.curve.at(to);
        let uv = self.sheet.nearest(point, Some(if is_regular { last + step } else { last }));
        let there = self.sheet.at(uv);
        let moved = |at: &crate::bezier::SurfacePoint| {
            (at.du * (uv.x - last.x)).length().max((at.dv * (uv.y - last.y)).length())
        };
        let expected = (to - from).abs() * slope.length().max(slope_there.length());
        let is_jump =
            moved(&here).min(moved(&there)) > 3.0 * expected + 10.0 * self.sheet.tolerance;
        if is_jump && depth < MAX_DEPTH {
            let middle = from.midpoint(to);
            let last = self.march([from, middle], last, depth + 1);
            return self.march([middle, to], last, depth + 1);
        }
        self.samples.push((to, uv));
        uv
    }

    /// The limits of (u, v) at ends that are singular points of the surface.
    fn find_limits(&mut self) {
        let [first, last] = self.range;
        for (end, t, inwards) in [(0, first, last - first), (1, last, first - last)] {
            let index = if end == 0 { 0 } else { self.samples.len() - 1 };
            let uv = self.samples[index].1;
            let singular = self.sheet.singular(&self.sheet.at(uv));
            if !singular.contains(&true) || self.samples.len() < 3 {
                continue;
            }
            let beside = if end == 0 { 1 } else { index - 1 };
            let mut near = self.samples[beside].1;
            let [c, b, a] = [3.0, 2.0, 1.0].map(|i| {
                near = self.locate(t + 1e-3 * i * inwards, near);
                near
            });
            let mut limit = 3.0 * a - 3.0 * b + c;
            for axis in 0..2 {
                if !singular[axis] {
                    limit[axis] = uv[axis];
                }
            }
            self.limits[end] = Some(limit);
            self.samples[index].1 = limit;
        }
    }

    /// The largest distance of the samples from the edge.
    pub(super) fn distance(&self) -> f64 {
        let TracedCurve::Edge(edge) = self.curve else { return 0.0 };
        let off =
            |(t, uv): &(f64, DVec2)| edge.curve.at(*t)[0].distance(self.sheet.at(*uv).position);
        self.samples.iter().map(off).fold(0.0, f64::max)
    }

    /// The nearest parameters to the edge's point at t.
    fn locate(&self, t: f64, near: DVec2) -> DVec2 {
        match self.curve {
            TracedCurve::Edge(edge) => self.sheet.nearest(edge.curve.at(t)[0], Some(near)),
            TracedCurve::Pcurve(pcurve) => pcurve.at(t)[0],
        }
    }

    /// A place between the samples, from those beside it.
    fn between(&self, t: f64) -> DVec2 {
        between(&self.samples, t)
    }

    /// The edge at t.
    pub(super) fn at(&self, t: f64) -> Traced {
        let (uv, slope) = match self.curve {
            TracedCurve::Pcurve(pcurve) => {
                let [uv, slope] = pcurve.at(t);
                (uv, Some(slope))
            }
            TracedCurve::Edge(_) => {
                let end = self.range.iter().position(|end| *end == t);
                let limit = end.and_then(|end| self.limits[end]);
                (limit.unwrap_or_else(|| self.locate(t, self.between(t))), None)
            }
        };
        let at = self.sheet.at(uv);
        let slope = slope.unwrap_or_else(|| self.slope(t, uv, &at));
        Traced { uv, slope, scale: DVec2::new(at.du.length(), at.dv.length()) }
    }

    fn slope(&self, t: f64, uv: DVec2, at: &crate::bezier::SurfacePoint) -> DVec2 {
        let TracedCurve::Edge(edge) = self.curve else { return DVec2::ZERO };
        let (slope, is_regular) = solve(at, edge.curve.at(t)[1], 0.0);
        if is_regular && !self.sheet.singular(at).contains(&true) {
            return slope;
        }
        let size = 1e-4 * (self.range[1] - self.range[0]);
        let [low, high] = [(t - size).max(self.range[0]), (t + size).min(self.range[1])];
        let at_place = |place: f64| {
            if place == t { uv } else { self.locate(place, self.between(place)) }
        };
        (at_place(high) - at_place(low)) / (high - low)
    }

    /// Where the parameter u (axis 0) or v (axis 1) has a value, at places where the edge crosses it.
    pub(super) fn crossings(&self, axis: usize, value: f64, found: &mut Vec<f64>) {
        for pair in self.samples.windows(2) {
            let [a, b] = [pair[0].1[axis] - value, pair[1].1[axis] - value];
            if a * b >= 0.0 {
                continue;
            }
            let [mut low, mut high] = [(pair[0].0, a), (pair[1].0, b)];
            let mut t = low.0 + (high.0 - low.0) * a / (a - b);
            for _ in 0..40 {
                let off = self.at(t).uv[axis] - value;
                if off * low.1 > 0.0 {
                    low = (t, off)
                } else {
                    high = (t, off)
                }
                let secant = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
                let next = if secant.is_finite() { secant } else { low.0.midpoint(high.0) };
                let moved = (next - t).abs();
                t = next;
                if moved <= 1e-12 * (self.range[1] - self.range[0]) {
                    break;
                }
            }
            found.push(t);
        }
    }

    /// Knots of the curve where it may have corners or jumps of curvature.
    pub(super) fn breaks(&self) -> Vec<f64> {
        match self.curve {
            TracedCurve::Pcurve(curve) => breaks(curve.knots(), curve.degree(), 0),
            TracedCurve::Edge(edge) => match &edge.curve {
                Curve::Nurbs(curve) => breaks(curve.knots(), curve.degree(), 1),
                _ => Vec::new(),
            },
        }
    }
}

/// (u, v) at a place between samples, from those beside it.
pub(super) fn between(samples: &[(f64, DVec2)], t: f64) -> DVec2 {
    let after = samples.partition_point(|(other, _)| *other <= t);
    let after = after.clamp(1, samples.len() - 1);
    let [(from, a), (to, b)] = [samples[after - 1], samples[after]];
    a.lerp(b, ((t - from) / (to - from)).clamp(0.0, 1.0))
}

/// Knots of the domain where a B-spline curve has at most so many continuous derivatives.
pub(super) fn breaks(knots: &[f64], degree: usize, derivatives: usize) -> Vec<f64> {
    let inside = &knots[degree..knots.len() - degree];
    let runs = inside.chunk_by(|a, b| a == b);
    runs.filter(|run| run.len() + derivatives >= degree).map(|run| run[0]).collect()
}

fn even([low, high]: [f64; 2], count: u32) -> Vec<f64> {
    let share = |i: u32| f64::from(i) / f64::from(count);
    (0..=count).map(|i| low * (1.0 - share(i)) + high * share(i)).collect()
}

/// Places in each span of a range, at least `min` in all.
fn places([low, high]: [f64; 2], knots: &[f64], degree: usize, min: usize) -> Vec<f64> {
    let inside = knots[degree..knots.len() - degree].iter().copied();
    let mut ends: Vec<f64> =
        [low].into_iter().chain(inside.filter(|t| low < *t && *t < high)).chain([high]).collect();
    ends.dedup();
    // Fewer would miss what a span does between its ends.
    let each = min.div_ceil(ends.len() - 1).max(degree + 1) as u32;
    let mut places: Vec<f64> = Vec::new();
    for pair in ends.windows(2) {
        places.pop();
        places.extend(even([pair[0], pair[1]], each));
    }
    places.dedup();
    places
}

/// The place on a curve nearest to a point, from a place nearby, and the distance.
pub(super) fn nearest_on(curve: &BoundedCurve, point: DVec3, mut t: f64) -> (f64, f64) {
    let [low, high] = curve.range;
    let [mut here, mut slope] = curve.curve.at(t);
    let (at_start, reach) = (here.distance(point), slope.length() * (high - low));
    if reach < 1e-9 * at_start && (t == low || t == high) {
        // An end where the curve stands still: no step leads away from it.
        let found = nearest_on(curve, point, t + 2e-3 * (low.midpoint(high) - t));
        return if found.1 < at_start { found } else { (t, at_start) };
    }
    for _ in 0..12 {
        let step = (point - here).dot(slope) / slope.length_squared();
        if !step.is_finite() {
            break;
        }
        // A step is halved if it goes too far, as at a sharp bend, or to an end from which no step leads back.
        let is_long = step.abs() > 1e-6 * (high - low);
        let tries = if is_long { 6 } else { 1 };
        let nearer = (0..tries).find_map(|halvings| {
            let next = (t + step * 0.5_f64.powi(halvings)).clamp(low, high);
            let at = curve.curve.at(next);
            let is_nearer = at[0].distance_squared(point) < here.distance_squared(point);
            let goes_on = at[1].length_squared() > 1e-18 * slope.length_squared();
            (is_nearer && (goes_on || !is_long)).then_some((next, at))
        });
        let Some((next, [there, slope_there])) = nearer else { break };
        let moved = (next - t).abs();
        (t, here, slope) = (next, there, slope_there);
        if moved <= 1e-12 * (high - low) {
            break;
        }
    }
    (t, here.distance(point))
}

/// The largest distance of a p-curve from its edge, at several places in each of its spans and at least at 33; infinite
/// if it does not follow the edge.
pub(super) fn pcurve_distance(
    sheet: &Sheet<'_>,
    pcurve: &NurbsCurve<DVec3>,
    edge: &BoundedCurve,
    tolerance: f64,
) -> f64 {
    let ([low, high], [first, last]) = (pcurve.domain(), edge.range);
    let mut largest: f64 = 0.0;
    let mut shift = 0.0;
    for s in places([low, high], pcurve.knots(), pcurve.degree(), CHECKS - 1) {
        let share = (s - low) / (high - low);
        let uv = pcurve.at(s)[0];
        let point = sheet.at(uv).position;
        let place = first + share * (last - first);
        let at_end = s == low || s == high;
        let (t, mut distance) = if at_end {
            (place, edge.curve.at(place)[0].distance(point))
        } else {
            nearest_on(edge, point, place)
        };
        if !at_end && distance > tolerance {
            distance = distance.min(nearest_on(edge, point, (place + shift).clamp(first, last)).1);
        }
        shift = t - place;
        largest = largest.max(distance);
        if largest > tolerance {
            return largest;
        }
    }
    largest
}

/// The parts of an edge between the poles of a surface that it goes through.
pub(super) fn parts(sheet: &Sheet<'_>, edge: &BoundedCurve) -> Vec<[f64; 2]> {
    const SAMPLES: u32 = 32;
    let tolerance = 10.0 * sheet.tolerance;
    let [low, high] = edge.range;
    let mut ends = vec![low];
    for pole in sheet.poles() {
        let distance = |t: &f64| edge.curve.at(*t)[0].distance_squared(*pole);
        let samples = even(edge.range, SAMPLES).into_iter();
        let Some(start) = samples.min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
            continue;
        };
        let (t, distance) = nearest_on(edge, *pole, start);
        let is_end = |end: f64| edge.curve.at(end)[0].distance(*pole) <= 10.0 * tolerance;
        if distance <= tolerance && !is_end(low) && !is_end(high) {
            ends.push(t);
        }
    }
    ends.push(high);
    ends.sort_by(f64::total_cmp);
    ends.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// The file's p-curve of an edge if it lies within a distance of the edge.
pub(super) fn accurate_pcurve<'a>(
    sheet: &Sheet<'_>,
    coedge: &'a Coedge,
    edge: &BoundedCurve,
    tolerance: f64,
) -> Option<&'a NurbsCurve<DVec3>> {
    let pcurve = coedge.pcurve.as_ref()?;
    (pcurve_distance(sheet, pcurve, edge, tolerance) <= tolerance).then_some(pcurve)
}
