//! Trim curves of any degree with weights, and B-spline curves: they become lines and cubics with a certified error.
//!
//! A piece R of the curve is approximated by a cubic C with the same ends and directions there. C is compared with
//! R(φ(t)) for a polynomial φ of degree 5 that runs from 0 to 1: with R = N/w in homogeneous form, the distance is at
//! most that of the largest Bernstein coefficient of N(φ(t)) − C(t)·w(φ(t)) over the smallest of w(φ(t)). This holds
//! however C and φ were found. A piece for which it is too large is halved. The error falls with the sixth power of
//! the length of the piece.

use glam::{DVec2, DVec3};

use super::{MAX_SEGMENTS, ParameterSizes, SNAP, Segment, TrimLoop, check_finite};
use crate::bezier::{Degree, bezier_curves, check_knots, compositions, product, split_slice};
use crate::error::{Error, Result};

/// The largest distance between a curve and its segments, if the smallest patch has a size of 1 to 2.
const TOLERANCE: f64 = 1e-8;
/// Weights of a curve lie within this factor of 1.
const MAX_WEIGHT: f64 = 1e9;
/// The maximum number of times that a curve is halved. Curves with weights of the largest ratio take about 15; after
/// 200 the control points of a piece differ in no digit, so that a line is right.
const MAX_HALVINGS: u32 = 200;

/// A curve of a loop: Bézier curves of degrees 1 to 15, end to end, with weights.
#[derive(Debug, Clone, PartialEq)]
pub struct TrimCurve {
    /// Homogeneous control points (u·w, v·w, w) of each.
    pieces: Vec<Vec<DVec3>>,
}

impl TrimCurve {
    /// A Bézier curve of 2 to 16 control points (u, v, weight).
    ///
    /// # Errors
    /// Another number of points, a point that is not finite or has coordinates above 1e15, a weight that is not from
    /// 1e-9 to 1e9. Points are numbered from 0.
    pub fn bezier(points: &[DVec3]) -> Result<Self> {
        if !(2..=Degree::MAX + 1).contains(&points.len()) {
            return Err(Error::invalid("number of points of a segment", points.len(), "2 to 16"));
        }
        Ok(Self { pieces: vec![homogeneous(points)?] })
    }

    /// A B-spline curve of control points (u, v, weight) with its full knot vector: degree + 1 knots more than points,
    /// in rising order, with any multiplicity. The curve is that of the domain, from knot `degree` to knot
    /// `points.len()`, counted from 0.
    ///
    /// # Errors
    /// A degree that is not from 1 to 15, a wrong number of knots, knots that decrease or leave no domain, points as in
    /// [`TrimCurve::bezier`].
    pub fn nurbs(degree: usize, knots: &[f64], points: &[DVec3]) -> Result<Self> {
        Self::nurbs_part(degree, knots, points, [f64::NEG_INFINITY, f64::INFINITY])
    }

    /// The part of a B-spline curve between two parameters. It begins at the first of them, also if that is the greater
    /// one. Parameters beyond the domain stand for its ends.
    ///
    /// # Errors
    /// As [`TrimCurve::nurbs`]; a part without length.
    pub(crate) fn nurbs_part(
        degree: usize,
        knots: &[f64],
        points: &[DVec3],
        ends: [f64; 2],
    ) -> Result<Self> {
        check_knots(degree, knots, points.len())?;
        // The weights of the pieces are blends of the given ones.
        let points = homogeneous(points)?;
        let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let mut pieces: Vec<Vec<DVec3>> = Vec::new();
        // Blends of equal weights would differ from them by rounding.
        let equal = points.iter().all(|point| point.z == points[0].z).then_some(points[0].z);
        for ([start, end], mut piece) in bezier_curves(degree, knots, &points) {
            if let Some(weight) = equal {
                piece.iter_mut().for_each(|point| point.z = weight);
            }
            if start < high && low < end {
                let share = |t: f64| ((t - start) / (end - start)).clamp(0.0, 1.0);
                pieces.push(part(piece, [share(low), share(high)]));
            }
        }
        if pieces.is_empty() {
            let value = format!("from {} to {}", ends[0], ends[1]);
            return Err(Error::invalid("part of a curve", value, "a part of its domain"));
        }
        if ends[0] > ends[1] {
            pieces.reverse();
            pieces.iter_mut().for_each(|piece| piece.reverse());
        }
        Ok(Self { pieces })
    }

    /// Where it begins and ends.
    fn ends(&self) -> [DVec2; 2] {
        let [first, last] = [&self.pieces[0], &self.pieces[self.pieces.len() - 1]];
        [place(first[0]), place(last[last.len() - 1])]
    }

    /// Lines, quadratics and cubics: the curve itself, or within 1e-8 units of it. They end with the first piece
    /// beyond the number of segments that a loop may have.
    pub(crate) fn segments(&self, unit: DVec2, segments: &mut Vec<Segment>) {
        for piece in &self.pieces {
            if segments.len() > MAX_SEGMENTS {
                return;
            }
            let same_weight = piece.iter().all(|point| point.z == piece[0].z);
            let places: Vec<DVec2> = piece.iter().map(|point| place(*point)).collect();
            match Segment::new(&places) {
                Ok(segment) if same_weight => segments.push(segment),
                _ => {
                    // Relative to a point of the curve, so that few digits are lost far from the origin.
                    let origin = places[0];
                    let moved = |point: &DVec3| {
                        ((point.truncate() - origin * point.z) / unit).extend(point.z)
                    };
                    let piece: Vec<DVec3> = piece.iter().map(moved).collect();
                    let digits = 4.0 * f64::EPSILON * (origin / unit).abs().max_element();
                    let (start, end) = (places[0], places[places.len() - 1]);
                    let first = segments.len();
                    approximate(&piece, digits, 0, segments);
                    for segment in &mut segments[first..] {
                        *segment = segment.map(|place| origin + place * unit);
                    }
                    // The ends are those of the neighbours, bit for bit.
                    segments[first].points_mut()[0] = start;
                    if let Some(last) = segments.last_mut() {
                        let count = last.points().len();
                        last.points_mut()[count - 1] = end;
                    }
                }
            }
        }
    }
}

impl TrimLoop {
    /// A closed chain of curves in the domain [0, 1]². Their segments are at most 1e-8 away from them, and those that
    /// are lines, quadratics and cubics without weights stay exact. Gaps below 1e-6 are closed.
    ///
    /// # Errors
    /// As [`TrimLoop::new`]; it numbers the segments, of which a curve may have several.
    pub fn from_curves(curves: &[TrimCurve]) -> Result<Self> {
        Self::from_curves_over(curves, &ParameterSizes::default())
    }

    /// The same for a surface with any parameters. Distances are relative to its smallest patch, and gaps to its
    /// domain.
    ///
    /// # Errors
    /// As [`TrimLoop::from_curves`].
    pub fn from_curves_over(curves: &[TrimCurve], sizes: &ParameterSizes) -> Result<Self> {
        let mut segments = Vec::new();
        for curve in curves {
            curve.segments(sizes.unit(), &mut segments);
        }
        Self::closed(segments, sizes.domain)
    }

    /// The same for a chain whose curves may be further apart: a line closes each gap up to `max_gap`, which is a share
    /// of the domain.
    ///
    /// # Errors
    /// As [`TrimLoop::from_curves`], where lines that close gaps count as segments; a larger gap. Curves are numbered
    /// from 0.
    pub(crate) fn from_curves_with_gaps(
        curves: Vec<TrimCurve>,
        sizes: &ParameterSizes,
        max_gap: f64,
    ) -> Result<Self> {
        let ends: Vec<[DVec2; 2]> = curves.iter().map(TrimCurve::ends).collect();
        let mut chain = Vec::with_capacity(curves.len());
        for (i, curve) in curves.into_iter().enumerate() {
            chain.push(curve);
            let next = (i + 1) % ends.len();
            let (end, start) = (ends[i][1], ends[next][0]);
            let gap = ((start - end) / sizes.domain).length();
            if gap > max_gap {
                return Err(Error::invalid(
                    format!("gap between the end of curve {i} and the start of curve {next}"),
                    end.distance(start),
                    format!("at most {max_gap} of the domain: a closed loop"),
                ));
            }
            if gap >= SNAP {
                chain.push(TrimCurve::bezier(&[end.extend(1.0), start.extend(1.0)])?);
            }
        }
        Self::from_curves_over(&chain, sizes)
    }
}

/// Checks the points of a curve and multiplies them by their weights.
fn homogeneous(points: &[DVec3]) -> Result<Vec<DVec3>> {
    for (i, point) in points.iter().enumerate() {
        check_finite(&format!("point {i}"), point.truncate())?;
        if !(1.0 / MAX_WEIGHT..=MAX_WEIGHT).contains(&point.z) {
            let expected = "a number above 0, from 1e-9 to 1e9";
            return Err(Error::invalid(format!("weight of point {i}"), point.z, expected));
        }
    }
    Ok(points.iter().map(|point| (point.truncate() * point.z).extend(point.z)).collect())
}

/// The part of a Bézier curve between two parameters from 0 to 1.
fn part(mut points: Vec<DVec3>, [low, high]: [f64; 2]) -> Vec<DVec3> {
    if high < 1.0 {
        let mut after = points.clone();
        split_slice(&mut points, &mut after, |a, b| a.lerp(b, high));
    }
    if low > 0.0 {
        let mut before = points.clone();
        split_slice(&mut before, &mut points, |a, b| a.lerp(b, low / high));
    }
    points
}

fn place(point: DVec3) -> DVec2 {
    point.truncate() / point.z
}

/// Appends the segments of a Bézier curve. They need not be closer to it than `digits`.
fn approximate(points: &[DVec3], digits: f64, halvings: u32, segments: &mut Vec<Segment>) {
    let (start, end) = (place(points[0]), place(points[points.len() - 1]));
    // Far from the origin, `f64` has no digits for the tolerance.
    let size = points.iter().map(|point| place(*point).abs().max_element()).fold(1.0, f64::max);
    let tolerance = TOLERANCE.max(1e-14 * size).max(digits);
    let to_chord = |point: &DVec3| {
        let (along, off) = (end - start, place(*point) - start);
        let share = off.dot(along) / along.length_squared();
        // Both ends may be the same point.
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
        off.distance(share * along)
    };
    if points.iter().map(to_chord).fold(0.0, f64::max) <= tolerance || halvings == MAX_HALVINGS {
        segments.push(Segment::Line([start, end]));
        return;
    }
    let cubic = cubics(points).into_iter().flatten().find(|(cubic, inner)| {
        sampled_distance(points, cubic, inner) <= tolerance
            && distance_bound(points, cubic, inner) <= 0.9 * tolerance
    });
    if let Some((cubic, _)) = cubic {
        segments.push(Segment::Cubic(cubic));
        return;
    }
    let (mut before, mut after) = (points.to_vec(), points.to_vec());
    split_slice(&mut before, &mut after, |a, b| 0.5 * (a + b));
    approximate(&before, digits, halvings + 1, segments);
    approximate(&after, digits, halvings + 1, segments);
}

/// Newton's method ends at steps below this. The bound of the distance holds for any result.
const CONVERGED: f64 = 1e-12;

/// A cubic and the parameters on the curve that its parameters correspond to, a polynomial in Bernstein form.
type Candidate = ([DVec2; 4], [f64; 6]);

/// Cubics that may approximate a curve: one that is fitted to its shape, and one with its derivatives at the ends.
fn cubics(points: &[DVec3]) -> [Option<Candidate>; 2] {
    let [[start, at_start], [end, at_end]] = [0.0, 1.0].map(|t| with_derivative(points, t));
    let cubic =
        |by: [f64; 2]| [start, start + by[0] / 3.0 * at_start, end - by[1] / 3.0 * at_end, end];
    let same = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
    [fitted(points, cubic, [at_start, at_end]), Some((cubic([1.0; 2]), same))]
}

/// Fits the lengths of the derivatives at the ends so that the cubic meets the curve at ⅓ and ⅔.
fn fitted(
    points: &[DVec3],
    cubic: impl Fn([f64; 2]) -> [DVec2; 4],
    derivatives: [DVec2; 2],
) -> Option<Candidate> {
    const AT: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];
    let mut by = [1.0, 1.0];
    let mut on_curve = AT;
    for _ in 0..6 {
        let fit = Segment::Cubic(cubic(by));
        let mut rows = [[0.0; 3]; 2];
        for k in 0..2 {
            let at = fit.point(AT[k]);
            on_curve[k] = nearest(points, at, on_curve[k]);
            let [near, along] = with_derivative(points, on_curve[k]);
            let normal = along.try_normalize()?.perp();
            let (t, s) = (AT[k], 1.0 - AT[k]);
            // How far each length moves the cubic across the curve, and how far it is off.
            rows[k] = [
                s * s * t * normal.dot(derivatives[0]),
                -s * t * t * normal.dot(derivatives[1]),
                normal.dot(near - at),
            ];
        }
        let [[a, b, c], [d, e, f]] = rows;
        let determinant = a * e - b * d;
        let change = [(c * e - b * f) / determinant, (a * f - c * d) / determinant];
        if !change.iter().all(|change| change.is_finite()) {
            return None;
        }
        by = [by[0] + change[0], by[1] + change[1]];
        if !by.iter().all(|by| (0.1..10.0).contains(by)) {
            return None;
        }
        if change.iter().all(|change| change.abs() < CONVERGED) {
            break;
        }
    }
    let cubic = cubic(by);
    let fit = Segment::Cubic(cubic);
    for k in 0..2 {
        on_curve[k] = nearest(points, fit.point(AT[k]), on_curve[k]);
    }
    // φ has the values 0 and 1 and the derivatives `by` at the ends, and `on_curve` in between.
    let (c1, c4) = (by[0] / 5.0, 1.0 - by[1] / 5.0);
    let basis = |i: usize, t: f64| crate::bezier::bernstein(5, i, t);
    let rest =
        [0, 1].map(|k| on_curve[k] - c1 * basis(1, AT[k]) - c4 * basis(4, AT[k]) - basis(5, AT[k]));
    let [a, b, c, d] = [basis(2, AT[0]), basis(3, AT[0]), basis(2, AT[1]), basis(3, AT[1])];
    let determinant = a * d - b * c;
    let c2 = (rest[0] * d - b * rest[1]) / determinant;
    let c3 = (a * rest[1] - rest[0] * c) / determinant;
    let inner = [0.0, c1, c2, c3, c4, 1.0];
    inner.iter().all(|c| (0.0..=1.0).contains(c)).then_some((cubic, inner))
}

/// The point of a curve and its derivative.
fn with_derivative(points: &[DVec3], t: f64) -> [DVec2; 2] {
    let mut blended = [DVec3::ZERO; Degree::MAX + 1];
    blended[..points.len()].copy_from_slice(points);
    for count in (2..points.len()).rev() {
        for i in 0..count {
            blended[i] = blended[i].lerp(blended[i + 1], t);
        }
    }
    let degree = (points.len() - 1) as f64;
    let point = blended[0].lerp(blended[1], t);
    let derivative = degree * (blended[1] - blended[0]);
    let position = place(point);
    [position, (derivative.truncate() - position * derivative.z) / point.z]
}

/// The parameter of a point of the curve near `target`, by Newton's method from `t`.
fn nearest(points: &[DVec3], target: DVec2, mut t: f64) -> f64 {
    for _ in 0..3 {
        let [position, derivative] = with_derivative(points, t);
        let step = (target - position).dot(derivative) / derivative.length_squared();
        if !step.is_finite() {
            break;
        }
        t = (t + step).clamp(0.0, 1.0);
        if step.abs() < CONVERGED {
            break;
        }
    }
    t
}

/// The largest distance that [`distance_bound`] bounds, at a few parameters. It is found in a fraction of the time.
fn sampled_distance(points: &[DVec3], cubic: &[DVec2; 4], inner: &[f64; 6]) -> f64 {
    let fit = Segment::Cubic(*cubic);
    let distance = |t: f64| {
        let on_curve = (0..6).map(|i| inner[i] * crate::bezier::bernstein(5, i, t)).sum();
        let [position, _] = with_derivative(points, on_curve);
        position.distance(fit.point(t))
    };
    [0.2, 0.5].map(distance).into_iter().fold(0.0, f64::max)
}

/// An upper bound of the distance between a curve and a cubic, where the cubic's parameter t corresponds to the curve's
/// parameter `inner`(t). Infinite if no bound is known.
fn distance_bound(points: &[DVec3], cubic: &[DVec2; 4], inner: &[f64; 6]) -> f64 {
    // Relative to the start, so that fewer digits are lost.
    let start = cubic[0];
    let weight: Vec<f64> = points.iter().map(|point| point.z).collect();
    let [x, y] = [0, 1].map(|axis| {
        points.iter().map(|point| point[axis] - start[axis] * point.z).collect::<Vec<f64>>()
    });
    let [weight, x, y] = compositions([&weight, &x, &y], inner);
    let min_weight = weight.iter().copied().fold(f64::INFINITY, f64::min);
    if min_weight <= 0.0 {
        return f64::INFINITY;
    }
    let differences = [(0, x), (1, y)].map(|(axis, of_curve)| {
        let of_curve = product(&of_curve, &[1.0; 4]);
        let of_cubic = product(&weight, &cubic.map(|point| point[axis] - start[axis]));
        of_curve.iter().zip(of_cubic).map(|(a, b)| a - b).collect::<Vec<_>>()
    });
    let [x, y] = differences;
    let largest = x.iter().zip(y).map(|(x, y)| x.hypot(y)).fold(0.0, f64::max);
    largest / min_weight
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::bernstein;
    use glam::{dvec2, dvec3};
    use proptest::prelude::*;

    /// The point of a rational Bézier curve, by Bernstein polynomials.
    fn at(points: &[DVec3], t: f64) -> DVec2 {
        let degree = points.len() - 1;
        let weigh =
            |(i, p): (usize, &DVec3)| (p.truncate() * p.z).extend(p.z) * bernstein(degree, i, t);
        let sum: DVec3 = points.iter().enumerate().map(weigh).sum();
        sum.truncate() / sum.z
    }

    /// The distance of a point from the nearest of some segments.
    fn distance(point: DVec2, segments: &[Segment]) -> f64 {
        let to = |segment: &Segment, t: f64| segment.point(t).distance(point);
        let of = |segment: &Segment| {
            // Fine enough to tell the branches of cusps apart.
            const STEPS: usize = 1024;
            let (_, best) = (0..=STEPS)
                .map(|i| (to(segment, i as f64 / STEPS as f64), i))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            let [mut low, mut high] =
                [best as f64 - 1.0, best as f64 + 1.0].map(|i| (i / STEPS as f64).clamp(0.0, 1.0));
            for _ in 0..60 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if to(segment, a) < to(segment, b) { high = b } else { low = a }
            }
            to(segment, 0.5 * (low + high))
        };
        segments.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    fn segments_of(curve: &TrimCurve) -> Vec<Segment> {
        let mut segments = Vec::new();
        curve.segments(DVec2::ONE, &mut segments);
        segments
    }

    fn quarter_circles() -> Vec<TrimCurve> {
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let corners = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (-1.0, 1.0), (-1.0, 0.0), (-1.0, -1.0)];
        let corners = [&corners[..], &[(0.0, -1.0), (1.0, -1.0)]].concat();
        let point = |i: usize| {
            let (x, y) = corners[i % 8];
            dvec3(0.5 + 0.3 * x, 0.5 + 0.3 * y, if i.is_multiple_of(2) { 1.0 } else { s })
        };
        let arcs = (0..4).map(|i| [0, 1, 2].map(|j| point(2 * i + j)));
        arcs.map(|arc| TrimCurve::bezier(&arc).unwrap()).collect()
    }

    #[test]
    fn a_rational_circle_is_round_in_few_cubics() {
        let trim_loop = TrimLoop::from_curves(&quarter_circles()).unwrap();
        let mut furthest = 0.0_f64;
        for segment in trim_loop.segments() {
            for step in 0..=200 {
                let point = segment.point(f64::from(step) / 200.0);
                furthest = furthest.max((point.distance(DVec2::splat(0.5)) - 0.3).abs());
            }
        }
        assert!(furthest > 1e-13 && furthest <= TOLERANCE, "{furthest:e}");
        let count = trim_loop.segments().len();
        assert!(count <= 32, "{count} segments");
    }

    #[test]
    fn a_circle_as_one_nurbs_is_the_same() {
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let corners =
            [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
        let points: Vec<DVec3> = (0..)
            .zip(corners)
            .map(|(i, (x, y))| {
                let place = 0.5 + 0.3 * dvec2(f64::from(x), f64::from(y));
                place.extend(if i % 2 == 0 { 1.0 } else { s })
            })
            .collect();
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
        let circle = TrimCurve::nurbs(2, &knots, &points).unwrap();
        let [one, four] = [&[circle][..], &quarter_circles()]
            .map(|curves| TrimLoop::from_curves(curves).unwrap());
        assert_eq!(one.segments().len(), four.segments().len());
        for (one, four) in one.segments().iter().zip(four.segments()) {
            for (a, b) in one.points().iter().zip(four.points()) {
                assert!(a.distance(*b) < 1e-12, "{a} {b}");
            }
        }
    }

    #[test]
    fn what_is_a_line_quadratic_or_cubic_stays_exact() {
        for count in 2..=4 {
            for weight in [1.0, 0.3] {
                let points: Vec<DVec3> = (0..count)
                    .map(|i| dvec3(f64::from(i) / 4.0, f64::from(i * i % 3), weight))
                    .collect();
                let segments = segments_of(&TrimCurve::bezier(&points).unwrap());
                assert_eq!(segments.len(), 1);
                assert_eq!(segments[0].points().len(), count as usize);
                for (found, given) in segments[0].points().iter().zip(points) {
                    assert!(found.distance(given.truncate()) < 1e-15);
                }
            }
        }
        // Straight, whatever the weights are.
        let line = [(0.0, 1.0), (0.1, 20.0), (0.3, 0.5), (0.9, 3.0), (1.0, 1.0)];
        let line = line.map(|(t, weight)| dvec3(t, 0.25 + 0.5 * t, weight));
        let segments = segments_of(&TrimCurve::bezier(&line).unwrap());
        assert_eq!(segments, [Segment::Line([dvec2(0.0, 0.25), dvec2(1.0, 0.75)])]);
    }

    #[test]
    fn weights_of_the_largest_ratio_are_within_the_tolerance() {
        for count in [2, 4, 7, 16_u32] {
            let points: Vec<DVec3> = (0..count)
                .map(|i| {
                    let x = f64::from(i);
                    let weight = if i % 2 == 0 { 1e-9 } else { 1e9 };
                    dvec3(0.5 + 0.4 * x.sin(), 0.5 + 0.4 * (1.7 * x).cos(), weight)
                })
                .collect();
            let segments = segments_of(&TrimCurve::bezier(&points).unwrap());
            assert!(segments.len() < 2000, "{} segments of {count} points", segments.len());
            // Near the ends the curve takes very little of its parameter.
            for step in 0..=60 {
                let small = 0.5_f64.powi(step);
                for t in [small, 1.0 - small] {
                    let found = distance(at(&points, t), &segments);
                    assert!(found <= TOLERANCE, "{count} points at {t}: {found:e}");
                }
            }
        }
    }

    #[test]
    fn wrong_points_are_refused_by_number() {
        let refused = |points: &[DVec3], words: &[&str]| {
            let text = TrimCurve::bezier(points).unwrap_err().to_string();
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
        };
        refused(&[dvec3(0.0, 0.0, 1.0)], &["number of points", "is 1", "2 to 16"]);
        refused(&[DVec3::ONE; 17], &["number of points", "is 17", "2 to 16"]);
        refused(&[DVec3::ONE, dvec3(f64::NAN, 0.0, 1.0)], &["point 1", "finite"]);
        for weight in [0.0, -1.0, 1e10, f64::NAN] {
            refused(&[DVec3::ONE, dvec3(0.0, 0.0, weight)], &["weight of point 1", "above 0"]);
        }
    }

    proptest! {
        #[test]
        fn curves_of_all_degrees_are_within_the_tolerance(
            points in prop::collection::vec(
                (0.0..1.0_f64, 0.0..1.0_f64, -3.0..3.0_f64), 2..=16,
            ),
        ) {
            let points: Vec<DVec3> =
                points.iter().map(|(u, v, weight)| dvec3(*u, *v, weight.exp2())).collect();
            let segments = segments_of(&TrimCurve::bezier(&points).unwrap());
            prop_assert!(segments.len() < 400, "{} segments", segments.len());
            for pair in segments.windows(2) {
                prop_assert!(pair[0].end() == pair[1].start());
            }
            for step in 0..=29 {
                let found = distance(at(&points, f64::from(step) / 29.0), &segments);
                prop_assert!(found <= TOLERANCE, "{found:e}");
            }
        }
    }
}
