//! De Casteljau's algorithm as a subdivision: one Bézier curve becomes two.

/// Splits a Bézier curve of any degree: the control points before and after the cut.
///
/// `between` blends two points at the parameter of the cut. It is the caller's, so that points may be of any
/// type (vectors, coordinates, SIMD lanes) and round as the caller needs.
#[inline(always)]
pub(crate) fn split<T: Copy, const N: usize>(
    points: &[T; N],
    between: impl Fn(T, T) -> T,
) -> [[T; N]; 2] {
    let (mut before, mut after) = (*points, *points);
    split_slice(&mut before, &mut after, between);
    [before, after]
}

/// The same in place: both slices hold the control points of the curve, and then those of its two pieces.
#[inline(always)]
pub(crate) fn split_slice<T: Copy>(before: &mut [T], after: &mut [T], between: impl Fn(T, T) -> T) {
    let count = before.len();
    for (step, before) in before.iter_mut().enumerate().skip(1) {
        for i in 0..count - step {
            after[i] = between(after[i], after[i + 1]);
        }
        *before = after[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::bernstein;

    #[test]
    fn both_pieces_are_the_curve() {
        let points = [0.3, -1.0, 4.0, 0.5, 2.0];
        let at = |points: &[f64], t: f64| -> f64 {
            points.iter().enumerate().map(|(i, p)| bernstein(points.len() - 1, i, t) * p).sum()
        };
        for cut in [0.25, 0.5, 0.9] {
            let [before, after] = split(&points, |a, b| a * (1.0 - cut) + b * cut);
            assert_eq!((before[0], before[4], after[4]), (points[0], after[0], points[4]));
            for t in [0.0, 0.3, 1.0] {
                assert!((at(&before, t) - at(&points, cut * t)).abs() < 1e-14);
                assert!((at(&after, t) - at(&points, cut + (1.0 - cut) * t)).abs() < 1e-14);
            }
        }
    }
}
