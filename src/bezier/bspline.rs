//! B-spline curves as Bézier curves.

use std::ops::Range;

use crate::bezier::{Degree, MAX_COORDINATE};
use crate::error::{Error, Result};

/// Checks a knot vector for a curve of `points` control points.
///
/// # Errors
/// A degree that is not from 1 to 15, a number of knots other than points + degree + 1, a knot that is not finite,
/// knots that decrease, fewer points than the degree asks for, knots that leave no domain.
pub(crate) fn check_knots(degree: usize, knots: &[f64], points: usize) -> Result<()> {
    if !(1..=Degree::MAX).contains(&degree) {
        return Err(Error::invalid("degree", degree, "1 to 15"));
    }
    if points <= degree {
        let expected = format!("at least {} for degree {degree}", degree + 1);
        return Err(Error::invalid("number of points", points, expected));
    }
    if knots.len() != points + degree + 1 {
        let expected = format!("{}, points + degree + 1", points + degree + 1);
        return Err(Error::invalid("number of knots", knots.len(), expected));
    }
    let is_usual = |knot: &f64| knot.is_finite() && knot.abs() <= MAX_COORDINATE;
    if let Some(index) = knots.iter().position(|knot| !is_usual(knot)) {
        let expected = "a finite number of size at most 1e15";
        return Err(Error::invalid(format!("knot {index}"), knots[index], expected));
    }
    if let Some(index) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
        let (knot, before) = (knots[index + 1], knots[index]);
        let expected = format!("at least {before}, the knot before it");
        return Err(Error::invalid(format!("knot {}", index + 1), knot, expected));
    }
    let [first, last] = [knots[degree], knots[points]];
    if first >= last {
        let name = format!("domain from knot {degree} to knot {points}");
        return Err(Error::invalid(name, format!("{first} to {last}"), "a range above 0"));
    }
    Ok(())
}

/// A span of a B-spline curve that is not empty, as a Bézier curve.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Span {
    /// The parameters where it begins and ends.
    pub(crate) ends: [f64; 2],
    /// The index of the first of the degree + 1 control points that it depends on.
    pub(crate) first: usize,
    /// The factors of these control points, for each point of the Bézier curve.
    pub(super) factors: Vec<f64>,
    /// Whether the curve goes on continuously into the next span.
    pub(crate) continues: bool,
}

impl Span {
    /// The control points of the Bézier curve; `points` are those of the B-spline curve. Control points that a blend
    /// does not depend on do not change its bits.
    pub(crate) fn bezier<T: Blend>(&self, points: &[T]) -> impl Iterator<Item = T> {
        let count = self.factors.len().isqrt();
        let points = &points[self.first..][..count];
        self.factors.chunks_exact(count).map(move |factors| {
            let used = factors.iter().zip(points).filter(|(factor, _)| **factor != 0.0);
            let terms = used.map(|(factor, point)| *point * *factor);
            terms.reduce(|sum, term| sum + term).expect("the factors have the sum 1")
        })
    }
}

/// Points that can be blended.
pub(crate) trait Blend:
    Copy + std::ops::Mul<f64, Output = Self> + std::ops::Add<Output = Self>
{
}

impl<T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>> Blend for T {}

/// The spans of a domain that are not empty, for knots that [`check_knots`] has accepted. Knots may have any
/// multiplicity, and the curve need not begin and end in control points. Spans that are too short for `f64` are left
/// out.
///
/// A control point of a Bézier curve is the blossom of the polynomial at the ends of the span, and de Boor's algorithm
/// with several parameters evaluates the blossom (Ramshaw 1989).
pub(crate) fn spans(degree: usize, knots: &[f64]) -> Vec<Span> {
    /// Relative to the domain and to the knots. The ends of a shorter span are one parameter, written with rounding.
    const SHORTEST: [f64; 2] = [1e-12, 4.0 * f64::EPSILON];
    let last = knots.len() - degree - 1;
    let [low, high] = [knots[degree], knots[last]];
    let shortest = SHORTEST[0] * (high - low) + SHORTEST[1] * low.abs().max(high.abs());
    let length = |span: usize| knots[span + 1] - knots[span];
    let longest = (degree..last).map(length).fold(0.0, f64::max);
    let is_long = |span: &usize| length(*span) > shortest.min(0.5 * longest);
    let mut spans: Vec<Span> = Vec::new();
    for span in (degree..last).filter(is_long) {
        let ends = [knots[span], knots[span + 1]];
        if let Some(before) = spans.last_mut() {
            // The span before depends on the control points from `first` to `first + degree`.
            before.continues = before.first + degree >= span - degree;
        }
        let factors = (0..=degree).flat_map(|i| factors(degree, knots, span, i)).collect();
        spans.push(Span { ends, first: span - degree, factors, continues: false });
    }
    spans
}

/// The factors of the control points of a span in point `i` of its Bézier curve.
fn factors(degree: usize, knots: &[f64], span: usize, i: usize) -> Vec<f64> {
    let ends = [knots[span], knots[span + 1]];
    let one = |point: usize| {
        let mut blended = vec![0.0; degree + 1];
        blended[point] = 1.0;
        for round in 1..=degree {
            let parameter = ends[usize::from(round > degree - i)];
            for j in (round..=degree).rev() {
                let [low, high] = [knots[j + span - degree], knots[j + 1 + span - round]];
                let share = (parameter - low) / (high - low);
                blended[j] = blended[j - 1] * (1.0 - share) + blended[j] * share;
            }
        }
        blended[degree]
    };
    (0..=degree).map(one).collect()
}

/// The Bézier curves of a B-spline curve, one for each span, with the parameters where they begin and end. Neighbours
/// share their common end bit for bit where the curve is continuous.
pub(crate) fn bezier_curves<T: Blend>(
    degree: usize,
    knots: &[f64],
    points: &[T],
) -> Vec<([f64; 2], Vec<T>)> {
    let spans = spans(degree, knots);
    let curve = |span: &Span| (span.ends, span.bezier(points).collect::<Vec<T>>());
    let mut curves: Vec<_> = spans.iter().map(curve).collect();
    for i in 1..curves.len() {
        if spans[i - 1].continues {
            curves[i - 1].1[degree] = curves[i].1[0];
        }
    }
    curves
}

/// The control points that a B-spline curve depends on between two parameters `low` < `high` of its domain. With the
/// knots from the first of them on, degree + 1 more than points, they are a B-spline curve too, which agrees with the
/// given one there.
pub(crate) fn points_between(degree: usize, knots: &[f64], [low, high]: [f64; 2]) -> Range<usize> {
    let inside = &knots[degree..knots.len() - degree];
    // The span that begins at the last knot up to `low`, and the one that begins at the last knot before `high`.
    let first = inside.partition_point(|knot| *knot <= low).saturating_sub(1);
    let last = inside.partition_point(|knot| *knot < high).saturating_sub(1).max(first);
    first..last + degree + 1
}

/// The knots of a B-spline curve that consists of Bézier curves. `breaks` are the parameters where they begin and end.
pub(crate) fn knots_of_bezier_curves(degree: usize, breaks: &[f64]) -> Vec<f64> {
    let ends = [breaks.first(), breaks.last()].map(|end| end.copied());
    let inner = breaks.iter().flat_map(|knot| std::iter::repeat_n(*knot, degree));
    ends[0].into_iter().chain(inner).chain(ends[1]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::bernstein;

    /// The B-spline basis function by its recursive definition (Cox, de Boor).
    fn basis(i: usize, degree: usize, knots: &[f64], t: f64) -> f64 {
        if degree == 0 {
            return f64::from(u8::from(knots[i] <= t && t < knots[i + 1]));
        }
        let share = |from: usize, to: usize, over: f64| {
            if knots[to] > knots[from] { over / (knots[to] - knots[from]) } else { 0.0 }
        };
        share(i, i + degree, t - knots[i]) * basis(i, degree - 1, knots, t)
            + share(i + 1, i + degree + 1, knots[i + degree + 1] - t)
                * basis(i + 1, degree - 1, knots, t)
    }

    #[test]
    fn bezier_curves_are_the_b_spline_of_the_recursive_definition() {
        for (degree, knots) in [
            (1, &[0.0, 0.0, 0.5, 1.0, 1.0][..]),
            (2, &[0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 4.0, 4.0, 4.0]),
            // Periodic: the curve begins and ends between control points.
            (3, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
            (3, &[-1.0, -0.5, 0.0, 0.0, 0.1, 2.0, 2.0, 2.0, 2.0, 3.0, 5.0]),
            (5, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.5, 1.5, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]),
        ] {
            let count = knots.len() - degree - 1;
            let points: Vec<f64> = (0..count).map(|i| (1.7 * i as f64).sin()).collect();
            check_knots(degree, knots, count).unwrap();
            let spans = spans(degree, knots);
            assert_eq!(spans[0].ends[0], knots[degree]);
            assert_eq!(spans.last().unwrap().ends[1], knots[count]);
            for (span, (ends, curve)) in spans.iter().zip(bezier_curves(degree, knots, &points)) {
                assert_eq!(ends, span.ends);
                let [start, end] = ends;
                for step in 0..10 {
                    let local = f64::from(step) / 10.0;
                    let t = start + (end - start) * local;
                    let expected: f64 =
                        (0..count).map(|i| points[i] * basis(i, degree, knots, t)).sum();
                    let found: f64 =
                        (0..=degree).map(|i| curve[i] * bernstein(degree, i, local)).sum();
                    assert!((found - expected).abs() < 1e-13, "degree {degree} at {t}");
                }
            }
        }
    }

    #[test]
    fn the_points_between_two_parameters_are_the_same_curve_there() {
        let (degree, knots) = (2, [0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0]);
        let points: Vec<f64> = (0..7).map(|i| (1.7 * f64::from(i)).sin()).collect();
        let all = bezier_curves(degree, &knots, &points);
        for (ends, points_there, spans) in [
            ([0.0, 4.0], 0..7, 0..4),
            ([0.0, 0.5], 0..3, 0..1),
            ([0.5, 1.0], 0..3, 0..1),
            ([1.0, 1.5], 1..4, 1..2),
            ([1.5, 2.0], 1..4, 1..2),
            ([2.0, 2.1], 3..6, 2..3),
            ([0.9, 3.1], 0..7, 0..4),
            ([3.9, 4.0], 4..7, 3..4),
        ] {
            let there = points_between(degree, &knots, ends);
            assert_eq!(there, points_there, "{ends:?}");
            let knots = &knots[there.start..there.end + degree + 1];
            check_knots(degree, knots, there.len()).unwrap();
            let found = bezier_curves(degree, knots, &points[there]);
            assert_eq!(found.len(), spans.len(), "{ends:?}");
            for ((found_ends, found), (ends, curve)) in found.iter().zip(&all[spans]) {
                assert_eq!(found_ends, ends);
                for (found, point) in found.iter().zip(curve) {
                    assert!((found - point).abs() < 1e-14, "{ends:?}: {found} {point}");
                }
            }
        }
    }

    #[test]
    fn bezier_curves_as_one_b_spline_stay_as_they_are() {
        let breaks = [-1.0, 0.5, 3.0];
        let knots = knots_of_bezier_curves(3, &breaks);
        assert_eq!(knots, [-1.0, -1.0, -1.0, -1.0, 0.5, 0.5, 0.5, 3.0, 3.0, 3.0, 3.0]);
        let points = [0.1, 0.7, -0.3, 0.9, 1.3, 0.2, 0.6];
        let curves = bezier_curves(3, &knots, &points);
        assert_eq!(
            curves,
            [([-1.0, 0.5], points[..4].to_vec()), ([0.5, 3.0], points[3..].to_vec())]
        );
    }

    #[test]
    fn wrong_knots_are_refused_by_name() {
        for (degree, knots, points, words) in [
            (0, &[0.0, 1.0][..], 1, ["degree", "is 0", "1 to 15"]),
            (16, &[0.0, 1.0], 1, ["degree", "is 16", "1 to 15"]),
            (2, &[0.0, 0.0, 0.0, 1.0, 1.0], 2, ["number of points", "is 2", "at least 3"]),
            (1, &[0.0, 0.0, 1.0], 2, ["number of knots", "is 3", "4, points"]),
            (1, &[0.0, f64::NAN, 1.0, 1.0], 2, ["knot 1", "NaN", "finite"]),
            (1, &[0.0, 0.5, 0.25, 1.0], 2, ["knot 2", "0.25", "at least 0.5"]),
            (1, &[0.0, 1.0, 1.0, 1.0], 2, ["domain from knot 1 to knot 2", "1 to 1", "above 0"]),
        ] {
            let text = check_knots(degree, knots, points).unwrap_err().to_string();
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
        }
    }
}
