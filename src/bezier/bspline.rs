//! B-spline curves as Bézier curves.

use crate::bezier::Degree;
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
    if let Some(index) = knots.iter().position(|knot| !knot.is_finite()) {
        return Err(Error::invalid(format!("knot {index}"), knots[index], "a finite number"));
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

/// The Bézier curves of a B-spline curve, one for each span of its domain that is not empty: where the span begins and
/// ends, and its control points. The knots may have any multiplicity; the curve need not begin and end in control
/// points. `between` blends two points at a parameter.
///
/// A control point of a Bézier curve is the blossom of the polynomial at the ends of the span, and de Boor's algorithm
/// with several parameters evaluates the blossom (Ramshaw 1989).
pub(crate) fn bezier_curves<T: Copy>(
    degree: usize,
    knots: &[f64],
    points: &[T],
    between: impl Fn(T, T, f64) -> T,
) -> Vec<([f64; 2], Vec<T>)> {
    let spans = (degree..points.len()).filter(|span| knots[*span] < knots[span + 1]);
    let curve = |span: usize| {
        let ends = [knots[span], knots[span + 1]];
        let control_point = |i: usize| {
            let mut blended = points[span - degree..=span].to_vec();
            for round in 1..=degree {
                let parameter = ends[usize::from(round > degree - i)];
                for j in (round..=degree).rev() {
                    let [low, high] = [knots[j + span - degree], knots[j + 1 + span - round]];
                    let share = (parameter - low) / (high - low);
                    blended[j] = between(blended[j - 1], blended[j], share);
                }
            }
            blended[degree]
        };
        (ends, (0..=degree).map(control_point).collect())
    };
    spans.map(curve).collect()
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
            let curves = bezier_curves(degree, knots, &points, |a, b, t| a * (1.0 - t) + b * t);
            assert_eq!(curves[0].0[0], knots[degree]);
            assert_eq!(curves.last().unwrap().0[1], knots[count]);
            for ([start, end], curve) in curves {
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
